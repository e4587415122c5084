// The struct of a run, shared by the files that drive it.
#ifndef VIEWWORTH_RUN_RUN_PRIVATE_H
#define VIEWWORTH_RUN_RUN_PRIVATE_H

#include <stdbool.h>
#include <stdint.h>

#include "run/checkpoints.h"
#include "run/ledger_writer.h"
#include "run/out_folder.h"
#include "run/plan/training_choice.h"
#include "run/run.h"
#include "run/session.h"
#include "train/trainer.h"

struct vw_run {
    // The request.
    struct vw_config config; // its epochs follow a run that keeps a budget
    struct vw_training_choice choice;
    char *out;                // owned
    char *scene_options_json; // owned
    bool resume, validate;
    struct vw_report_options report;
    struct vw_lasting_options lasting;
    uint64_t payout_cents; // to be divided; 0: none
    vw_run_progress *progress;
    void *context;

    // The resources.
    struct vw_session own, *session; // the session is `own` unless it is shared
    uint32_t device;                 // index in the session
    struct vw_gpu *gpu;              // that device's
    struct vw_scene *scene;          // the session's
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    struct vw_trainer *trainer;
    struct vw_out_lock *lock; // lock of OUT; taken first and released last
    struct vw_checkpoints checkpoints;
    struct vw_ledger *ledger;        // NULL until the first steps are recorded, unless resumed
    struct vw_ledger_writer *writer; // NULL until the first steps are recorded; idle outside vw_run_advance()

    struct vw_photo_finding *findings; // owned; of the photos alone, before training; NULL: not checked

    // The progress.
    bool complete;          // resumed, and no step is left
    bool begun, over;       // the first advance; all steps are taken
    bool stopping;          // progress returned false
    bool advancing;         // steps up to last_step are left
    bool stepped;           // since it was opened
    bool moved;             // since the last checkpoint
    bool cleared;           // OUT has no tables of what the run was before
    bool failed;            // the ledger says how; nothing more is written
    uint64_t started_after; // the step of the checkpoint that was loaded; 0: from the start
    uint64_t trainer_step;  // the last step handed out by the trainer, or started_after
    uint64_t shown_step;    // the last one that progress has shown
    uint64_t last_step;     // the step up to which it advances now
    uint64_t stop_step;     // where a budget looks next; without one the last step
    struct {
        uint64_t first_step; // taken before the segment
        double started_s;    // vw_now_s() before it
    } segment;               // steps between two looks of a budget

    // The results.
    struct vw_run_results results;
    bool written;                   // scores.csv is of these scores; OUT has no derived file of earlier ones
    bool scored;                    // scoring contains the scores of all steps
    bool ended;                     // the ledger says "finished", with these scores
    bool finished;                  // and vw_run_score() or vw_run_finish() succeeded
    struct vw_ledger_score *ranked; // owned; the scores, method by method, each best first; strings of results.scoring
};

// Creates run->trainer, before its first step.
enum vw_status vw_run_create_trainer(struct vw_run *run);
// Takes the recorded steps again that the loaded checkpoint lacks, so that the trainer has the field of the last one.
enum vw_status vw_run_catch_up(struct vw_run *run);
// Saves the state of the trainer if it has moved since the last checkpoint; nothing may be in flight.
void vw_run_save_checkpoint(struct vw_run *run);
// Says what may help a run whose steps are not finite.
const char *vw_run_remedy(const struct vw_run *run);
// Returns the number of steps that the run is expected to have at its end.
uint64_t vw_run_expected_steps(const struct vw_run *run);
// Saves a checkpoint of a run that was not finished and marks it "interrupted"; call before closing.
void vw_run_leave(struct vw_run *run);
// Marks a run that stops early "interrupted" or "failed", with the scores so far. The recorded message stays. A ledger
// that had ended before, and to which nothing was added, is left as it was; so is one whose steps do not match.
void vw_run_end_early(struct vw_run *run, enum vw_status status);

#endif
