#include "run/verify/verify.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "report/results.h"
#include "report/tables.h"
#include "run/imported/imported_run.h"
#include "run/lasting/lasting.h"
#include "run/out_folder.h"
#include "run/outputs/attribution.h"
#include "run/recorded/recorded_run.h"
#include "run/scoring.h"
#include "scene/builder.h"
#include "scene/name_index.h"
#include "train/trainer.h"

// Steps and the backward pass of a recorded run, made again and compared with the ledger bit for bit.
struct repetition {
    struct vw_recorded_run *run;        // its scene is opened
    const struct vw_value_input *input; // its steps and lasting credit
    const struct vw_verify_params *params;
};

static enum vw_status open_scene(const struct repetition *repetition) {
    struct vw_recorded_run *run = repetition->run;
    if (run->scene) return VW_OK;
    enum vw_status status =
        vw_recorded_open_scene(run, repetition->params->device ? repetition->params->device : run->row.device);
    return status ? status : vw_recorded_check_images(run);
}

// Returns whether the run is one of `value`: the untrained field has a validation, or one that is not finite.
static bool is_validated(const struct vw_value_input *input) {
    return input->record_count > 0 && (input->records[0].validated || input->records[0].nonfinite);
}

// ---- Steps ---------------------------------------------------------------------------------------------------------

static enum vw_status take_steps(const struct repetition *repetition, struct vw_trainer *trainer, uint64_t wanted,
                                 uint64_t *compared) {
    struct vw_ledger *ledger = repetition->run->ledger;
    uint32_t validation_count = 0, count = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(trainer, &validation_count);
    const struct vw_step_record *records = NULL;
    uint64_t end = vw_ledger_next_step(ledger);
    if (wanted < end) end = wanted + 1; // step 0 comes for free
    vw_trainer_stop_after(trainer, end - 1);
    enum vw_status status = vw_trainer_advance(trainer, &records, &count);
    while (!status && count > 0 && records[0].step < end) {
        if (records[0].step + count > end) count = (uint32_t)(end - records[0].step);
        status = vw_ledger_compare(ledger, records, count, validation_views);
        if (!status) *compared = records[count - 1].step;
        if (!status && vw_interrupt_requested(&repetition->params->interrupt))
            status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted after step %" PRIu64, *compared);
        if (!status) status = vw_trainer_advance(trainer, &records, &count);
    }
    return status;
}

// Takes steps from step 0 on, until `wanted` of them or all are compared; `*compared` is the last one.
// VW_ERROR_MISMATCH names the first that differs, VW_ERROR_INTERRUPTED that the interrupt was requested, VW_ERROR_USAGE
// what cannot be repeated.
static enum vw_status repeat_steps(const struct repetition *repetition, uint64_t wanted, uint64_t *compared) {
    struct vw_trainer *trainer = NULL;
    enum vw_status status = open_scene(repetition);
    if (status || !vw_ledger_next_step(repetition->run->ledger)) return status;
    status = vw_recorded_create_trainer(repetition->run, is_validated(repetition->input), &trainer);
    if (!status) status = take_steps(repetition, trainer, wanted, compared);
    vw_trainer_destroy(&trainer);
    return status;
}

// ---- Lasting credit ------------------------------------------------------------------------------------------------

static bool same(double a, double b) { return a == b || (isnan(a) && isnan(b)); }

static bool same_step(const struct vw_lasting_pass *a, const struct vw_lasting_pass *b, uint64_t place) {
    const struct vw_lasting_step *x = &a->steps[place], *y = &b->steps[place];
    bool equal =
        x->psnr == y->psnr && x->loss == y->loss && x->size_psnr == y->size_psnr && x->size_loss == y->size_loss;
    for (uint64_t i = place * a->view_count; equal && i < (place + 1) * a->view_count; i++)
        equal = a->view_psnr[i] == b->view_psnr[i];
    return equal;
}

static bool same_check(const struct vw_gate_check *a, const struct vw_gate_check *b) {
    return a->image_id == b->image_id && a->from_step == b->from_step && a->predicted_psnr == b->predicted_psnr &&
           a->predicted_loss == b->predicted_loss && same(a->measured_psnr, b->measured_psnr) &&
           same(a->measured_loss, b->measured_loss);
}

static enum vw_status compare_passes(const char *path, const struct vw_lasting_pass *recorded,
                                     const struct vw_lasting_pass *made) {
    for (uint64_t i = 0; i < made->step_count; i++)
        if (!same_step(recorded, made, i))
            return vw_fail(VW_ERROR_MISMATCH,
                           "%s: lasting credit of step %" PRIu64 ", made again, is %.9g dB, and its row is another one "
                           "(%.9g dB): this program did not make it on this device",
                           path, i + 1, made->steps[i].psnr, recorded->steps[i].psnr);
    bool gated = recorded->check_count == made->check_count;
    for (uint32_t i = 0; gated && i < made->check_count; i++)
        gated = same_check(&recorded->checks[i], &made->checks[i]);
    if (gated && recorded->epochs == made->epochs && recorded->states == made->states) return VW_OK;
    return vw_fail(
        VW_ERROR_MISMATCH,
        "%s: the gate of lasting credit, made again, or its settings are not the recorded ones: this program "
        "did not make it on this device",
        path);
}

static bool goes_on(void *context, const struct vw_run_state *state) {
    (void)state;
    return !vw_interrupt_requested(context);
}

// Compares the identity of the run, and makes its pass.
static enum vw_status make_pass(const struct repetition *repetition, struct vw_lasting_pass *made) {
    struct vw_recorded_run *run = repetition->run;
    const struct vw_lasting_pass *recorded = &repetition->input->lasting;
    struct vw_trainer *trainer = NULL;
    enum vw_status status = vw_recorded_create_trainer(run, true, &trainer);
    vw_trainer_destroy(&trainer);
    if (status) return status;
    struct vw_trainer_params training = vw_recorded_trainer_params(run);
    training.validate = true;
    const struct vw_backward_params pass = {
        .training = &training,
        .recorded = {run->ledger_path, repetition->input->records, repetition->input->record_count},
        .options = {.rays = recorded->rays, .no_gate = !recorded->check_count, .matrix = recorded->view_count > 0},
        .progress = goes_on,
        .context = (void *)&repetition->params->interrupt};
    return vw_backward_make(&pass, made);
}

// Makes the backward pass of lasting credit again, with its gate where it has one. Call it last: the config of the run
// gets the epochs that it took. The same errors.
static enum vw_status repeat_lasting(const struct repetition *repetition) {
    struct vw_recorded_run *run = repetition->run;
    struct vw_lasting_pass made = {0};
    if (!repetition->input->lasting.step_count)
        return vw_fail(VW_ERROR_USAGE, "%s: has no lasting credit to make again; leave out --lasting",
                       run->ledger_path);
    enum vw_status status = vw_recorded_check_replay(run);
    if (!status) status = open_scene(repetition);
    if (!status) status = make_pass(repetition, &made);
    if (!status) status = compare_passes(run->ledger_path, &repetition->input->lasting, &made);
    vw_lasting_pass_free(&made);
    return status;
}

static bool is_running(const struct vw_recorded_run *run) { return strcmp(run->row.status, "running") == 0; }

// ---- Scores --------------------------------------------------------------------------------------------------------

struct run_scores {
    struct vw_ledger_score *recorded; // owned
    uint32_t recorded_count;
    struct vw_scoring computed; // from the steps
};

// Compares the recorded scores with those of the steps, whatever the status says. Only a run whose status is "running"
// may have none.
static enum vw_status check_scores(struct vw_recorded_run *run, struct run_scores *scores) {
    enum vw_status status = vw_ledger_get_scores(run->ledger, &scores->recorded, &scores->recorded_count);
    if (!status) status = vw_scoring_make(run->ledger, &run->config, &scores->computed);
    if (status || (is_running(run) && !scores->recorded_count)) return status;
    return vw_scoring_compare(&scores->computed, run->ledger, run->ledger_path);
}

static enum vw_status check_head(const struct vw_recorded_run *run, const char *expected) {
    char head[VW_HASH_HEX_BYTES];
    vw_ledger_chain_head(run->ledger, head);
    if (!expected || strcasecmp(head, expected) == 0) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: its head is %s, not the one that --expect gives: another run, continued since, or rewritten",
                   run->ledger_path, head);
}

// ---- What is asked for ---------------------------------------------------------------------------------------------

static enum vw_status check_expected(const char *expected) {
    if (!expected ||
        (strlen(expected) == VW_HASH_HEX_BYTES - 1 && !expected[strspn(expected, "0123456789abcdefABCDEF")]))
        return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--expect: \"%s\" is not a head, which has 64 hexadecimal digits", expected);
}

struct table_sources {
    const char *out;
    struct vw_ledger *ledger;
    const struct vw_scoring *scoring;
    const char *providers; // FILE.csv with the providers; NULL: those of the ledger
};

// ---- Providers -----------------------------------------------------------------------------------------------------

// Reads providers of the ledger's images from a file. Its reader takes the views of a scene: these are made up, and own
// the names.
static enum vw_status read_providers(const char *path, struct vw_ledger_image *images, struct vw_view *views,
                                     uint32_t count) {
    static char format[] = "colmap"; // names may lack the folder of the photos
    struct vw_scene scene = {.format = format, .views = views, .view_count = count};
    for (uint32_t i = 0; i < count; i++) {
        views[i].name = (char *)images[i].name; // it is not changed
        views[i].provider = vw_copy_text("");
        if (!views[i].provider) return VW_ERROR_MEMORY;
    }
    enum vw_status status = vw_scene_index_names(&scene);
    if (!status) status = vw_providers_read(path, &scene);
    if (scene.names) vw_name_index_clear(scene.names);
    free(scene.names);
    for (uint32_t i = 0; i < count; i++) images[i].provider = views[i].provider;
    return status;
}

// ---- Tables, made again --------------------------------------------------------------------------------------------

// The findings that the tables show, made from the ledger alone.
struct findings {
    struct vw_results results;
    struct vw_attribution attribution;
    struct vw_view *views; // owned, with the providers of a file
};

// Returns the amount that the payout was asked for, if OUT has one; 0: there is none to divide.
static enum vw_status read_amount(const struct table_sources *sources, uint64_t *cents) {
    struct vw_payout_request request = {0};
    bool paid = vw_file_exists_inside(sources->out, vw_attribution_names[VW_TABLE_PAYOUT]) ||
                vw_file_exists_inside(sources->out, vw_attribution_names[VW_TABLE_PAYOUT_PHOTOS]);
    enum vw_status status = paid ? vw_ledger_get_payout_request(sources->ledger, &request) : VW_OK;
    *cents = request.cents <= VW_PAYOUT_CENTS_MAX ? request.cents : 0;
    return status;
}

static enum vw_status make_findings(const struct table_sources *sources, struct findings *findings) {
    const struct vw_scoring *scoring = sources->scoring;
    uint32_t count = scoring->input.image_count;
    uint64_t cents = 0;
    struct vw_ledger_image *images = vw_allocate(count, sizeof *images);
    findings->attribution.images = images;
    findings->views = vw_allocate(count, sizeof *findings->views);
    findings->results =
        (struct vw_results){.input = scoring->input, .scores = scoring->scores, .score_count = scoring->score_count};
    if (!images || !findings->views) return VW_ERROR_MEMORY;
    if (count) memcpy(images, scoring->input.images, count * sizeof *images);
    enum vw_status status = vw_results_measure(sources->ledger, &findings->results);
    if (!status && sources->providers) status = read_providers(sources->providers, images, findings->views, count);
    if (!status) status = read_amount(sources, &cents);
    return status ? status : vw_attribution_of_providers(scoring, cents, &findings->attribution);
}

static void free_findings(struct findings *findings, uint32_t count) {
    for (uint32_t i = 0; findings->views && i < count; i++) free(findings->views[i].provider);
    free(findings->views);
    vw_attribution_free(&findings->attribution);
    vw_results_free(&findings->results);
}

enum { SCORES = VW_ATTRIBUTION_TABLES, MATRIX };
static const struct table {
    const char *name;
    int which; // enum vw_attribution_table, SCORES or MATRIX
    bool by_provider;
} tables[] = {
    {"scores.csv", SCORES, false},
    {"matrix.csv", MATRIX, false},
    {"providers.csv", VW_TABLE_PROVIDERS, true},
    {"payout.csv", VW_TABLE_PAYOUT, true},
    {"payout_photos.csv", VW_TABLE_PAYOUT_PHOTOS, true},
};

// Makes a table; one without rows has no text.
static enum vw_status make(const struct findings *findings, const struct table *table, const char *path,
                           struct vw_csv_text *made) {
    const struct vw_results *results = &findings->results;
    const struct vw_value_input *input = &results->input;
    if (table->which == SCORES)
        return vw_report_make_csv(path, results->scores, results->score_count, input->images, input->image_count, made);
    if (table->which == MATRIX)
        return vw_results_have_matrix(results) ? vw_table_make_matrix(path, &results->matrix, results->standard_errors,
                                                                      input->images, input->image_count, made)
                                               : VW_OK;
    const struct vw_rows rows = vw_attribution_rows(&findings->attribution, (enum vw_attribution_table)table->which);
    return rows.count ? vw_rows_make_csv(path, &rows, made) : VW_OK;
}

// ---- Comparison ----------------------------------------------------------------------------------------------------

// Compares the bytes of a table; does not read a file that is larger.
static enum vw_status compare(const struct table_sources *sources, const struct findings *findings,
                              const struct table *table, const char *path) {
    struct vw_csv_text made = {0};
    void *file = NULL;
    size_t file_bytes = 0;
    enum vw_status status = make(findings, table, path, &made);
    bool read = !status && !vw_file_read_inside(sources->out, table->name, made.size_bytes + 1, &file, &file_bytes);
    bool same = read && made.text && file_bytes == made.size_bytes && !memcmp(file, made.text, file_bytes);
    if (!status && !same)
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: is not what the ledger gives: the file was edited%s; restore it from a copy", path,
                         table->by_provider ? ", or made with other --providers: give verify the same" : "");
    free(file);
    free(made.text);
    return status;
}

static enum vw_status verify_table(const struct table_sources *sources, const struct findings *findings,
                                   const struct table *table) {
    enum vw_status status = vw_file_check_inside(sources->out, table->name);
    if (status || !vw_file_exists_inside(sources->out, table->name)) return status;
    char *path = vw_path_join(sources->out, table->name);
    if (!path) return VW_ERROR_MEMORY;
    status = compare(sources, findings, table, path);
    free(path);
    return status;
}

static enum vw_status compare_tables(const struct table_sources *sources) {
    struct findings findings = {0};
    enum vw_status status = make_findings(sources, &findings);
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables) && !status; i++)
        status = verify_table(sources, &findings, &tables[i]);
    free_findings(&findings, sources->scoring->input.image_count);
    return status;
}

// Compares the tables with the recorded scores, of a run that is running with those of its steps.
static enum vw_status check_tables(struct vw_recorded_run *run, const struct vw_verify_params *params,
                                   const struct run_scores *scores) {
    struct vw_scoring scoring = scores->computed;
    if (scores->recorded_count) scoring.scores = scores->recorded, scoring.score_count = scores->recorded_count;
    const struct table_sources sources = {params->out, run->ledger, &scoring, params->providers};
    return compare_tables(&sources);
}

// ---- The field -----------------------------------------------------------------------------------------------------

enum field_state { FIELD_ABSENT, FIELD_INTACT, FIELD_NOT_RECORDED };

// Checks the field, whose hash the final_hash covers. Only a run that is still running may have one without a hash: a
// kill left it.
static enum vw_status check_field(const struct vw_recorded_run *run, enum field_state *state) {
    const char *recorded = run->row.field_sha256;
    if (!recorded && strcmp(run->row.status, "finished") == 0 && !vw_is_imported(&run->row))
        return vw_fail(VW_ERROR_MISMATCH, "%s: is finished, but has no hash of its field: the run row was edited",
                       run->ledger_path);
    enum vw_status status = vw_file_check_inside(run->out, VW_FIELD_FILE);
    if (status) return status;
    bool present = vw_file_exists_inside(run->out, VW_FIELD_FILE);
    *state = !present ? FIELD_ABSENT : recorded ? FIELD_INTACT : FIELD_NOT_RECORDED;
    return !present || is_running(run) ? VW_OK : vw_checksums_check_field(run->out, recorded);
}

// ---- All checks ----------------------------------------------------------------------------------------------------

struct checks {
    struct vw_recorded_run run;
    struct run_scores scores;
    enum field_state field;
};

static enum vw_status repeat(const struct vw_verify_params *params, struct checks *checks,
                             struct vw_verification *made) {
    const struct repetition repetition = {&checks->run, &checks->scores.computed.input, params};
    enum vw_status status = VW_OK;
    if (params->replay_steps) status = repeat_steps(&repetition, params->replay_steps, &made->replayed_steps);
    if (!status && params->lasting) status = repeat_lasting(&repetition);
    made->lasting_repeated = !status && params->lasting;
    return status;
}

static enum vw_status check_all(const struct vw_verify_params *params, struct checks *checks,
                                struct vw_verification *made) {
    struct vw_recorded_run *run = &checks->run;
    enum vw_status status = check_expected(params->expect);
    if (status) return status;
    status = vw_recorded_open_unverified(params->out, run);
    if (run->row.run_id) { // also when the config cannot be read, for which an edit is the likely cause
        enum vw_status intact = vw_ledger_verify(run->ledger);
        if (intact) status = intact;
    }
    if (!status) status = check_scores(run, &checks->scores);
    if (!status && vw_is_imported(&run->row)) status = vw_imported_log_sha256(&run->row, made->log_sha256);
    if (!status) status = check_head(run, params->expect);
    if (!status) status = check_tables(run, params, &checks->scores);
    if (!status) status = check_field(run, &checks->field);
    if (!status) status = vw_checksums_check(run->out, run->ledger, NULL, &made->list);
    return status ? status : repeat(params, checks, made);
}

// ---- The table -----------------------------------------------------------------------------------------------------

static void add(struct vw_verification *made, const char *name, const char *result, const char *by) {
    if (made->item_count < VW_VERIFY_ITEMS_MAX)
        made->items[made->item_count++] = (struct vw_verify_item){name, result, by};
}

static void list_ledger(const struct checks *checks, struct vw_verification *made) {
    static const char *const rows[] = {"run row", "image rows", "step rows", "view rows", "retraining rows"};
    bool ended = !is_running(&checks->run), replayed = made->replayed_steps > 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++) add(made, rows[i], "intact", "the hash chain");
    add(made, "score rows", ended ? "intact" : "absent",
        ended ? "the hash chain, and computed again from steps and retrainings" : "");
    bool followed = checks->scores.computed.input.lasting.step_count > 0;
    add(made, "lasting credit", followed ? "intact" : "absent",
        !followed                ? ""
        : made->lasting_repeated ? "the hash chain, and made again"
                                 : "the hash chain; --lasting makes it again");
    add(made, "order of methods", ended ? "intact" : "absent", ended ? "the hash chain, and computed again" : "");
    if (*made->log_sha256) {
        add(made, "log", "claimed", "nothing: the log's SHA-256 is in the ledger, the log is not");
        return;
    }
    add(made, "scene, shaders, device", replayed ? "intact" : "claimed",
        replayed ? "--replay: the scene is open, and its first steps repeat" : "nothing without --replay");
}

// Returns how a result file was checked; NULL: it was not.
static const char *covered_by(const struct checks *checks, const struct vw_verify_params *params,
                              const struct vw_verification *made, const char *name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++)
        if (!strcmp(tables[i].name, name))
            return tables[i].by_provider && params->providers ? "made again from the ledger and --providers"
                                                              : "made again from the ledger";
    if (!strcmp(name, VW_FIELD_FILE) && checks->field == FIELD_INTACT) return "its SHA-256, in the hash chain";
    return made->list.present ? VW_CHECKSUMS_FILE : NULL;
}

static void list_files(const struct checks *checks, const struct vw_verify_params *params,
                       struct vw_verification *made) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++) {
        const char *name = vw_out_files[i].name, *by = covered_by(checks, params, made, name);
        if (!strcmp(name, VW_LEDGER_FILE)) continue;
        if (!vw_file_exists_inside(params->out, name)) add(made, name, "absent", "");
        else add(made, name, by ? "intact" : "not checked", by ? by : "nothing without " VW_CHECKSUMS_FILE);
    }
}

static void list_proofs(const struct vw_verify_params *params, struct vw_verification *made) {
    add(made, VW_CHECKSUMS_FILE, made->list.present ? "intact" : "absent",
        made->list.present ? "the files that it lists, and the chain head" : "");
    add(made, "chain as a whole", params->expect ? "intact" : "not checked",
        params->expect ? "--expect" : "nothing without --expect or a signature of " VW_CHECKSUMS_FILE);
}

static void fill_result(struct checks *checks, const struct vw_verify_params *params, struct vw_verification *made) {
    struct vw_recorded_run *run = &checks->run;
    uint64_t rows = vw_ledger_next_step(run->ledger);
    made->ledger_path = run->ledger_path;
    run->ledger_path = NULL; // owned by the verification now
    made->steps = rows > 0 ? rows - 1 : 0;
    made->score_count = checks->scores.recorded_count;
    made->retrainings = checks->scores.computed.retraining_count;
    snprintf(made->run_id, sizeof made->run_id, "%s", run->row.run_id);
    snprintf(made->status, sizeof made->status, "%s", run->row.status);
    vw_ledger_chain_head(run->ledger, made->head);
    list_ledger(checks, made);
    list_files(checks, params, made);
    list_proofs(params, made);
}

enum vw_status vw_run_verify(const struct vw_verify_params *params, struct vw_verification *verification) {
    struct checks checks = {0};
    struct vw_verification made = {0};
    enum vw_status status = check_all(params, &checks, &made);
    if (!status) fill_result(&checks, params, &made);
    if (!status) *verification = made;
    else vw_checksums_found_free(&made.list);
    vw_scoring_free(&checks.scores.computed);
    free(checks.scores.recorded);
    vw_recorded_close(&checks.run);
    return status;
}

void vw_verification_free(struct vw_verification *verification) {
    free(verification->ledger_path);
    vw_checksums_found_free(&verification->list);
    *verification = (struct vw_verification){0};
}
