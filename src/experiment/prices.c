#include "experiment/prices.h"

#include <math.h>

#include "run/lasting/lasting.h"
#include "run/lasting/lasting_summary.h"
#include "run/plan/accuracy_levels.h"
#include "run/plan/plan.h"

enum { VALUE, LASTING, COMPARE, SELECT, WORTH };
const struct vw_priced_command vw_priced_commands[VW_PRICED_COMMANDS] = {
    [VALUE] = {"value", "value", 1},
    [LASTING] = {"lasting", "lasting", 7}, // the backward pass repeats the run; the others are the gate's
    [COMPARE] = {"compare", "compare --list A --list B", 6},
    [SELECT] = {"select", "select", 34}, // two seeds of 5 lists without scores, and of 6 by the scores of either half
    [WORTH] = {"worth", "worth --retrainings 64", 64},
};

// Measures steps with scoring, and without, as those of retrainings are.
static enum vw_status price_level(struct vw_trainer_params params, struct vw_level_prices *prices) {
    struct vw_estimate scored = {.seconds_per_step = NAN}, plain = scored;
    enum vw_status status = vw_estimate_take_steps(&params, &scored);
    params.validate = false;
    if (!status) status = vw_estimate_take_steps(&params, &plain);
    if (status == VW_ERROR_MEMORY) return status;
    if (status) scored = plain = (struct vw_estimate){.seconds_per_step = NAN};
    double run_s = scored.seconds_per_step * (double)scored.steps,
           training_s = plain.seconds_per_step * (double)plain.steps;
    prices->steps = scored.steps;
    for (uint32_t c = 0; c < VW_PRICED_COMMANDS; c++) prices->seconds[c] = vw_priced_commands[c].trainings * training_s;
    prices->seconds[VALUE] = run_s;
    prices->seconds[LASTING] =
        params.config->field == VW_FIELD_SPLATS
            ? NAN
            : vw_lasting_seconds(params.config, vw_lasting_has_gate(params.config), run_s, training_s);
    return VW_OK;
}

enum vw_status vw_prices_estimate(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_verdict *effects, uint32_t effect_count,
                                  struct vw_level_prices prices[VW_PRICED_LEVELS]) {
    enum vw_status status = VW_OK;
    for (uint32_t level = 0; !status && level < VW_PRICED_LEVELS; level++) {
        struct vw_config at_level = *config;
        vw_accuracy_apply(level, 0, &at_level);
        prices[level].level = vw_accuracy_level_about(level)->name;
        status = price_level((struct vw_trainer_params){.gpu = gpu,
                                                        .scene = scene,
                                                        .config = &at_level,
                                                        .effects = effects,
                                                        .effect_count = effect_count,
                                                        .validate = true},
                             &prices[level]);
    }
    return status;
}
