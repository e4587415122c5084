#include "run/outputs/report_folder.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "report/told.h"
#include "run/imported/imported_run.h"
#include "run/out_lock.h"
#include "run/outputs/checksums.h"
#include "run/outputs/report_files.h"
#include "run/outputs/report_thumbnails.h"
#include "run/recorded/recorded_run.h"
#include "run/scoring.h"
#include "viewworth/log.h"
#include "viewworth/version.h"

// A run of the page, read from the ledger in its folder.
struct held_run {
    char *folder; // owned
    struct vw_recorded_run recorded;
    struct vw_value_input input;
    struct vw_ledger_score *scores;
    uint32_t score_count;
    struct vw_matrix matrix;
    struct vw_view_evidence *views;
    double *standard_errors;
    const struct vw_report_picture *thumbnails; // lent by the sets
    struct vw_ledger_retraining *retrainings;
    uint32_t retraining_count;
    struct vw_ranking_agreement agreement;
    struct vw_run_texts texts;
    char head[VW_HASH_HEX_BYTES];
};

struct gathering {
    const struct vw_report_params *params;
    const char *out;              // the folder that the report is written into; NULL: none of those that it shows
    struct vw_checksums *in_hand; // notes what is read from there
    bool verified;                // by the command, which has just made what is reported
    bool listed;                  // there is a list, compared before the report is written
    struct held_run *runs;        // owned array, like those below
    size_t run_count, run_capacity;
    struct vw_report_files files;
    struct vw_report_sets sets;
};

// ---- Runs ----------------------------------------------------------------------------------------------------------

static enum vw_status read_matrix(struct held_run *run) {
    enum vw_status status = vw_value_matrix(run->recorded.ledger, &run->input, &run->matrix);
    if (status) return status;
    run->views = vw_allocate(run->matrix.view_count, sizeof *run->views);
    run->standard_errors = vw_allocate(run->matrix.photo_count, sizeof *run->standard_errors);
    if (!run->views || !run->standard_errors) return VW_ERROR_MEMORY;
    status = vw_ranking_agreement_measure(&run->input, &run->matrix, run->scores, run->score_count, &run->agreement);
    if (status || !run->matrix.visit_count) return status;
    return vw_matrix_jackknife(&run->matrix, run->views, run->standard_errors);
}

static enum vw_status read_run(struct held_run *run, bool verified) {
    enum vw_status status = vw_recorded_open_unverified(run->folder, &run->recorded);
    if (!status && !verified) status = vw_recorded_warn_unverified(&run->recorded, true);
    if (!status) status = vw_scoring_load(run->recorded.ledger, &run->recorded.config, &run->input);
    if (!status) status = vw_ledger_get_scores(run->recorded.ledger, &run->scores, &run->score_count);
    if (!status) status = read_matrix(run);
    if (!status) status = vw_ledger_get_retrainings(run->recorded.ledger, &run->retrainings, &run->retraining_count);
    if (!status) vw_ledger_chain_head(run->recorded.ledger, run->head);
    return status;
}

static struct vw_checksums *in_hand_of(const struct gathering *gathering, const char *folder) {
    return gathering->out && !strcmp(gathering->out, folder) ? gathering->in_hand : NULL;
}

// Returns the table of near-duplicates that lies beside a run; NULL: none.
static const char *duplicates_of(const struct gathering *gathering, const struct held_run *run) {
    for (size_t i = 0; i < gathering->files.count; i++) {
        const struct vw_report_document *document = &gathering->files.documents[i];
        if (!strcmp(document->file, "duplicates.csv") && !strcmp(document->label, run->folder)) return document->json;
    }
    return NULL;
}

// Returns the view of a run that the page borrows.
static struct vw_report_run run_of_page(const struct gathering *gathering, const struct held_run *run) {
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
        .burn_in_epochs = run->input.burn_in_epochs,
        .lasting = run->input.lasting,
        .matrix = &run->matrix,
        .views = run->views,
        .standard_errors = run->standard_errors,
        .retrainings = run->retrainings,
        .retraining_count = run->retraining_count,
        .thumbnails = run->thumbnails,
        .agreement = &run->agreement,
        .map_json = run->texts.map,
        .residuals_json = run->texts.residuals,
        .reconstruction_json = run->texts.reconstruction,
        .next_json = run->texts.next,
        .duplicates_json = duplicates_of(gathering, run),
    };
}

static void close_run(struct held_run *run) {
    vw_matrix_clear(&run->matrix);
    vw_scoring_unload(&run->input);
    vw_recorded_close(&run->recorded);
    free(run->views);
    free(run->standard_errors);
    free(run->scores);
    free(run->retrainings);
    vw_run_texts_free(&run->texts);
    free(run->folder);
}

// Returns whether the report has the run already: several folders may contain it, or one may be named twice.
static bool is_held(const struct gathering *gathering, const struct held_run *run) {
    for (const struct held_run *held = gathering->runs; held < run; held++)
        if (!strcmp(held->recorded.row.run_id, run->recorded.row.run_id) && !strcmp(held->head, run->head)) return true;
    return false;
}

static enum vw_status read_ledger(struct gathering *gathering, const char *folder) {
    enum vw_status status =
        vw_grow((void **)&gathering->runs, &gathering->run_capacity, gathering->run_count + 1, sizeof *gathering->runs);
    if (status) return status;
    struct held_run *run = &gathering->runs[gathering->run_count++];
    run->folder = vw_copy_text(folder);
    status = run->folder ? read_run(run, gathering->verified) : VW_ERROR_MEMORY;
    if (status) return status;
    if (!is_held(gathering, run))
        return vw_report_files_of_run(run->folder, run->recorded.row.scene_hash, run->input.image_count,
                                      gathering->params->options.no_thumbnails, in_hand_of(gathering, folder),
                                      &run->texts);
    vw_log_info("%s: holds a run that the report has already", folder);
    close_run(run);
    *run = (struct held_run){0};
    gathering->run_count--;
    return VW_OK;
}

// Adds the run of a folder that has a ledger; `found` becomes true then.
static enum vw_status add_run(struct gathering *gathering, const char *folder, bool *found) {
    char *ledger_path = vw_path_join(folder, "ledger.db");
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool held = vw_file_exists(ledger_path);
    free(ledger_path);
    *found |= held;
    return held ? read_ledger(gathering, folder) : VW_OK;
}

// Reads the number after "seed_" or "fold-"; returns false for other names.
static bool read_number(const char *name, uint64_t *number) {
    int seed_end = 0, fold_end = 0;
    return (sscanf(name, "seed_%" SCNu64 "%n", number, &seed_end) == 1 && name[seed_end] == 0) ||
           (sscanf(name, "fold-%" SCNu64 "%n", number, &fold_end) == 1 && name[fold_end] == 0);
}

static int compare_numbers(const struct dirent **left, const struct dirent **right) {
    uint64_t a = 0, b = 0;
    (void)read_number((*left)->d_name, &a), (void)read_number((*right)->d_name, &b);
    return a < b ? -1 : a > b;
}

static int is_one_of_several(const struct dirent *entry) {
    uint64_t number;
    return read_number(entry->d_name, &number);
}

// Adds the runs of seeds or folds.
static enum vw_status add_several(struct gathering *gathering, const char *out, bool *found) {
    struct dirent **entries = NULL;
    int count = scandir(out, &entries, is_one_of_several, compare_numbers);
    enum vw_status status =
        count < 0 ? vw_fail(VW_ERROR_INPUT, "%s: cannot list the folder: %s", out, strerror(errno)) : VW_OK;
    for (int i = 0; i < count; i++) {
        if (!status) status = vw_folder_check_inside(out, entries[i]->d_name);
        char *folder = status ? NULL : vw_path_join(out, entries[i]->d_name);
        if (!status) status = folder ? add_run(gathering, folder, found) : VW_ERROR_MEMORY;
        free(folder);
        free(entries[i]);
    }
    free(entries);
    return status;
}

// Returns whether an operand before this one names the same folder.
static bool is_repeated(const char *const *outs, uint32_t place) {
    bool repeated = false;
    char *path = realpath(outs[place], NULL);
    for (uint32_t i = 0; i < place && path && !repeated; i++) {
        char *other = realpath(outs[i], NULL);
        repeated = other && strcmp(other, path) == 0;
        free(other);
    }
    free(path);
    return repeated;
}

static enum vw_status add_folder(struct gathering *gathering, const char *out) {
    static const char remedy[] = "give a folder that value, compare, tradeoff or batch made";
    size_t files = gathering->files.count;
    bool found = false;
    if (!vw_folder_exists(out)) return vw_fail(VW_ERROR_INPUT, "%s: no such folder; %s", out, remedy);
    enum vw_status status = add_run(gathering, out, &found);
    if (!status) status = add_several(gathering, out, &found);
    if (!status)
        status = vw_report_files_add(&gathering->files, out, gathering->params->extra, in_hand_of(gathering, out));
    if (!status && !found && gathering->files.count == files)
        status = vw_fail(VW_ERROR_INPUT, "%s: contains nothing to report; %s", out, remedy);
    return status;
}

// ---- Thumbnails ----------------------------------------------------------------------------------------------------

static void lend_to_run(struct gathering *gathering, struct held_run *run) {
    const struct vw_ledger_run *row = &run->recorded.row;
    const struct vw_recorded_scene recorded = {run->folder, vw_is_imported(row) ? NULL : row->scene_path,
                                               row->scene_options_json, row->scene_hash};
    run->thumbnails = vw_report_sets_of_run(&gathering->sets, gathering->params, &recorded, run->input.images,
                                            run->input.image_count);
}

static enum vw_status lend_to_comparisons(struct gathering *gathering, const struct vw_report_run *runs) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < gathering->files.count && !status; i++) {
        struct vw_report_document *document = &gathering->files.documents[i];
        if (strcmp(document->kind, "compare") != 0) continue;
        status =
            vw_report_sets_of_comparison(&gathering->sets, gathering->params, runs, gathering->run_count, document);
    }
    return status;
}

// ---- The page ------------------------------------------------------------------------------------------------------

static char *methods_to_json(void) {
    uint32_t count;
    const struct vw_value_method *methods = vw_value_methods(&count);
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++)
        vw_json_append(&array, json_pack("{s:s, s:s, s:s, s:b}", "name", methods[i].name, "unit", methods[i].unit,
                                         "formula", methods[i].formula, "has_zero", methods[i].has_zero));
    char *text = vw_json_to_text(array, JSON_COMPACT);
    json_decref(array);
    if (!text) vw_fail(VW_ERROR_MEMORY, "out of memory for the report's methods");
    return text;
}

// Writes advice.csv where the command has just made the scores: it says what the head of the page says.
static enum vw_status write_advice(struct gathering *gathering, const struct vw_report_page *page) {
    for (uint32_t i = 0; gathering->verified && i < page->run_count; i++) {
        const struct vw_report_run *run = &page->runs[i];
        if (strcmp(run->label, gathering->out) != 0 || !run->score_count) continue;
        struct vw_csv_text table = {0};
        enum vw_status status = vw_report_make_advice_csv(VW_ADVICE_FILE, run, &table);
        return vw_result_write_table(status, gathering->out, VW_ADVICE_FILE, &table, gathering->in_hand);
    }
    return VW_OK;
}

static enum vw_status write_page(struct gathering *gathering, const char *to, char sha256[VW_HASH_HEX_BYTES]) {
    struct vw_report_run *runs = vw_allocate(gathering->run_count, sizeof *runs);
    char *methods_json = runs ? methods_to_json() : NULL;
    enum vw_status status = methods_json ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; runs && i < gathering->run_count; i++) runs[i] = run_of_page(gathering, &gathering->runs[i]);
    if (!status) status = lend_to_comparisons(gathering, runs);
    const struct vw_report_page page = {.version = vw_version(),
                                        .default_method = vw_value_default_method,
                                        .methods_json = methods_json,
                                        .runs = runs,
                                        .run_count = (uint32_t)gathering->run_count,
                                        .documents = gathering->files.documents,
                                        .document_count = (uint32_t)gathering->files.count,
                                        .extra = gathering->params->extra};
    if (!status) status = write_advice(gathering, &page);
    if (!status) status = vw_report_write_html(to, &page, sha256);
    free(methods_json);
    free(runs);
    return status;
}

// Finds the run of the folder that the report is written into; NULL: it has none.
static struct vw_ledger *ledger_of_out(const struct gathering *gathering) {
    for (size_t i = 0; gathering->out && i < gathering->run_count; i++)
        if (!strcmp(gathering->runs[i].folder, gathering->out)) return gathering->runs[i].recorded.ledger;
    return NULL;
}

// Compares the list of the folder that the report is written into with all that it names but the report, before that
// is replaced: the new list vouches for what the old one did, and for the report.
static enum vw_status check_list(struct gathering *gathering, const char *name) {
    struct vw_ledger *ledger = ledger_of_out(gathering);
    struct vw_checksums_found found = {0};
    if (!ledger) return VW_OK;
    if (vw_checksums_find(gathering->in_hand, name) && strcmp(name, VW_REPORT_FILE) != 0)
        return vw_fail(VW_ERROR_USAGE, "--to %s/%s: is a result of the run; name another file", gathering->out, name);
    enum vw_status status = vw_checksums_check(gathering->out, ledger, VW_REPORT_FILE, gathering->in_hand, &found);
    gathering->listed = found.present;
    vw_checksums_found_free(&found);
    return status;
}

static enum vw_status write_listed(struct gathering *gathering, const char *to) {
    const char *slash = strrchr(to, '/'), *name = slash ? slash + 1 : to;
    char sha256[VW_HASH_HEX_BYTES];
    bool lists = gathering->out && !strcmp(name, VW_REPORT_FILE);
    enum vw_status status = gathering->verified ? VW_OK : check_list(gathering, name);
    if (!status) status = write_page(gathering, to, sha256);
    if (!status && lists) status = vw_checksums_note_hash(gathering->in_hand, name, sha256);
    if (status || !lists || !gathering->listed) return status;
    return vw_checksums_write(gathering->out, ledger_of_out(gathering), gathering->in_hand);
}

// ---- Splits ---------------------------------------------------------------------------------------------------------
// ----------------------------------------------------------------------------------------------------------

static bool judges(const struct vw_ledger_image *image) {
    return strcmp(image->split, "val") == 0 || strcmp(image->split, "test") == 0;
}

// Returns whether a photo of both runs validates or tests in one of them alone, or with another weight.
static bool splits_differ(const struct vw_value_input *one, const struct vw_value_input *other) {
    for (uint32_t i = 0; i < one->image_count; i++)
        for (uint32_t j = 0; j < other->image_count; j++) {
            const struct vw_ledger_image *a = &one->images[i], *b = &other->images[j];
            bool same = strcmp(a->split, b->split) == 0 && a->weight == b->weight;
            if ((judges(a) || judges(b)) && !same && strcmp(a->name, b->name) == 0) return true;
        }
    return false;
}

static bool is_fold(const struct held_run *run) {
    const char *slash = strrchr(run->folder, '/');
    return strncmp(slash ? slash + 1 : run->folder, "fold-", strlen("fold-")) == 0;
}

// Logs runs of one scene that other photos judge than the first; folds of one valuation are so on purpose.
static void warn_of_splits(const struct gathering *gathering) {
    for (size_t i = 1; i < gathering->run_count; i++) {
        const struct held_run *run = &gathering->runs[i], *first = gathering->runs;
        while (first < run && (strcmp(first->recorded.row.scene_path, run->recorded.row.scene_path) || is_fold(first)))
            first++;
        if (first < run && !is_fold(run) && splits_differ(&first->input, &run->input))
            vw_log_warning(
                "%s: validates or tests on other photos or weights than %s, so their PSNR and scores cannot be "
                "compared; value it again with --splits %s/" VW_SPLITS_FILE,
                run->folder, first->folder, first->folder);
    }
}

static enum vw_status write_report(struct gathering *gathering, const char *const *folders, uint32_t folder_count,
                                   const char *to) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < folder_count && !status; i++)
        if (!is_repeated(folders, i)) status = add_folder(gathering, folders[i]);
    for (size_t i = 0; i < gathering->run_count && !status; i++) lend_to_run(gathering, &gathering->runs[i]);
    if (!status) warn_of_splits(gathering);
    if (!status) status = write_listed(gathering, to);
    for (size_t i = 0; i < gathering->run_count; i++) close_run(&gathering->runs[i]);
    free(gathering->runs);
    vw_report_files_free(&gathering->files);
    vw_report_sets_free(&gathering->sets);
    return status;
}

enum vw_status vw_report_write(const char *const *folders, uint32_t folder_count, const char *to,
                               const struct vw_report_params *params) {
    if (!folders || !folder_count || !to)
        return vw_fail(VW_ERROR_USAGE, "vw_report_write: folders or to is missing: name both");
    struct vw_checksums in_hand = {0};
    struct gathering gathering = {.params = params ? params : &(struct vw_report_params){0}, .in_hand = &in_hand};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = vw_out_lock_take_for(to, folders, folder_count, &lock);
    gathering.out = lock ? vw_out_lock_folder(lock) : NULL;
    if (!status) status = write_report(&gathering, folders, folder_count, to);
    vw_out_lock_release(&lock);
    return status;
}

enum vw_status vw_report_folder_make(const char *out, const struct vw_report_params *params, struct vw_checksums *made,
                                     char **path) {
    struct gathering gathering = {.params = params, .out = out, .in_hand = made, .verified = true};
    *path = vw_path_join(out, VW_REPORT_FILE);
    return *path ? write_report(&gathering, &out, 1, *path) : VW_ERROR_MEMORY;
}

char *vw_report_folder_finish(const char *out, const struct vw_report_params *params) {
    struct vw_checksums made = {0};
    char *path = NULL;
    if (!vw_report_folder_make(out, params, &made, &path)) return path;
    vw_log_warning("no report: %s; correct this, then run viewworth report %s", vw_error_message(), out);
    free(path);
    return NULL;
}
