#include "train/identity.h"

#include <stdlib.h>

#include "base/hash.h"
#include "gpu/shaders.h"
#include "train/trainer.h"
#include "viewworth/version.h"

const char *vw_version(void) { return VW_VERSION; }

void vw_shader_hash(uint8_t hash[VW_HASH_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < vw_shader_count; i++) {
        vw_hasher_add_text(&hasher, vw_shaders[i]->name);
        vw_hasher_add_bytes(&hasher, vw_shaders[i]->code, vw_shaders[i]->code_bytes);
    }
    vw_hasher_end(&hasher, hash);
}

void vw_identity_subset_hash(const struct vw_scene *scene, const struct vw_photo_order *photo_order,
                             uint8_t hash[VW_HASH_BYTES]) {
    const uint32_t *views = photo_order->train_views;
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    for (uint32_t i = 0; i < photo_order->train_count; i++) vw_hasher_add_text(&hasher, scene->views[views[i]].name);
    if (photo_order->kept) vw_hasher_add_text(&hasher, "kept");
    for (uint32_t i = 0; photo_order->kept && i < photo_order->kept_count; i++)
        vw_hasher_add_text(&hasher, scene->views[views[photo_order->kept[i]]].name);
    vw_hasher_end(&hasher, hash);
}

static void add_effects(const struct vw_run_identity *identity, struct vw_hasher *hasher) {
    const struct vw_box *box = identity->effect_box;
    for (uint32_t i = 0; i < identity->effect_count; i++)
        if (identity->effects[i].on) vw_hasher_add_text(hasher, identity->effects[i].name);
    if (!box) return;
    for (int i = 0; i < 3; i++) vw_hasher_add_real(hasher, box->centre_world[i]);
    vw_hasher_add_real(hasher, box->half_extent_world);
}

static void add_exposures(const struct vw_run_identity *identity, struct vw_hasher *hasher) {
    for (uint32_t i = 0; i < identity->exposure_count; i++) {
        vw_hasher_add_text(hasher, identity->exposures[i].photo);
        for (int k = 0; k < 6; k++) vw_hasher_add_real(hasher, identity->exposures[i].numbers[k]);
    }
}

enum vw_status vw_identity_run_id(const struct vw_run_identity *identity, uint8_t run_id[VW_HASH_BYTES]) {
    char *config = vw_config_to_json(identity->config, true);
    if (!config) return VW_ERROR_MEMORY;
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_bytes(&hasher, identity->scene_hash, sizeof identity->scene_hash);
    vw_hasher_add_bytes(&hasher, identity->subset_hash, sizeof identity->subset_hash);
    vw_hasher_add_text(&hasher, config);
    vw_hasher_add_integer(&hasher, identity->validates); // `train` records no validation: another ledger
    add_effects(identity, &hasher);
    add_exposures(identity, &hasher);
    vw_hasher_add_bytes(&hasher, identity->shader_hash, sizeof identity->shader_hash);
    vw_hasher_add_text(&hasher, identity->version);
    vw_hasher_add_text(&hasher, identity->device);
    vw_hasher_add_text(&hasher, identity->driver);
    vw_hasher_end(&hasher, run_id);
    free(config);
    return VW_OK;
}
