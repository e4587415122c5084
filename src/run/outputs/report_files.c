#include "run/outputs/report_files.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "run/next/next.h"
#include "run/outputs/reconstruction.h"
#include "run/outputs/residuals.h"
#include "run/outputs/scene_map.h"

enum { TABLE_LIMIT_BYTES = 16 << 20, RENDER_LIMIT_BYTES = 32 << 20 };

// Adds a document, which owns from now on what it points to.
static struct vw_report_document *add_document(struct vw_report_files *files, const char *out, const char *kind,
                                               const char *file) {
    if (vw_grow((void **)&files->documents, &files->capacity, files->count + 1, sizeof *files->documents)) return NULL;
    struct vw_report_document *document = &files->documents[files->count++];
    *document = (struct vw_report_document){.kind = kind, .label = vw_copy_text(out), .file = file};
    return document->label ? document : NULL;
}

// ---- Shapes -------------------------------------------------------------------------

static bool has_text(const json_t *array, const char *text) {
    for (size_t i = 0; i < json_array_size(array); i++)
        if (strcmp(json_string_value(json_array_get(array, i)), text) == 0) return true;
    return false;
}

// Checks that a table, which people may have edited, has the columns that the script needs (NULL ends them). Further
// columns are allowed.
static enum vw_status check_table(const char *path, const char *const *columns, const json_t *header) {
    for (; *columns; columns++)
        if (!has_text(header, *columns))
            return vw_fail(VW_ERROR_INPUT, "%s: lacks the column %s; make it again, or remove it", path, *columns);
    return VW_OK;
}

// Checks each item and returns 0 for a match, like jansson; `error` says what does not match.
static int check_each(json_t *array, int (*check)(json_t *, json_error_t *), json_error_t *error) {
    for (size_t i = 0; i < json_array_size(array); i++)
        if (check(json_array_get(array, i), error)) return -1;
    return 0;
}

static int check_text(json_t *text, json_error_t *error) {
    return json_unpack_ex(text, error, JSON_VALIDATE_ONLY, "s");
}

static int check_seed(json_t *seed, json_error_t *error) {
    return json_unpack_ex(seed, error, JSON_VALIDATE_ONLY, "I");
}

static int check_outcome(json_t *outcome, json_error_t *error) {
    return json_unpack_ex(outcome, error, JSON_VALIDATE_ONLY, "{s:I, s:I}", "seed", "photo_count");
}

static int check_list(json_t *list, json_error_t *error) {
    return json_unpack_ex(list, error, JSON_VALIDATE_ONLY, "{s:s, s:[], s:{}, s:{}}", "name", "outcomes", "mean",
                          "stderr") ||
           check_each(json_object_get(list, "outcomes"), check_outcome, error);
}

static int check_pair(json_t *pair, json_error_t *error) {
    return json_unpack_ex(pair, error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:s, s:b}", "list", "against", "measure",
                          "beyond_noise");
}

static int check_disagreement(json_t *photo, json_error_t *error) {
    return json_unpack_ex(photo, error, JSON_VALIDATE_ONLY, "{s:s, s:[], s:[]}", "photo", "in", "not_in") ||
           check_each(json_object_get(photo, "in"), check_text, error) ||
           check_each(json_object_get(photo, "not_in"), check_text, error);
}

static int check_render(json_t *render, json_error_t *error) {
    return json_unpack_ex(render, error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:s, s:[]}", "view", "split", "file",
                          "columns") ||
           check_each(json_object_get(render, "columns"), check_text, error);
}

static enum vw_status check_comparison(const char *path, json_t *compare) {
    static const struct {
        const char *name;
        int (*check)(json_t *, json_error_t *);
    } arrays[] = {{"seeds", check_seed},
                  {"lists", check_list},
                  {"pairs", check_pair},
                  {"disagreements", check_disagreement},
                  {"renders", check_render}};
    json_error_t error;
    const char *where = "the whole";
    int broken = json_unpack_ex(
        compare, &error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:i, s:i, s?b, s:[], s:[], s:[], s:[], s:[]}", "scene",
        "scene_hash", "downscale", "epochs", "half_views", "seeds", "lists", "pairs", "disagreements", "renders");
    for (size_t i = 0; i < VW_ARRAY_COUNT(arrays) && !broken; i++) {
        where = arrays[i].name;
        broken = check_each(json_object_get(compare, where), arrays[i].check, &error);
    }
    return broken ? vw_fail(VW_ERROR_INPUT, "%s: %s: %s; compare again", path, where, error.text) : VW_OK;
}

// ---- CSV -----------------------------------------------------------------------------------------------------------

static enum vw_status out_of_memory(const char *path) {
    return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for its JSON", path);
}

static json_t *record_to_json(const struct vw_csv *csv) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < csv->field_count; i++) vw_json_append(&array, vw_json_string(csv->fields[i]));
    return array;
}

static enum vw_status print_header(struct vw_csv *csv, const char *const *columns, FILE *stream) {
    bool found = false;
    enum vw_status status = vw_csv_next(csv, &found);
    if (!status && !found) status = vw_fail(VW_ERROR_INPUT, "%s: is empty; remove it", csv->path);
    if (status) return status;
    json_t *header = record_to_json(csv);
    status = header ? check_table(csv->path, columns, header) : out_of_memory(csv->path);
    fputs("{\"header\":", stream);
    if (!status && json_dumpf(header, stream, JSON_COMPACT)) status = out_of_memory(csv->path);
    json_decref(header);
    return status;
}

// Prints record by record, because the values of a whole table would take many times its memory.
static enum vw_status print_rows(struct vw_csv *csv, FILE *stream) {
    bool found = true;
    const char *separator = ",\"rows\":[";
    enum vw_status status = VW_OK;
    while (!(status = vw_csv_next(csv, &found)) && found) {
        json_t *row = record_to_json(csv);
        fputs(separator, stream);
        if (!row || json_dumpf(row, stream, JSON_COMPACT)) status = out_of_memory(csv->path);
        json_decref(row);
        if (status) return status;
        separator = ",";
    }
    fputs(*separator && separator[1] ? ",\"rows\":[]}" : "]}", stream);
    return status;
}

static enum vw_status table_to_json(struct vw_csv *csv, const char *const *columns, char **json) {
    struct vw_text_stream text;
    char *printed = NULL;
    size_t size_bytes = 0;
    if (!vw_text_stream_open(&text)) return out_of_memory(csv->path);
    enum vw_status status = print_header(csv, columns, text.stream);
    if (!status) status = print_rows(csv, text.stream);
    enum vw_status closed = vw_text_stream_close(&text, csv->path, &printed, &size_bytes);
    if (!status) status = closed;
    if (status) free(printed);
    else *json = printed;
    return status;
}

// A file of a folder. A table has the columns that the page's script needs; compare.json has none.
struct file {
    const char *name, *const *columns, *path;
    void *text;
    size_t size_bytes;
};

static enum vw_status add_table(struct vw_report_files *files, const char *out, const struct file *file) {
    struct vw_csv csv;
    char *json = NULL;
    struct vw_report_document *document = add_document(files, out, "table", file->name);
    enum vw_status status = vw_csv_take(file->path, file->text, file->size_bytes, &csv);
    if (!status) status = document ? table_to_json(&csv, file->columns, &json) : VW_ERROR_MEMORY;
    vw_csv_close(&csv);
    if (document) document->json = json;
    return status;
}

// ---- Pictures ------------------------------------------------------------------------------------------------------

// Returns whether a render's name stays within the folder: "renders/" and a plain name.
static bool is_render(const char *file) {
    static const char folder[] = "renders/";
    return file && strncmp(file, folder, strlen(folder)) == 0 && file[strlen(folder)] &&
           !strchr(file + strlen(folder), '/');
}

static enum vw_status read_picture(const char *out, const char *file, struct vw_report_picture *picture) {
    static const char signature[] = "\x89PNG\r\n\x1a\n";
    enum vw_status status = vw_file_read_inside(out, file, RENDER_LIMIT_BYTES, &picture->data, &picture->size_bytes);
    if (!status &&
        (picture->size_bytes < strlen(signature) || memcmp(picture->data, signature, strlen(signature)) != 0))
        status = vw_fail(VW_ERROR_INPUT, "%s/%s: is not a PNG file; compare again", out, file);
    return status;
}

static enum vw_status add_picture(const char *out, const char *file, struct vw_report_document *document) {
    if (!is_render(file))
        return vw_fail(VW_ERROR_INPUT, "%s/compare.json: renders: a file is none of renders/; compare again", out);
    char *name = vw_copy_text(file);
    struct vw_report_picture picture = {0};
    enum vw_status status = name ? read_picture(out, file, &picture) : VW_ERROR_MEMORY;
    if (status) {
        free(picture.data);
        free(name);
        return status;
    }
    ((const char **)document->picture_files)[document->picture_count] = name;
    ((struct vw_report_picture *)document->pictures)[document->picture_count++] = picture;
    return VW_OK;
}

static enum vw_status add_pictures(const char *out, const json_t *compare, struct vw_report_document *document) {
    const json_t *renders = json_object_get(compare, "renders");
    document->picture_files = vw_allocate(json_array_size(renders), sizeof *document->picture_files);
    document->pictures = vw_allocate(json_array_size(renders), sizeof *document->pictures);
    enum vw_status status = document->picture_files && document->pictures ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; i < json_array_size(renders) && !status; i++)
        status = add_picture(out, json_string_value(json_object_get(json_array_get(renders, i), "file")), document);
    return status;
}

// ---- A comparison --------------------------------------------------------------------------------------------------

static enum vw_status add_compare(struct vw_report_files *files, const char *out, const struct file *file) {
    json_error_t error;
    struct vw_report_document *document = add_document(files, out, "compare", file->name);
    if (!document) {
        free(file->text);
        return VW_ERROR_MEMORY;
    }
    document->json = file->text;
    json_t *compare = vw_json_load(file->text, file->size_bytes, 0, &error);
    enum vw_status status = compare ? check_comparison(file->path, compare)
                                    : vw_fail(VW_ERROR_INPUT, "%s: line %d: %s", file->path, error.line, error.text);
    if (!status) status = add_pictures(out, compare, document);
    json_decref(compare);
    return status;
}

// ---- All of them ---------------------------------------------------------------------------------------------------

#define COLUMNS(...) ((const char *const[]){__VA_ARGS__, NULL})

static const struct {
    const char *name, *const *columns;
} known[] = {
    {"providers.csv", COLUMNS("provider", "method", "photos", "value", "stderr")},
    {"payout.csv", COLUMNS("provider", "method", "amount", "ci_low", "ci_high", "overlaps")},
    {"duplicates.csv", COLUMNS("group", "name", "provider", "split", "similarity", "value", "group_value")},
    {"tradeoff.csv", COLUMNS("configuration", "parameter", "value", "base", "train_ms", "value_ms", "scoring_ratio",
                             "run_seconds", "val_psnr", "psnr_pareto_front", "method", "score_pareto_front",
                             "seed_pearson", "seed_spearman", "agreement_pearson", "all_pixels_pearson")},
    {"summary.csv", COLUMNS("job", "state", "seconds", "photos", "steps", "val_psnr", "report", "message")},
    {"compare.json", NULL},
};

// Reads a file of a folder, if it is there, and notes what it reads.
static enum vw_status read_noted(const char *out, const char *name, struct vw_checksums *read, void **text,
                                 size_t *size_bytes) {
    enum vw_status status = vw_file_read_inside(out, name, TABLE_LIMIT_BYTES, text, size_bytes);
    return status || !read ? status : vw_checksums_note(read, name, *text, *size_bytes);
}

static enum vw_status add_file(struct vw_report_files *files, const char *out, const char *name,
                               const char *const *columns, struct vw_checksums *read) {
    char *path = vw_path_join(out, name);
    struct file file = {.name = name, .columns = columns, .path = path};
    if (!path) return VW_ERROR_MEMORY;
    bool held = vw_file_exists(path);
    enum vw_status status = held ? read_noted(out, name, read, &file.text, &file.size_bytes) : VW_OK;
    if (status) free(file.text);
    else if (held) status = columns ? add_table(files, out, &file) : add_compare(files, out, &file);
    free(path);
    return status;
}

enum vw_status vw_report_files_add(struct vw_report_files *files, const char *out, const struct vw_report_extra *extra,
                                   struct vw_checksums *read) {
    enum vw_status status = extra ? add_file(files, out, extra->file, extra->columns, read) : VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(known) && !status; i++)
        status = add_file(files, out, known[i].name, known[i].columns, read);
    return status;
}

// ---- Of a run ------------------------------------------------------------------------------------------------------

static enum vw_status read_checked(const char *out, const char *file, const char *scene_hash, uint32_t image_count,
                                   enum vw_status (*check)(const char *, json_t *, const char *, uint32_t),
                                   struct vw_checksums *read, char **json) {
    json_error_t error;
    void *text = NULL;
    size_t size_bytes = 0;
    char *path = vw_path_join(out, file);
    if (!path) return VW_ERROR_MEMORY;
    bool held = vw_file_exists(path);
    enum vw_status status = held ? read_noted(out, file, read, &text, &size_bytes) : VW_OK;
    json_t *value = held && !status ? vw_json_load(text, size_bytes, 0, &error) : NULL;
    if (held && !status)
        status = value ? check(path, value, scene_hash, image_count)
                       : vw_fail(VW_ERROR_INPUT, "%s: line %d: %s", path, error.line, error.text);
    json_decref(value);
    free(path);
    *json = text;
    return status;
}

enum vw_status vw_report_files_of_run(const char *out, const char *scene_hash, uint32_t image_count, bool no_photos,
                                      struct vw_checksums *read, struct vw_run_texts *texts) {
    enum vw_status status =
        read_checked(out, VW_SCENE_MAP_FILE, scene_hash, image_count, vw_scene_map_check, read, &texts->map);
    if (!status)
        status = read_checked(out, VW_RECONSTRUCTION_FILE, scene_hash, image_count, vw_reconstruction_check, read,
                              &texts->reconstruction);
    if (!status)
        status = read_checked(out, VW_NEXT_FILE, scene_hash, image_count, vw_proposals_check, read, &texts->next);
    if (!status && no_photos && texts->next) status = vw_proposals_drop_pictures(&texts->next);
    if (!status && !no_photos)
        status =
            read_checked(out, VW_RESIDUALS_FILE, scene_hash, image_count, vw_residuals_check, read, &texts->residuals);
    return status;
}

void vw_run_texts_free(struct vw_run_texts *texts) {
    free(texts->map);
    free(texts->residuals);
    free(texts->reconstruction);
    free(texts->next);
    *texts = (struct vw_run_texts){0};
}

static void free_document(struct vw_report_document *document) {
    for (uint32_t i = 0; i < document->picture_count; i++) {
        free((char *)document->picture_files[i]);
        free(document->pictures[i].data);
    }
    free((void *)document->picture_files);
    free((void *)document->pictures);
    free((void *)document->thumbnail_names);
    free((void *)document->thumbnails);
    free((char *)document->label);
    free((char *)document->json);
}

void vw_report_files_free(struct vw_report_files *files) {
    for (size_t i = 0; i < files->count; i++) free_document(&files->documents[i]);
    free(files->documents);
    *files = (struct vw_report_files){0};
}
