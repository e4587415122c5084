#include "lab/methods/registry.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "base/memory.h"

const struct vw_retraining_method *const vw_retraining_methods[] = {
    &vw_tmc_shapley, &vw_data_banzhaf, &vw_left_out_method, &vw_data_oob, &vw_dvrl, &vw_g_shapley,
};
const uint32_t vw_retraining_method_count = VW_ARRAY_COUNT(vw_retraining_methods);

static bool is_method(const char *name, size_t length) {
    for (uint32_t i = 0; i < vw_retraining_method_count; i++)
        if (strlen(vw_retraining_methods[i]->name) == length && !strncmp(vw_retraining_methods[i]->name, name, length))
            return true;
    return false;
}

bool vw_is_method_and_budget(const char *name) {
    const char *budget = strrchr(name, '_');
    return budget && budget[1] && strspn(budget + 1, "0123456789N/") == strlen(budget + 1) &&
           is_method(name, (size_t)(budget - name));
}

// ---- Cost ----

// Passes on calls between a method and its retrainings.
struct meter {
    const struct vw_retraining_input *input;
    struct vw_retraining_cost cost;
    uint64_t photo_epochs; // trained on
};

static uint64_t photo_epochs_of(const struct vw_retraining_input *input, const struct vw_retrain_params *retraining) {
    uint32_t epochs = retraining->epochs ? retraining->epochs : input->epochs;
    uint32_t photos = input->equal == VW_EQUAL_EPOCHS ? retraining->view_count : input->photo_count;
    return retraining->view_count > 0 ? (uint64_t)photos * epochs : 0;
}

static enum vw_status retrain_and_count(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                                        struct vw_retrain_result *results) {
    struct meter *meter = context;
    enum vw_status status = meter->input->retrain(meter->input->context, retrainings, count, results);
    for (uint32_t i = 0; !status && i < count; i++) {
        meter->photo_epochs += photo_epochs_of(meter->input, &retrainings[i]);
        meter->cost.seconds += results[i].seconds;
        meter->cost.retrainings++;
    }
    return status;
}

enum vw_status vw_retraining_method_score(const struct vw_retraining_method *method,
                                          const struct vw_retraining_input *input, double *scores,
                                          struct vw_retraining_cost *cost) {
    struct meter meter = {.input = input};
    struct vw_retraining_input metered = *input;
    metered.retrain = retrain_and_count;
    metered.context = &meter;
    if (input->budget < method->least_budget(input))
        return vw_fail(VW_ERROR_USAGE, "%s needs a budget of at least %" PRIu32 " trainings, not %" PRIu32,
                       method->name, method->least_budget(input), input->budget);
    for (uint32_t i = 0; i < input->photo_count; i++) scores[i] = NAN;
    enum vw_status status = method->score(&metered, scores);
    meter.cost.run_equivalents = (double)meter.photo_epochs / ((double)input->photo_count * input->epochs);
    *cost = meter.cost;
    return status;
}
