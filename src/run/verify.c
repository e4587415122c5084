#include "run/verify.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "run/imported.h"
#include "run/recorded_run.h"
#include "run/identity.h"
#include "train/trainer.h"
#include "run/scoring.h"

// ---- Scores --------------------------------------------------------------------------------------------------------

static int compare_keys(const void *left, const void *right) {
    const struct vw_ledger_score *a = left, *b = right;
    int order = strcmp(a->method, b->method);
    if (order) return order;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

// The hashes hold recorded scores to the bit. Here they are held against the steps, and another C library rounds
// cosines and roots another way: what differs in the last digits, also of an end of an interval near 0, is the same.
static bool same_real(double a, double b, double scale) {
    return a == b || (isnan(a) && isnan(b)) ||
           fabs(a - b) <= 1e-9 * fmax(fmax(fabs(a), fabs(b)), isfinite(scale) ? scale : 0);
}

static bool same_score(const struct vw_ledger_score *a, const struct vw_ledger_score *b) {
    double scale = a->standard_error;
    return compare_keys(a, b) == 0 && same_real(a->value, b->value, scale) && strcmp(a->unit, b->unit) == 0 &&
           same_real(a->standard_error, b->standard_error, 0) && a->visits == b->visits &&
           same_real(a->resampling_stderr, b->resampling_stderr, 0) && same_real(a->ci_low, b->ci_low, scale) &&
           same_real(a->ci_high, b->ci_high, scale) && a->rank_ci_low == b->rank_ci_low &&
           a->rank_ci_high == b->rank_ci_high;
}

// Sorts both.
static enum vw_status compare_scores(const struct vw_recorded_run *run, struct vw_ledger_score *recorded,
                                     uint32_t recorded_count, struct vw_ledger_score *computed,
                                     uint32_t computed_count) {
    if (recorded_count != computed_count)
        return vw_fail(VW_ERROR_MISMATCH, "%s: holds %u scores where its steps give %u", run->ledger_path,
                       recorded_count, computed_count);
    if (recorded_count == 0) return VW_OK; // there may be no array to sort
    qsort(recorded, recorded_count, sizeof *recorded, compare_keys);
    qsort(computed, computed_count, sizeof *computed, compare_keys);
    for (uint32_t i = 0; i < recorded_count; i++)
        if (!same_score(&recorded[i], &computed[i]))
            return vw_fail(VW_ERROR_MISMATCH, "%s: score %s of image %u is not what its steps give", run->ledger_path,
                           recorded[i].method, recorded[i].image_id);
    return VW_OK;
}

// A run has scores once it has ended, however it did; one that failed may have had no room left for them.
static enum vw_status check_scores(struct vw_recorded_run *run, uint32_t *count) {
    struct vw_ledger_score *recorded = NULL;
    struct vw_scoring computed = {0};
    bool ended = strcmp(run->row.status, "running") != 0;
    enum vw_status status = vw_ledger_get_scores(run->ledger, &recorded, count);
    if (!status && *count == 0 && strcmp(run->row.status, "failed") == 0) ended = false;
    if (!status && ended) status = vw_scoring_make(run->ledger, &run->config, &computed);
    if (!status) status = compare_scores(run, recorded, *count, computed.scores, computed.score_count);
    vw_scoring_free(&computed);
    free(recorded);
    return status;
}

static enum vw_status check_head(const struct vw_recorded_run *run, const char *expected) {
    char head[VW_HASH_HEX_BYTES];
    vw_ledger_chain_head(run->ledger, head);
    if (!expected || strcasecmp(head, expected) == 0) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: its head is %s, not the one that --expect gives: another run, continued since, or rewritten",
                   run->ledger_path, head);
}

// `log_sha256` is left as it is unless the run was imported.
static enum vw_status check_import(const struct vw_recorded_run *run, char log_sha256[VW_HASH_HEX_BYTES]) {
    enum vw_status status = vw_is_imported(&run->row) ? vw_imported_check(&run->row, &run->config, log_sha256) : VW_OK;
    return status ? vw_fail_context(status, "%s", run->ledger_path) : VW_OK;
}

// ---- Replay --------------------------------------------------------------------------------------------------------

// Takes steps until `wanted` of them were compared, or all.
static enum vw_status compare_steps(struct vw_recorded_run *run, struct vw_trainer *trainer, uint64_t wanted,
                                    const struct vw_interrupt *interrupt, uint64_t *compared) {
    uint32_t validation_count = 0, count = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(trainer, &validation_count);
    const struct vw_step_record *records = NULL;
    uint64_t end = vw_ledger_next_step(run->ledger);
    if (wanted < end) end = wanted + 1; // step 0 comes for free
    enum vw_status status = vw_trainer_advance(trainer, &records, &count);
    while (!status && count > 0 && records[0].step < end) {
        if (records[0].step + count > end) count = (uint32_t)(end - records[0].step);
        status = vw_ledger_compare(run->ledger, records, count, validation_views);
        if (!status) *compared = records[count - 1].step;
        if (!status && vw_interrupt_requested(interrupt))
            status = vw_fail(VW_ERROR_INTERRUPTED, "interrupted after step %" PRIu64, *compared);
        if (!status) status = vw_trainer_advance(trainer, &records, &count);
    }
    return status;
}

static enum vw_status check_same_run(const struct vw_recorded_run *run, const struct vw_trainer *trainer) {
    struct vw_run_row ours;
    enum vw_status status = vw_run_row_make(trainer, run->gpu, run->scene, &run->config, &ours);
    if (!status) status = vw_run_row_check_same(&ours, &run->row, run->out);
    vw_run_row_free(&ours);
    return status;
}

// Whether the run is one of `value`: the untrained field has a validation, or one that is not finite.
static enum vw_status find_validated(struct vw_recorded_run *run, bool *validated) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_get_steps(run->ledger, &records, &count);
    if (!status) *validated = count > 0 && (records[0].validated || records[0].nonfinite);
    free(records);
    return status;
}

static enum vw_status replay(struct vw_recorded_run *run, const struct vw_verify_params *params, uint64_t *compared) {
    struct vw_trainer *trainer = NULL;
    bool validated = false;
    enum vw_status status = find_validated(run, &validated);
    if (!status) status = vw_recorded_open_scene(run, params->device ? params->device : run->row.device);
    if (status) return status;
    const struct vw_trainer_params of_trainer = {.gpu = run->gpu,
                                                 .scene = run->scene,
                                                 .config = &run->config,
                                                 .effects = run->effects,
                                                 .effect_count = run->effect_count,
                                                 .validate = validated};
    status = vw_trainer_create(&of_trainer, &trainer);
    if (!status) status = check_same_run(run, trainer);
    if (!status) status = compare_steps(run, trainer, params->replay_steps, &params->interrupt, compared);
    vw_trainer_destroy(&trainer);
    return status;
}

static enum vw_status check_expected(const char *expected) {
    if (!expected ||
        (strlen(expected) == VW_HASH_HEX_BYTES - 1 && !expected[strspn(expected, "0123456789abcdefABCDEF")]))
        return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--expect: \"%s\" is no head, which has 64 hexadecimal digits", expected);
}

// ---- All checks ----------------------------------------------------------------------------------------------------

static void tell(struct vw_recorded_run *run, struct vw_verification *verification) {
    uint64_t rows = vw_ledger_next_step(run->ledger);
    verification->ledger_path = run->ledger_path;
    run->ledger_path = NULL; // owned by the verification now
    verification->steps = rows > 0 ? rows - 1 : 0;
    snprintf(verification->run_id, sizeof verification->run_id, "%s", run->row.run_id);
    snprintf(verification->status, sizeof verification->status, "%s", run->row.status);
    vw_ledger_chain_head(run->ledger, verification->head);
}

enum vw_status vw_run_verify(const struct vw_verify_params *params, struct vw_verification *verification) {
    struct vw_recorded_run run;
    struct vw_verification made = {0};
    enum vw_status status = check_expected(params->expect);
    if (status) return status;
    status = vw_recorded_open(params->out, &run);
    if (run.row.run_id) { // also when the config cannot be read, for which an edit is the likely cause
        enum vw_status intact = vw_ledger_verify(run.ledger);
        if (intact) status = intact;
    }
    if (!status) status = check_import(&run, made.log_sha256);
    if (!status) status = check_scores(&run, &made.score_count);
    if (!status) status = check_head(&run, params->expect);
    if (!status && params->replay_steps && vw_ledger_next_step(run.ledger) > 0)
        status = replay(&run, params, &made.replayed_steps);
    if (!status) tell(&run, &made);
    if (!status) *verification = made;
    vw_recorded_close(&run);
    return status;
}

void vw_verification_free(struct vw_verification *verification) {
    free(verification->ledger_path);
    *verification = (struct vw_verification){0};
}
