// A training from the command line, and its ledger: what value and train share.
#ifndef VIEWWORTH_CLI_TRAINING_RUN_H
#define VIEWWORTH_CLI_TRAINING_RUN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "cli/options.h"
#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_training_run {
    const struct vw_options *options;
    char *ledger_path, *scores_path, *field_path; // owned; in the --out folder
    struct vw_gpu *gpu;
    struct vw_scene *scene;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    struct vw_trainer *trainer;
    struct vw_ledger *ledger;
    uint64_t done_steps;
    double first_val_psnr_db, last_val_psnr_db; // of the untrained and the trained field; NaN without validation
};

// Opens device, scene and trainer, and says what was found. Refuses, before any work, an --out folder that holds a run.
// Close it also after a failure.
enum vw_status vw_training_open(const struct vw_options *options, bool validate, struct vw_training_run *run);
// Takes all steps and records them. --out and its ledger appear with the first recorded steps. A failure or an interruption later
// keeps what is recorded and leaves the ledger marked "failed" or "interrupted".
enum vw_status vw_training_take_steps(struct vw_training_run *run);
// Writes the trained field, and scores.csv unless `images` is NULL; then marks the ledger "finished" with these scores, or "failed" when an
// output could not be written.
enum vw_status vw_training_finish(struct vw_training_run *run, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count);
void vw_training_close(struct vw_training_run *run);

// What the run was and where its results are; NULL when memory is short.
json_t *vw_training_to_json(const struct vw_training_run *run);

#endif
