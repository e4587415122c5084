#include "run/scoring.h"

#include <stdlib.h>
#include <string.h>

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

enum vw_status vw_check_scored_epochs(uint32_t epochs, uint32_t burn_in_epochs) {
    if (epochs > burn_in_epochs) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u to score; take more epochs", epochs,
                   burn_in_epochs);
}
