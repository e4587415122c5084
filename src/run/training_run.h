// A training from the command line, and its ledger: what value and train share.
#ifndef VIEWWORTH_TRAINING_RUN_H
#define VIEWWORTH_TRAINING_RUN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/checkpoints.h"
#include "cli/options.h"
#include "run/profile.h"
#include "run/scoring.h"
#include "run/session.h"
#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"
#include "value/stability.h"
#include "viewworth/status.h"
#include "value/step_statistics.h"
#include "train/trainer.h"
#include "viewworth/train.h"

struct vw_training_run {
    const struct vw_options *options;
    double opened_s;                              // vw_now_s() at the start
    char *ledger_path, *scores_path, *field_path; // owned; in the --out folder
    bool validate;                                // `value`, not `train`
    struct vw_gpu *gpu;                           // of the session
    struct vw_scene *scene;                       // likewise
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    struct vw_trainer *trainer;
    struct vw_checkpoints checkpoints;
    struct vw_ledger *ledger;             // NULL until the first steps are recorded, unless resumed
    bool complete;                        // resumed, and nothing is left to do
    struct vw_profile profile;            // of the steps taken, once they are; without rows unless asked for
    uint64_t started_after;               // the step of the checkpoint that the run went on from; 0: from the start
    struct vw_step_statistics statistics; // of the steps in the ledger
    struct {
        uint64_t first_step;       // of those up to which the run is held
        double started_s;          // vw_now_s() before it
    } segment;                     // private to cli/epoch_ends.c
    struct vw_stability stability; // of its scores, when the run was last held; all 0 without --until-stable
};

// Opens the trainer on the session, and the session unless it is open (for the same options of device and scene), and
// says what was found. An
// --out folder that holds a run is refused before any work, or, with --resume, opened where its ledger and newest
// checkpoint are. Close it also after a failure, and before the session.
enum vw_status vw_training_open(const struct vw_options *options, bool validate, struct vw_session *session,
                                struct vw_training_run *run);
// Takes the steps that are left and records them; steps between the checkpoint and the ledger's end are compared
// instead. --out and its ledger appear with the first recorded steps. A failure or an interruption later keeps what is
// recorded and leaves the ledger marked "failed" or "interrupted", with the scores so far.
enum vw_status vw_training_take_steps(struct vw_training_run *run);
// Removes the tables that an earlier end of the run left beside scores.csv, and writes the trained field, and
// scores.csv unless `images` is NULL; then marks the ledger "finished" with these scores, or "failed" when that did not
// succeed. Does nothing on a complete run.
enum vw_status vw_training_finish(struct vw_training_run *run, const struct vw_ledger_score *scores,
                                  uint32_t score_count, const struct vw_ledger_image *images, uint32_t image_count);
// Scores what the ledger holds, and finishes with these scores. The scoring is to be freed, also after a failure.
enum vw_status vw_training_score_and_finish(struct vw_training_run *run, struct vw_scoring *scoring);
void vw_training_close(struct vw_training_run *run);

// What the run was and where its results are, with the profile when that was asked for; NULL when memory is short.
json_t *vw_training_to_json(const struct vw_training_run *run);

#endif
