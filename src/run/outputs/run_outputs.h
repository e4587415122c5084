// The derived files of a run with scores, except scores.csv: whoever ends the run removes them all first
// (run/out_folder.h) and then makes them here.
#ifndef VIEWWORTH_RUN_OUTPUTS_RUN_OUTPUTS_H
#define VIEWWORTH_RUN_OUTPUTS_RUN_OUTPUTS_H

#include <stdbool.h>
#include <stdint.h>

#include "report/results.h"
#include "run/outputs/attribution.h"
#include "scene/view_distance.h"
#include "train/trainer.h"
#include "value/verdict.h"
#include "viewworth/report.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// All borrowed for the call.
struct vw_run_outputs_params {
    const char *out;
    const struct vw_scene *scene;
    const char *scene_options_json;
    struct vw_gpu *gpu;
    struct vw_ledger *ledger;         // opened to append
    const struct vw_scoring *scoring; // scores of the ledger
    struct vw_trainer *trainer;       // has the field of the run's end; nothing in flight
    const struct vw_config *config;
    const struct vw_effect_decision *effects;
    uint32_t effect_count;
    uint64_t payout_cents; // to be divided; 0: none
    struct vw_report_params report;
    const struct vw_photo_finding *findings; // by view, of the photos alone; NULL: they are checked here
};

// Owned; freed by vw_run_outputs_free().
struct vw_run_outputs {
    struct vw_attribution attribution;
    struct vw_results results;          // borrows from ledger and scoring
    struct vw_view_distance *distances; // distances of validation photos from the train photos
    uint32_t distance_count;
    uint32_t mask_count; // files of masks/
    char *matrix_path;   // NULL: no validated steps after burn-in
    char *report_path;
    bool has_splats; // field.ply is there
};

// Removes all derived files and writes scores.csv, before the ledger receives the scores: a ledger with scores has a
// scores.csv with them, also after a kill. `pays`: a payout is made afterwards (run/out_folder.h).
enum vw_status vw_run_scores_write(const char *out, const struct vw_scoring *scoring, bool pays);
// Checks the photos at the size that the reconstruction is measured at, whatever size is trained; by view, owned by the
// caller (free).
enum vw_status vw_run_check_photos(const struct vw_scene *scene, const char *scene_options_json, struct vw_gpu *gpu,
                                   struct vw_photo_finding **findings);
// Writes field.ply where the field is splats, with harmonics of at least a degree.
enum vw_status vw_run_splats_write(struct vw_trainer *trainer, uint32_t degree, const char *out, bool *written);
enum vw_status vw_run_splits_write(const struct vw_scene *scene, const char *out); // splits.json
// Writes the tables of providers and duplicates, a payout if one is asked for, the matrix, reconstruction.json,
// splits.json, map.json, masks, residuals.json unless the report goes without photos, field.ply where the field is
// splats, report.html and advice.csv. Warns of validation photos that look corrupted or lie far from every train photo.
// Fails at the first that cannot be made. Free the outputs also after a failure.
enum vw_status vw_run_outputs_make(const struct vw_run_outputs_params *params, struct vw_run_outputs *outputs);
void vw_run_outputs_free(struct vw_run_outputs *outputs);

#endif
