#include "run/verify/verify.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/inside.h"
#include "base/memory.h"
#include "run/imported/imported_run.h"
#include "run/out_files.h"
#include "run/recorded/recorded_run.h"
#include "run/scoring.h"
#include "run/verify/repeat.h"
#include "run/verify/verify_tables.h"

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

// ---- Files ---------------------------------------------------------------------------------------------------------

static enum vw_status check_tables(struct vw_recorded_run *run, const struct vw_verify_params *params,
                                   const struct run_scores *scores) {
    struct vw_scoring scoring = scores->computed;
    if (scores->recorded_count) scoring.scores = scores->recorded, scoring.score_count = scores->recorded_count;
    const struct vw_table_sources sources = {
        .out = params->out, .ledger = run->ledger, .scoring = &scoring, .providers = params->providers};
    return vw_verify_tables(&sources);
}

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
    const struct vw_repeat_params repeated = {.run = &checks->run,
                                              .input = &checks->scores.computed.input,
                                              .device = params->device,
                                              .interrupt = &params->interrupt};
    enum vw_status status = VW_OK;
    if (params->replay_steps) status = vw_repeat_steps(&repeated, params->replay_steps, &made->replayed_steps);
    if (!status && params->lasting) status = vw_repeat_lasting(&repeated);
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
    bool by_provider = false;
    if (vw_verify_covers(name, &by_provider))
        return by_provider && params->providers ? "made again from the ledger and --providers"
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
