#include "support/open_trainer.h"

#include "detect/decide.h"

enum vw_status test_trainer_open(struct vw_trainer_params params, struct vw_trainer **trainer) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    if (!params.effects) {
        enum vw_status status =
            vw_effects_find_facts(params.scene, params.config->effects, effects, &params.effect_count);
        if (status) return status;
        params.effects = effects;
    }
    return vw_trainer_create(&params, trainer);
}
