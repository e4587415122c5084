#include "run/scoring.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "viewworth/log.h"

enum vw_status vw_scoring_load(struct vw_ledger *ledger, const struct vw_config *config, struct vw_value_input *input) {
    double beta1 =
        config->optimizer == VW_OPTIMIZER_SGD ? 0 : config->beta1; // which plain gradient descent does not use
    *input = (struct vw_value_input){.burn_in_epochs = config->burn_in_epochs, .beta1 = beta1};
    struct vw_step_record *records = NULL;
    enum vw_status status = vw_ledger_get_images(ledger, &input->images, &input->image_count);
    if (!status) status = vw_ledger_get_steps(ledger, &records, &input->record_count);
    input->records = records;
    return status ? status : vw_ledger_get_lasting(ledger, &input->lasting);
}

void vw_scoring_unload(struct vw_value_input *input) {
    free((void *)input->records);
    vw_lasting_pass_free(&input->lasting);
}

struct vw_worth_input vw_scoring_worth_input(const struct vw_scoring *scoring) {
    return (struct vw_worth_input){.retrainings = scoring->retrainings,
                                   .retraining_count = scoring->retraining_count,
                                   .images = scoring->input.images,
                                   .image_count = scoring->input.image_count,
                                   .scores = scoring->scores,
                                   .score_count = scoring->score_count};
}

const char *vw_scoring_payout_method(const struct vw_ledger_score *scores, uint32_t score_count) {
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, vw_worth_method) == 0) return vw_worth_method;
    return vw_value_default_method;
}

// Adds worth last, since the other scores are its prior.
static enum vw_status add_worth(struct vw_scoring *scoring) {
    size_t most = (size_t)scoring->score_count + scoring->input.image_count;
    if (!scoring->retraining_count || !scoring->score_count) return VW_OK;
    struct vw_ledger_score *longer = realloc(scoring->scores, most * sizeof *longer);
    if (!longer) return vw_fail(VW_ERROR_MEMORY, "out of memory for %zu scores", most);
    scoring->scores = longer;
    const struct vw_worth_input input = vw_scoring_worth_input(scoring);
    return vw_worth_append(&input, longer, &scoring->score_count);
}

enum vw_status vw_scoring_set_retrainings(struct vw_scoring *scoring, struct vw_ledger_retraining *retrainings,
                                          uint32_t count) {
    free(scoring->retrainings);
    scoring->retrainings = retrainings;
    scoring->retraining_count = count;
    while (scoring->score_count && !strcmp(scoring->scores[scoring->score_count - 1].method, vw_worth_method))
        scoring->score_count--;
    return add_worth(scoring);
}

enum vw_status vw_scoring_repeat(struct vw_scoring *scoring) {
    struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_value_score(&scoring->input, &scores, &count);
    if (status) return status;
    free(scoring->scores);
    scoring->scores = scores;
    scoring->score_count = count;
    return add_worth(scoring);
}

enum vw_status vw_scoring_make(struct vw_ledger *ledger, const struct vw_config *config, struct vw_scoring *scoring) {
    *scoring = (struct vw_scoring){0};
    enum vw_status status = vw_scoring_load(ledger, config, &scoring->input);
    if (!status) status = vw_ledger_get_retrainings(ledger, &scoring->retrainings, &scoring->retraining_count);
    return status ? status : vw_scoring_repeat(scoring);
}

void vw_scoring_free(struct vw_scoring *scoring) {
    vw_scoring_unload(&scoring->input);
    free(scoring->scores);
    free(scoring->retrainings);
}

void vw_scoring_end_early(struct vw_ledger *ledger, const struct vw_config *config, const char *outcome) {
    struct vw_scoring scoring;
    char finished_utc[VW_UTC_BYTES];
    vw_utc_now(finished_utc);
    enum vw_status status = vw_scoring_make(ledger, config, &scoring);
    if (!status) status = vw_ledger_finish(ledger, outcome, finished_utc, scoring.scores, scoring.score_count);
    if (status && status != VW_ERROR_MEMORY) // which is what ends the run then, and is said once
        vw_log_warning("the run is not marked as %s: %s", outcome, vw_error_message());
    vw_scoring_free(&scoring);
}

// ---- Comparison with the recorded ones -----------------------------------------------------------------------------

// Returns whether two reals agree up to the last digits. The hashes fix recorded scores to the bit; here they are
// compared with scores made anew, and another C library rounds cosines and roots differently.
static bool same_real(double a, double b, double scale) {
    return a == b || (isnan(a) && isnan(b)) ||
           fabs(a - b) <= 1e-9 * fmax(fmax(fabs(a), fabs(b)), isfinite(scale) ? scale : 0);
}

static bool same_score(const struct vw_ledger_score *a, const struct vw_ledger_score *b) {
    double scale = a->standard_error;
    return strcmp(a->method, b->method) == 0 && a->image_id == b->image_id && same_real(a->value, b->value, scale) &&
           strcmp(a->unit, b->unit) == 0 && same_real(a->standard_error, b->standard_error, 0) &&
           a->visits == b->visits && same_real(a->ci_low, b->ci_low, scale) &&
           same_real(a->ci_high, b->ci_high, scale) && a->rank_ci_low == b->rank_ci_low &&
           a->rank_ci_high == b->rank_ci_high;
}

// Compares scores that are sorted by method, and by photo within a method.
static enum vw_status compare(const struct vw_scoring *scoring, const struct vw_ledger_score *recorded,
                              uint32_t recorded_count, const char *path) {
    if (recorded_count != scoring->score_count)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: holds %u scores where its steps give %u, unless another version of viewworth made them",
                       path, recorded_count, scoring->score_count);
    for (uint32_t i = 0; i < recorded_count; i++)
        if (!same_score(&recorded[i], &scoring->scores[i]))
            return vw_fail(
                VW_ERROR_MISMATCH, "%s: score %s of image %u, or its place, is not what its steps give: %s of image %u",
                path, recorded[i].method, recorded[i].image_id, scoring->scores[i].method, scoring->scores[i].image_id);
    return VW_OK;
}

enum vw_status vw_scoring_compare(const struct vw_scoring *scoring, struct vw_ledger *ledger, const char *path) {
    struct vw_ledger_score *recorded = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_ledger_get_scores(ledger, &recorded, &count);
    if (!status) status = compare(scoring, recorded, count, path);
    free(recorded);
    return status;
}

enum vw_status vw_check_scored_epochs(uint32_t epochs, uint32_t burn_in_epochs) {
    if (epochs > burn_in_epochs) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u to score; take more epochs", epochs,
                   burn_in_epochs);
}
