// The identity of a run: the hashes that name it (decision 11).
#ifndef VIEWWORTH_TRAIN_IDENTITY_H
#define VIEWWORTH_TRAIN_IDENTITY_H

#include "train/photo_order.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

// The exposure that a train photo is corrected by from the first step on.
struct vw_run_exposure {
    const char *photo; // borrowed
    double numbers[6]; // gain minus 1 of each channel, then bias
};

struct vw_run_identity { // its pointers are borrowed
    uint8_t scene_hash[VW_HASH_BYTES], subset_hash[VW_HASH_BYTES], shader_hash[VW_HASH_BYTES];
    const char *version, *device, *driver;
    const struct vw_config *config;
    const struct vw_effect_decision *effects;
    uint32_t effect_count;
    const struct vw_box *effect_box; // that the field sees with the effect unbounded or wide_box; NULL without them
    const struct vw_run_exposure *exposures; // with the effect appearance, of a scene with points
    uint32_t exposure_count;
    bool validates; // after every step
};

enum vw_status vw_identity_run_id(const struct vw_run_identity *identity, uint8_t run_id[VW_HASH_BYTES]);
// Hashes the names of the train views in their order, without those that are left out.
void vw_identity_subset_hash(const struct vw_scene *scene, const struct vw_photo_order *photo_order,
                             uint8_t hash[VW_HASH_BYTES]);

#endif
