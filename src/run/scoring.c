#include "run/scoring.h"

#include <stdlib.h>

enum vw_status vw_scoring_load(struct vw_ledger *ledger, const struct vw_config *config, struct vw_value_input *input) {
    double beta1 =
        config->optimizer == VW_OPTIMIZER_SGD ? 0 : config->beta1; // which plain gradient descent does not use
    *input = (struct vw_value_input){.burn_in_epochs = config->burn_in_epochs, .beta1 = beta1};
    struct vw_step_record *records = NULL;
    struct vw_probe *probes = NULL;
    enum vw_status status = vw_ledger_get_images(ledger, &input->images, &input->image_count);
    if (!status) status = vw_ledger_get_steps(ledger, &records, &input->record_count);
    if (!status) status = vw_ledger_get_probes(ledger, &probes, &input->probe_count);
    input->records = records;
    input->probes = probes;
    return status ? status : vw_ledger_get_lasting(ledger, &input->lasting);
}

void vw_scoring_unload(struct vw_value_input *input) {
    free((void *)input->records);
    free((void *)input->probes);
    vw_lasting_sweep_free(&input->lasting);
}

enum vw_status vw_scoring_make(struct vw_ledger *ledger, const struct vw_config *config, struct vw_scoring *scoring) {
    *scoring = (struct vw_scoring){0};
    enum vw_status status = vw_scoring_load(ledger, config, &scoring->input);
    if (!status) status = vw_value_score(&scoring->input, &scoring->scores, &scoring->score_count);
    if (!status) vw_value_noise_floor(&scoring->input, &scoring->noise_floor);
    return status;
}

void vw_scoring_free(struct vw_scoring *scoring) {
    vw_scoring_unload(&scoring->input);
    free(scoring->scores);
}
