// A scene and a config for tests of whole runs, which take a second or less.
#ifndef VIEWWORTH_TESTS_SUPPORT_SMALL_RUN_H
#define VIEWWORTH_TESTS_SUPPORT_SMALL_RUN_H

#include <stdint.h>
#include <string.h>

#include "viewworth/train.h"

#define SMALL_SCENE VW_SOURCE_FOLDER "/tests/support/tiny.json"

static inline struct vw_config small_config(uint64_t seed, uint32_t epochs) {
    struct vw_config config = vw_config_default;
    config.seed = seed;
    config.epochs = epochs;
    config.rays = 32;
    config.samples = 8;
    config.val_rays = 64;
    config.levels = 4;
    config.log2_table = 8;
    config.width = 16;
    strcpy(config.effects, "none");
    return config;
}

#endif
