// The run of a folder, opened from its ledger.
#ifndef VIEWWORTH_RUN_RECORDED_RECORDED_RUN_H
#define VIEWWORTH_RUN_RECORDED_RECORDED_RUN_H

#include "train/trainer.h"
#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

struct vw_recorded_run {
    const char *out;   // borrowed
    char *ledger_path; // owned
    struct vw_ledger *ledger;
    struct vw_ledger_run row; // lent by the ledger
    struct vw_config config;
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX]; // as recorded
    uint32_t effect_count;
    struct vw_gpu *gpu;
    struct vw_scene *scene;
};

// Opens OUT's ledger and reads what the run is. Warns when the ledger does not verify or its scores are not those of
// its steps, for a reader that prints what is in it; a writer opens it again by vw_ledger_open_to_append(), which
// refuses. Close it also after a failure.
enum vw_status vw_recorded_open(const char *out, struct vw_recorded_run *run);
// Warns in the same way, of scores only where these are asked for.
enum vw_status vw_recorded_warn_unverified(struct vw_recorded_run *run, bool scores);
// Compares the recorded scores with those that steps and retrainings give. VW_ERROR_MISMATCH. A run that goes on has
// none.
enum vw_status vw_recorded_check_scores(struct vw_recorded_run *run);
// Opens it without verifying, for whoever does that.
enum vw_status vw_recorded_open_unverified(const char *out, struct vw_recorded_run *run);
// Opens the device (index or part of the name; NULL: the preferred one) and the scene, which must be the one that the
// run was trained on.
enum vw_status vw_recorded_open_scene(struct vw_recorded_run *run, const char *device);
// Returns VW_ERROR_MISMATCH unless the ledger's image rows are the photos of the open scene, so that an image_id is an
// index of its views.
enum vw_status vw_recorded_check_images(struct vw_recorded_run *run);
// Returns the params of a trainer of the run; its scene is open.
struct vw_trainer_params vw_recorded_trainer_params(const struct vw_recorded_run *run);
// Loads the field that the run ended with (OUT/field.vwf) into a trainer that takes no steps. Needs an open scene.
// VW_ERROR_INPUT for a damaged file or that of another run, and where there is none.
// Destroy the trainer also after a failure, before the run is closed.
enum vw_status vw_recorded_load_field(const struct vw_recorded_run *run, struct vw_trainer **trainer);
void vw_recorded_close(struct vw_recorded_run *run);

// ---- Steps that are taken again, for a replay, the backward pass of lasting credit and scores from gradients ----

// Refuses a run whose steps cannot be repeated, or tell nothing: imported, not finished, without validation, with
// tables of halves, not of whole epochs. Its config gets as many epochs as it has. VW_ERROR_USAGE.
enum vw_status vw_recorded_check_replay(struct vw_recorded_run *run);

// Creates a trainer of the run, which takes its steps again, and compares their identities. Needs an open scene, whose
// images were checked. VW_ERROR_USAGE names what differs. Destroy the trainer also after a failure.
enum vw_status vw_recorded_create_trainer(const struct vw_recorded_run *run, bool validated,
                                          struct vw_trainer **trainer);
struct vw_recorded_steps { // borrowed
    const char *ledger_path;
    const struct vw_step_record *records; // step 0, 1, ...
    uint64_t record_count;
};
// Compares a replayed step; a vw_step_replayed whose `context` is a struct vw_recorded_steps. Returns VW_ERROR_MISMATCH
// when the step differs from the recorded one.
enum vw_status vw_recorded_steps_compare(void *context, const struct vw_step_record *replayed);

#endif
