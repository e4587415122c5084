// What a run is: hashes that name it (decision 11).
#include <stdlib.h>

#include "gpu/shaders.h"
#include "train/trainer.h"
#include "viewworth/version.h"
#include "base/hash.h"
#include "train/trainer_private.h"

const char *vw_version(void) { return VW_VERSION; }

void vw_shader_hash(uint8_t hash[32]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < vw_shader_count; i++) {
        vw_hasher_add_text(&hasher, vw_shaders[i]->name);
        vw_hasher_add_bytes(&hasher, vw_shaders[i]->code, vw_shaders[i]->code_bytes);
    }
    vw_hasher_end(&hasher, hash);
}

void vw_trainer_subset_hash(const struct vw_trainer *trainer, uint8_t hash[32]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < trainer->train_count; i++)
        vw_hasher_add_text(&hasher, trainer->scene->views[trainer->train_views[i]].name);
    vw_hasher_end(&hasher, hash);
}

enum vw_status vw_trainer_run_id(const struct vw_trainer *trainer, uint8_t run_id[32]) {
    uint8_t subset[32], shaders[32];
    const struct vw_gpu_info *info = vw_gpu_get_info(trainer->gpu);
    char *config = vw_config_to_json(&trainer->config, true);
    if (!config) return VW_ERROR_MEMORY;
    vw_trainer_subset_hash(trainer, subset);
    vw_shader_hash(shaders);
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_bytes(&hasher, trainer->scene->hash, sizeof trainer->scene->hash);
    vw_hasher_add_bytes(&hasher, subset, sizeof subset);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher,
                          trainer->validate); // `train` records no validation: another ledger, if the same params
    for (uint32_t i = 0; i < trainer->effect_count; i++)
        if (trainer->effects[i].on) vw_hasher_add_text(&hasher, trainer->effects[i].name);
    if (trainer->model.specialization
            .effect_unbounded) { // its box depends on points, which the scene's hash does not cover
        for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, trainer->model.box.centre_world[i]);
        vw_hasher_add_real(&hasher, trainer->model.box.half_extent_world);
    }
    vw_hasher_add_bytes(&hasher, shaders, sizeof shaders);
    vw_hasher_add_text(&hasher, vw_version());
    vw_hasher_add_text(&hasher, info->name);
    vw_hasher_add_text(&hasher, info->driver);
    vw_hasher_end(&hasher, run_id);
    free(config);
    return VW_OK;
}
