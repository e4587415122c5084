// Memory in proportion to the file: every parser of text reads the file that costs it most, in a child whose peak is
// measured. VIEWWORTH_PARSER_BYTES=N measures files of N bytes.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/csv.h"
#include "base/json.h"
#include "ledger/step_log.h"
#include "scene/formats/colmap.h"
#include "scene/formats/nerfw_tsv.h"
#include "scene/formats/photo_list.h"
#include "support/cmocka_test.h"
#include "support/temporary_folder.h"

enum { FILE_BYTES = 4 << 20, RATIO = VW_JSON_MEMORY_RATIO + 4, BASE_BYTES = VW_JSON_MEMORY_BASE_BYTES };

static size_t file_bytes; // size of every file

struct hostile {
    const char *what, *file;
    const char *head, *repeated, *tail; // parts of the file; %u in `repeated` counts
    void (*read)(const char *path);
    bool text_only; // no base: what the parser keeps is in proportion from the first byte
};

static char scene_folder[200];

// ---- Readers, in the child -----------------------------------------------------------------------------------------

static void read_json(const char *path) {
    AUTO_FREE void *text = NULL;
    size_t size_bytes = 0;
    if (vw_file_read(path, SIZE_MAX / 2, &text, &size_bytes)) return;
    json_t *value = vw_json_load(text, size_bytes, 0, NULL);
    json_decref(value);
}

static void read_csv(const char *path) {
    AUTO(vw_csv_close) struct vw_csv csv;
    bool found = true;
    enum vw_status status = vw_csv_open(path, SIZE_MAX / 2, &csv);
    while (!status && found) status = vw_csv_next(&csv, &found);
}

static void read_tsv(const char *path) {
    struct vw_tsv tsv = {0};
    if (!vw_tsv_read(NULL, path, &tsv)) vw_tsv_clear(&tsv);
}

static enum vw_status ignore_name(void *context, int line, const char *name) {
    (void)context, (void)line, (void)name;
    return VW_OK;
}

static void read_names(const char *path) {
    uint32_t count = 0;
    (void)vw_names_read(path, ignore_name, NULL, &count);
}

static void read_step_log(const char *path) {
    AUTO(vw_step_log_clear) struct vw_step_log log;
    (void)vw_step_log_read(path, &log);
}

static void read_colmap(const char *path) {
    (void)path;
    struct vw_colmap_model model = {0};
    if (!vw_colmap_read(scene_folder, scene_folder, &model)) vw_colmap_clear(&model);
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static const char camera[] = "1 SIMPLE_PINHOLE 8 6 8 4 3\n";
static const struct hostile hostiles[] = {
    {"JSON of digits", "a.json", "[", "0,", "0]", read_json, false},
    {"JSON of empty arrays", "a.json", "[", "[],", "0]", read_json, false},
    {"JSON of empty objects", "a.json", "[", "{},", "0]", read_json, false},
    {"JSON of empty texts", "a.json", "[", "\"\",", "0]", read_json, false},
    {"JSON of keys", "a.json", "{", "\"%u\":0,", "\"a\":0}", read_json, false},
    {"JSON of matrices", "a.json", "[", "[[0.123456789,0.123456789],[0.123456789,0.123456789]],", "0]", read_json,
     false},
    {"CSV of commas", "a.csv", "", ",", "\n", read_csv, true},
    {"CSV of short rows", "a.csv", "", "a,b\n", "", read_csv, true},
    {"TSV of short rows", "a.tsv", "filename\tsplit\n", "%u\ttest\n", "", read_tsv, true},
    {"TSV of tabs", "a.tsv",
     "filename\tsplit"
     "\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\n",
     "%u\ttest"
     "\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\t\n",
     "", read_tsv, true},
    {"names", "a.txt", "", "a\n", "", read_names, true},
    {"step log", "a.csv", "step,epoch,photo,psnr,l1\n0,0,,1,1\n", "%u,0,a,1,1\n", "", read_step_log, true},
    {"COLMAP text images", "images.txt", "", "%u 1 0 0 0 0 0 0 1 %u\n\n", "", read_colmap, true},
    {"COLMAP text features", "images.txt", "1 1 0 0 0 0 0 0 1 a\n", "0 0 0 ", "\n", read_colmap, true},
    {"COLMAP text points", "points3D.txt", "", "%u 0 0 0 0 0 0 0\n", "", read_colmap, true},
    {"COLMAP text tracks", "points3D.txt", "1 0 0 0 0 0 0 0 ", "1 0 ", "\n", read_colmap, true},
};

static const char *write_hostile(const char *folder, const struct hostile *hostile) {
    temporary_file(folder, "cameras.txt", camera);
    temporary_file(folder, "images.txt", "1 1 0 0 0 0 0 0 1 a\n0 0 1\n");
    temporary_file(folder, "points3D.txt", "");
    const char *path = temporary_file(folder, hostile->file, "");
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(hostile->head, file);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    size_t written = 0;
    for (uint32_t i = 1; written < file_bytes; i++) written += (size_t)fprintf(file, hostile->repeated, i, i);
#pragma GCC diagnostic pop
    fputs(hostile->tail, file);
    assert_int_equal(fclose(file), 0);
    return path;
}

// Returns the peak of a child, in bytes. With `hostile` NULL it reads nothing.
static size_t measure(const struct hostile *hostile, const char *path) {
    struct rusage used;
    int result = 0;
    fflush(stdout);
    pid_t child = fork();
    if (child == 0) {
        if (hostile) hostile->read(path);
        if (getenv("VIEWWORTH_PARSER_BYTES")) fprintf(stderr, "%s\n", vw_error_message());
        _exit(0);
    }
    assert_int_equal(wait4(child, &result, 0, &used), child);
    assert_int_equal(result, 0);
    return (size_t)used.ru_maxrss * 1024;
}

FOLDER_TEST(memory_is_in_proportion) {
    const char *given = getenv("VIEWWORTH_PARSER_BYTES");
    bool large = false;
    file_bytes = given ? strtoull(given, NULL, 10) : FILE_BYTES;
#ifdef __SANITIZE_ADDRESS__
    skip(); // the sanitizer's own memory is many times that of the program
#endif
    snprintf(scene_folder, sizeof scene_folder, "%s", (char *)*state);
    size_t nothing_bytes = measure(NULL, NULL);
    for (size_t i = 0; i < sizeof hostiles / sizeof *hostiles; i++) {
        const struct hostile *hostile = &hostiles[i];
        const char *path = write_hostile(*state, hostile);
        size_t peak_bytes = measure(hostile, path) - nothing_bytes;
        size_t limit_bytes = RATIO * file_bytes + (hostile->text_only ? 2 << 20 : BASE_BYTES);
        print_message("%-24s %5.1f times the file, %zu MiB\n", hostile->what, (double)peak_bytes / (double)file_bytes,
                      peak_bytes >> 20);
        large |= peak_bytes > limit_bytes;
    }
    assert_false(large);
}

// ---- Values --------------------------------------------------------------------------------------------------------

static void assert_json(json_t *value, const char *expected) {
    AUTO_FREE char *text = json_dumps(value, JSON_COMPACT | JSON_SORT_KEYS | JSON_ENCODE_ANY);
    assert_string_equal(text, expected);
    json_decref(value);
}

TEST(values_are_appended_and_set) {
    json_t *array = json_array(), *object = json_object();
    vw_json_append(&array, json_integer(1));
    vw_json_append(&array, vw_json_real(NAN));
    vw_json_set(&object, "a", array);
    vw_json_set(&object, "b", json_true());
    assert_json(object, "{\"a\":[1,null],\"b\":true}");
}

TEST(a_missing_value_drops_the_container) {
    json_t *array = json_array(), *object = json_object();
    vw_json_append(&array, NULL);
    assert_null(array);
    vw_json_append(&array, json_integer(1)); // dropped, too
    assert_null(array);
    vw_json_set(&object, "a", array);
    assert_null(object);
    vw_json_set(&object, "b", json_true());
    assert_null(object);
}
