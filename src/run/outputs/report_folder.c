#include "run/outputs/report_folder.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "report/advice.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/results_files.h"
#include "run/outputs/thumbnails.h"
#include "run/recorded/recorded_run.h"
#include "run/scoring.h"
#include "viewworth/log.h"

// A run of the page, read from its folder.
struct held_run {
    char *folder; // owned
    struct vw_recorded_run recorded;
    struct vw_ledger_score *scores; // owned, like the retrainings
    struct vw_ledger_retraining *retrainings;
    struct vw_results results;
};

struct gathering {
    const struct vw_report_params *params;
    bool verified;         // by the command, which has just made what is reported
    struct held_run *runs; // owned
    size_t run_count, run_capacity;
    struct vw_report_documents documents;
};

// ---- Runs ----------------------------------------------------------------------------------------------------------

static enum vw_status read_run(struct held_run *run, bool verified) {
    struct vw_results *results = &run->results;
    enum vw_status status = vw_recorded_open_unverified(run->folder, &run->recorded);
    struct vw_ledger *ledger = run->recorded.ledger;
    *results = (struct vw_results){.label = run->folder, .row = run->recorded.row};
    if (!status && !verified) status = vw_recorded_warn_unverified(&run->recorded, true);
    if (!status) status = vw_scoring_load(ledger, &run->recorded.config, &results->input);
    if (!status) status = vw_ledger_get_scores(ledger, &run->scores, &results->score_count);
    if (!status) status = vw_ledger_get_retrainings(ledger, &run->retrainings, &results->retraining_count);
    results->scores = run->scores;
    results->retrainings = run->retrainings;
    if (!status) vw_ledger_chain_head(ledger, results->head);
    return status;
}

static void close_run(struct held_run *run) {
    vw_scoring_unload(&run->results.input);
    vw_results_free(&run->results);
    vw_recorded_close(&run->recorded);
    free(run->scores);
    free(run->retrainings);
    free(run->folder);
}

// Returns whether the report has the run already: several folders may contain it, or one may be named twice.
static bool is_held(const struct gathering *gathering, const struct held_run *run) {
    for (const struct held_run *held = gathering->runs; held < run; held++)
        if (!strcmp(held->results.row.run_id, run->results.row.run_id) &&
            !strcmp(held->results.head, run->results.head))
            return true;
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
    if (!is_held(gathering, run)) {
        status = vw_results_read_files(folder, gathering->params->options.no_thumbnails, &run->results);
        return status ? status : vw_results_measure(run->recorded.ledger, &run->results);
    }
    vw_log_info("%s: holds a run that the report has already", folder);
    close_run(run);
    *run = (struct held_run){0};
    gathering->run_count--;
    return VW_OK;
}

// Adds the run of a folder that has a ledger; `found` becomes true then.
static enum vw_status add_run(struct gathering *gathering, const char *folder, bool *found) {
    char *ledger_path = vw_path_join(folder, VW_LEDGER_FILE);
    if (!ledger_path) return VW_ERROR_MEMORY;
    bool held = access(ledger_path, F_OK) == 0; // reading refuses another kind of file
    free(ledger_path);
    *found |= held;
    return held ? read_ledger(gathering, folder) : VW_OK;
}

// Reads the number after "seed_"; returns false for other names.
static bool read_number(const char *name, uint64_t *number) {
    int end = 0;
    return sscanf(name, "seed_%" SCNu64 "%n", number, &end) == 1 && name[end] == 0;
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

// Adds the runs of seeds.
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
    bool found = false;
    if (!vw_folder_exists(out)) return vw_fail(VW_ERROR_INPUT, "%s: no such folder; %s", out, remedy);
    enum vw_status status = add_run(gathering, out, &found);
    if (!status) status = add_several(gathering, out, &found);
    if (!status) status = vw_report_documents_read(&gathering->documents, out, gathering->params->extra);
    for (size_t i = 0; i < gathering->documents.count; i++) // also one that the command has made
        found |= !strcmp(gathering->documents.list[i].label, out);
    if (!status && !found) status = vw_fail(VW_ERROR_INPUT, "%s: contains nothing to report; %s", out, remedy);
    return status;
}

// ---- Splits --------------------------------------------------------------------------------------------------------

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

// Logs runs of one scene that other photos judge than the first.
static void warn_of_splits(const struct gathering *gathering) {
    for (size_t i = 1; i < gathering->run_count; i++) {
        const struct held_run *run = &gathering->runs[i], *first = gathering->runs;
        while (first < run && strcmp(first->recorded.row.scene_path, run->recorded.row.scene_path)) first++;
        if (first < run && splits_differ(&first->results.input, &run->results.input))
            vw_log_warning(
                "%s: validates or tests on other photos or weights than %s, so their PSNR and scores cannot be "
                "compared; value it again with --splits %s/" VW_SPLITS_FILE,
                run->folder, first->folder, first->folder);
    }
}

// ---- The page ------------------------------------------------------------------------------------------------------

// Advises on runs and writes their page, to which it lends thumbnails meanwhile, with documents.
static enum vw_status write_page(struct vw_results **runs, size_t run_count, struct vw_report_documents *documents,
                                 const struct vw_report_params *params, const char *to) {
    struct vw_report_sets sets = {0};
    const struct vw_report_page page = {.runs = (const struct vw_results *const *)runs,
                                        .run_count = (uint32_t)run_count,
                                        .documents = documents->list,
                                        .document_count = (uint32_t)documents->count,
                                        .extra = params->extra};
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < run_count && !status; i++) status = vw_results_advise(runs[i]);
    for (size_t i = 0; i < run_count && !status; i++) vw_report_sets_of_run(&sets, params, runs[i]);
    for (size_t i = 0; i < documents->count && !status; i++)
        if (strcmp(documents->list[i].kind, "compare") == 0)
            status = vw_report_sets_of_comparison(&sets, params, page.runs, run_count, &documents->list[i]);
    if (!status) status = vw_report_write_html(to, &page);
    for (size_t i = 0; i < run_count; i++) runs[i]->thumbnails = NULL;
    vw_report_sets_free(&sets);
    return status;
}

static enum vw_status write_gathered(struct gathering *gathering, const char *to) {
    struct vw_results **runs = vw_allocate(gathering->run_count, sizeof *runs);
    enum vw_status status = runs ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < gathering->run_count; i++) runs[i] = &gathering->runs[i].results;
    if (!status) status = write_page(runs, gathering->run_count, &gathering->documents, gathering->params, to);
    free(runs);
    return status;
}

static enum vw_status gather(struct gathering *gathering, const char *const *folders, uint32_t folder_count) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < folder_count && !status; i++)
        if (!is_repeated(folders, i)) status = add_folder(gathering, folders[i]);
    if (!status) warn_of_splits(gathering);
    return status;
}

static void free_gathering(struct gathering *gathering) {
    for (size_t i = 0; i < gathering->run_count; i++) close_run(&gathering->runs[i]);
    free(gathering->runs);
    vw_report_documents_free(&gathering->documents);
}

// ---- A report of folders -------------------------------------------------------------------------------------------

// Finds the run of the folder that the report is written into; NULL: it has none.
static struct vw_ledger *find_ledger(const struct gathering *gathering, const char *out) {
    for (size_t i = 0; out && i < gathering->run_count; i++)
        if (!strcmp(gathering->runs[i].folder, out)) return gathering->runs[i].recorded.ledger;
    return NULL;
}

// Writes into the folder `out` (NULL: into none of those that it shows). Before, it compares the list of that folder
// with all that it names but the report: the new list vouches for what the old one did, and for the report.
static enum vw_status write_listed(struct gathering *gathering, const char *out, const char *to) {
    const char *slash = strrchr(to, '/'), *name = slash ? slash + 1 : to;
    struct vw_ledger *ledger = find_ledger(gathering, out);
    struct vw_checksums_found found = {0};
    bool replaces = !strcmp(name, VW_REPORT_FILE);
    if (ledger && !replaces && vw_out_is_result(name))
        return vw_fail(VW_ERROR_USAGE, "--to %s/%s: is a result of the run; name another file", out, name);
    enum vw_status status = ledger ? vw_checksums_check(out, ledger, VW_REPORT_FILE, &found) : VW_OK;
    if (!status) status = write_gathered(gathering, to);
    if (!status && found.present && replaces) status = vw_checksums_write(out, ledger);
    vw_checksums_found_free(&found);
    return status;
}

enum vw_status vw_report_write(const char *const *folders, uint32_t folder_count, const char *to,
                               const struct vw_report_params *params) {
    if (!folders || !folder_count || !to)
        return vw_fail(VW_ERROR_USAGE, "vw_report_write: folders or to is missing: name both");
    struct gathering gathering = {.params = params ? params : &(struct vw_report_params){0}};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = vw_out_lock_take_for(to, folders, folder_count, &lock);
    if (!status) status = gather(&gathering, folders, folder_count);
    if (!status) status = write_listed(&gathering, lock ? vw_out_lock_folder(lock) : NULL, to);
    free_gathering(&gathering);
    vw_out_lock_release(&lock);
    return status;
}

// ---- Reports at the end of a command -------------------------------------------------------------------------------

enum vw_status vw_report_of_run(struct vw_results *results, struct vw_report_documents *documents,
                                const struct vw_report_params *params, char **path) {
    *path = vw_path_join(results->label, VW_REPORT_FILE);
    enum vw_status status = *path ? vw_report_documents_read(documents, results->label, NULL) : VW_ERROR_MEMORY;
    return status ? status : write_page(&results, 1, documents, params, *path);
}

char *vw_report_folder_finish(const char *out, const struct vw_report_params *params, const char *file,
                              json_t *content) {
    struct gathering gathering = {.params = params, .verified = true};
    char *path = vw_path_join(out, VW_REPORT_FILE);
    enum vw_status status = file ? vw_report_documents_take(&gathering.documents, out, file, content) : VW_OK;
    if (!path) status = VW_ERROR_MEMORY;
    if (!status) status = gather(&gathering, &out, 1);
    if (!status) status = write_gathered(&gathering, path);
    free_gathering(&gathering);
    if (!status) return path;
    vw_log_warning("no report: %s; correct this, then run viewworth report %s", vw_error_message(), out);
    free(path);
    return NULL;
}
