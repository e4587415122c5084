#include "cli/scoring.h"

#include <stdlib.h>

enum vw_status vw_scoring_make(struct vw_ledger *ledger, const struct vw_config *config, struct vw_scoring *scoring) {
    double beta1 = config->optimizer == VW_OPTIMIZER_SGD ? 0 : config->beta1; // which plain gradient descent does not use
    *scoring = (struct vw_scoring){.input = {.burn_in_epochs = config->burn_in_epochs, .beta1 = beta1}};
    struct vw_value_input *input = &scoring->input;
    struct vw_step_record *records = NULL;
    struct vw_probe *probes = NULL;
    enum vw_status status = vw_ledger_get_images(ledger, &input->images, &input->image_count);
    if (!status) status = vw_ledger_get_steps(ledger, &records, &input->record_count);
    if (!status) status = vw_ledger_get_probes(ledger, &probes, &input->probe_count);
    input->records = records;
    input->probes = probes;
    if (!status) status = vw_value_score(input, &scoring->scores, &scoring->score_count);
    if (!status) vw_value_noise_floor(input, &scoring->noise_floor);
    return status;
}

void vw_scoring_free(struct vw_scoring *scoring) {
    free((void *)scoring->input.records);
    free((void *)scoring->input.probes);
    free(scoring->scores);
}
