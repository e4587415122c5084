// A scene and a config for tests of whole runs, which take a second or less.
#ifndef VIEWWORTH_TESTS_SUPPORT_SMALL_RUN_H
#define VIEWWORTH_TESTS_SUPPORT_SMALL_RUN_H

#include "support/cmocka_test.h"
#include "support/plain_config.h"
#include "viewworth/run.h"

#define SMALL_SCENE VW_SOURCE_FOLDER "/tests/support/tiny.json"

static inline struct vw_config small_config(uint64_t seed, uint32_t epochs) {
    struct vw_config config = plain_config();
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

static inline struct vw_run *small_run_open(const struct vw_run_params *params) {
    struct vw_run *run = NULL;
    ASSERT_OK(vw_run_open(params, &run));
    return run;
}

// Opens a run, trains it whole, and finishes it; to be closed.
static inline struct vw_run *small_run_make(const struct vw_run_params *params) {
    struct vw_run *run = small_run_open(params);
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    ASSERT_OK(vw_run_finish(run));
    return run;
}

#endif
