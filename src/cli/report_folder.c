#include "cli/report_folder.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "cli/recorded_run.h"
#include "cli/report_files.h"
#include "cli/scoring.h"
#include "cli/thumbnails.h"
#include "viewworth/file.h"
#include "viewworth/json.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"

// A run and what of it the page borrows.
struct held_run {
    char *folder; // owned
    struct vw_recorded_run recorded;
    struct vw_value_input input;
    struct vw_ledger_score *scores;
    uint32_t score_count;
    struct vw_matrix matrix;
    struct vw_view_evidence *views;
    double *standard_errors;
    struct vw_report_picture *thumbnails; // those of the first run of its scene, which owns them
    bool owns_thumbnails;
    char head[VW_HASH_HEX_BYTES];
};

struct gathering {
    const struct vw_report_options *options;
    struct held_run *runs; // owned array, as those below
    size_t run_count, run_capacity;
    struct vw_report_files files;
};

// ---- Runs -----------------------------------------------------------------------------------------------------------------

static enum vw_status read_matrix(struct held_run *run) {
    enum vw_status status = vw_value_matrix(run->recorded.ledger, &run->input, &run->matrix);
    if (status) return status;
    run->views = vw_allocate(run->matrix.view_count, sizeof *run->views);
    run->standard_errors = vw_allocate(run->matrix.photo_count, sizeof *run->standard_errors);
    if (!run->views || !run->standard_errors) return VW_ERROR_MEMORY;
    return run->matrix.visit_count ? vw_matrix_jackknife(&run->matrix, run->views, run->standard_errors) : VW_OK;
}

static enum vw_status read_run(struct held_run *run) {
    enum vw_status status = vw_recorded_open(run->folder, &run->recorded);
    if (!status) status = vw_scoring_load(run->recorded.ledger, &run->recorded.config, &run->input);
    if (!status) status = vw_ledger_get_scores(run->recorded.ledger, &run->scores, &run->score_count);
    if (!status) status = read_matrix(run);
    if (!status) vw_ledger_head(run->recorded.ledger, run->head);
    return status;
}

static void close_run(struct held_run *run) {
    if (run->owns_thumbnails) vw_thumbnails_free(run->thumbnails, run->input.image_count);
    vw_matrix_clear(&run->matrix);
    vw_scoring_unload(&run->input);
    vw_recorded_close(&run->recorded);
    free(run->views);
    free(run->standard_errors);
    free(run->scores);
    free(run->folder);
}

// A folder without a ledger is no run.
static enum vw_status add_run(struct gathering *gathering, const char *folder) {
    char *ledger_path = vw_path_join(folder, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool held = vw_file_exists(ledger_path);
    free(ledger_path);
    if (!held) return VW_OK;
    enum vw_status status = vw_grow((void **)&gathering->runs, &gathering->run_capacity, gathering->run_count + 1, sizeof *gathering->runs);
    if (status) return status;
    struct held_run *run = &gathering->runs[gathering->run_count++];
    run->folder = vw_copy_text(folder);
    return run->folder ? read_run(run) : VW_ERROR_MEMORY;
}

// The number behind "seed_"; false for other names.
static bool read_seed(const char *name, uint64_t *seed) {
    int end = 0;
    return sscanf(name, "seed_%" SCNu64 "%n", seed, &end) == 1 && name[end] == 0;
}

static int compare_seeds(const struct dirent **left, const struct dirent **right) {
    uint64_t a = 0, b = 0;
    (void)read_seed((*left)->d_name, &a), (void)read_seed((*right)->d_name, &b);
    return a < b ? -1 : a > b;
}

static int is_seed_folder(const struct dirent *entry) {
    uint64_t seed;
    return read_seed(entry->d_name, &seed);
}

static enum vw_status add_seeds(struct gathering *gathering, const char *out) {
    struct dirent **entries = NULL;
    int count = scandir(out, &entries, is_seed_folder, compare_seeds);
    enum vw_status status = count < 0 ? vw_fail(VW_ERROR_INPUT, "%s: cannot list the folder: %s", out, strerror(errno)) : VW_OK;
    for (int i = 0; i < count; i++) {
        char *folder = status ? NULL : vw_path_join(out, entries[i]->d_name);
        if (!status) status = folder ? add_run(gathering, folder) : VW_ERROR_MEMORY;
        free(folder);
        free(entries[i]);
    }
    free(entries);
    return status;
}

static enum vw_status add_folder(struct gathering *gathering, const char *out) {
    size_t runs = gathering->run_count, files = gathering->files.count;
    if (!vw_folder_exists(out)) return vw_fail(VW_ERROR_INPUT, "%s: no such folder; give one that value, reproduce or benchmark made", out);
    enum vw_status status = add_run(gathering, out);
    if (!status) status = add_seeds(gathering, out);
    if (!status) status = vw_report_files_add(&gathering->files, out);
    if (!status && gathering->run_count == runs && gathering->files.count == files)
        status = vw_fail(VW_ERROR_INPUT, "%s: holds nothing to report; give a folder that value, reproduce or benchmark made", out);
    return status;
}

// ---- Thumbnails -----------------------------------------------------------------------------------------------------------

static bool is_open_scene(const struct gathering *gathering, const struct held_run *run) {
    char hash[VW_HASH_HEX_BYTES];
    if (!gathering->options->scene) return false;
    vw_hash_to_hex(gathering->options->scene->hash, hash);
    return strcmp(hash, run->recorded.row.scene_hash) == 0;
}

// Those of a run before of the same scene: reading or drawing photos takes long, and the page holds them once.
static bool share_thumbnails(const struct gathering *gathering, struct held_run *run) {
    for (struct held_run *other = gathering->runs; other < run; other++) {
        if (strcmp(other->recorded.row.scene_hash, run->recorded.row.scene_hash) != 0) continue;
        run->thumbnails = other->thumbnails;
        return true;
    }
    return false;
}

static void make_thumbnails(const struct gathering *gathering, struct held_run *run) {
    if (gathering->options->no_thumbnails || share_thumbnails(gathering, run)) return;
    enum vw_status status = is_open_scene(gathering, run)
                                ? vw_thumbnails_make(gathering->options->scene, &run->thumbnails)
                                : vw_thumbnails_make_again(&run->recorded, gathering->options->device, &run->thumbnails);
    run->owns_thumbnails = !status;
    if (status) vw_log_warning("the report goes without thumbnails: %s", vw_error_message());
}

// ---- The page -------------------------------------------------------------------------------------------------------------

static struct vw_report_run run_of_page(const struct held_run *run) {
    return (struct vw_report_run){
        .label = run->folder,
        .row = &run->recorded.row,
        .head = run->head,
        .images = run->input.images,
        .image_count = run->input.image_count,
        .scores = run->scores,
        .score_count = run->score_count,
        .records = run->input.records,
        .record_count = run->input.record_count,
        .matrix = &run->matrix,
        .views = run->views,
        .standard_errors = run->standard_errors,
        .thumbnails = run->thumbnails,
    };
}

static char *methods_to_json(void) {
    uint32_t count;
    const struct vw_value_method *methods = vw_value_methods(&count);
    json_t *array = json_array();
    int failed = 0;
    for (uint32_t i = 0; i < count; i++)
        failed |= json_array_append_new(
            array, json_pack("{s:s, s:s, s:s}", "name", methods[i].name, "unit", methods[i].unit, "formula", methods[i].formula));
    char *text = failed ? NULL : json_dumps(array, JSON_COMPACT);
    json_decref(array);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the report's methods");
    return text;
}

static enum vw_status write_page(const struct gathering *gathering, const char *to) {
    struct vw_report_run *runs = vw_allocate(gathering->run_count, sizeof *runs);
    char *methods_json = runs ? methods_to_json() : NULL;
    enum vw_status status = methods_json ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; runs && i < gathering->run_count; i++) runs[i] = run_of_page(&gathering->runs[i]);
    if (!status)
        status = vw_report_write_html(to, &(struct vw_report_page){.version = vw_version(),
                                                                   .default_method = vw_value_default_method,
                                                                   .methods_json = methods_json,
                                                                   .runs = runs,
                                                                   .run_count = (uint32_t)gathering->run_count,
                                                                   .documents = gathering->files.documents,
                                                                   .document_count = (uint32_t)gathering->files.count});
    free(methods_json);
    free(runs);
    return status;
}

enum vw_status vw_report_folders_write(const char *const *outs, uint32_t count, const char *to, const struct vw_report_options *options) {
    struct gathering gathering = {.options = options};
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) status = add_folder(&gathering, outs[i]);
    for (size_t i = 0; i < gathering.run_count && !status; i++) make_thumbnails(&gathering, &gathering.runs[i]);
    if (!status) status = write_page(&gathering, to);
    for (size_t i = 0; i < gathering.run_count; i++) close_run(&gathering.runs[i]);
    free(gathering.runs);
    vw_report_files_free(&gathering.files);
    return status;
}

enum vw_status vw_report_folder_write(const char *out, const struct vw_report_options *options) {
    char *path = vw_path_join(out, "report.html");
    enum vw_status status = path ? vw_report_folders_write(&out, 1, path, options) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

char *vw_report_folder_conclude(const char *out, const struct vw_report_options *options) {
    if (!vw_report_folder_write(out, options)) return vw_path_join(out, "report.html");
    vw_log_warning("no report: %s; viewworth report %s makes it once that is mended", vw_error_message(), out);
    return NULL;
}
