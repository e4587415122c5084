// The identity of a run: the row that its ledger begins with.
#ifndef VIEWWORTH_RUN_RUN_ROW_H
#define VIEWWORTH_RUN_RUN_ROW_H

#include "base/hash.h"
#include "train/trainer.h"
#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_run_row {
    struct vw_ledger_run row; // its texts are the fields below, or borrowed from scene and device
    char run_id[VW_HASH_HEX_BYTES], scene_hash[VW_HASH_HEX_BYTES], subset_hash[VW_HASH_HEX_BYTES],
        shader_hash[VW_HASH_HEX_BYTES];
    char *config_json, *effects_json; // owned
};

// Fills all of the row except scene_options_json, plan_json and started_utc. Free it also after a failure.
enum vw_status vw_run_row_make(const struct vw_trainer *trainer, const struct vw_gpu *gpu, const struct vw_scene *scene,
                               const struct vw_config *config, struct vw_run_row *row);
void vw_run_row_free(struct vw_run_row *row);

// Returns VW_ERROR_USAGE, naming what differs, unless both are the same run (by run_id). `out` is the folder of the
// recorded one.
enum vw_status vw_run_row_check_same(const struct vw_run_row *ours, const struct vw_ledger_run *recorded,
                                     const char *out);

#endif
