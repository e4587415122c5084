// What a run is: the hashes that name it (decision 11).
#ifndef VIEWWORTH_TRAIN_IDENTITY_H
#define VIEWWORTH_TRAIN_IDENTITY_H

#include "train/model.h"
#include "viewworth/types.h"

struct run_identity { // all borrowed
    const struct vw_gpu_info *device;
    const struct vw_scene *scene;
    const uint32_t *train_views; // scene indices
    uint32_t train_count;
    const struct vw_config *config;
    const struct vw_effect_verdict *effects;
    uint32_t effect_count;
    const struct model *model;
    bool validates; // after every step
};

enum vw_status identity_run_id(const struct run_identity *identity, uint8_t run_id[VW_HASH_BYTES]);
void identity_subset_hash(const struct run_identity *identity, uint8_t hash[VW_HASH_BYTES]); // of the train views

#endif
