// A valued run whose scores choose photos, for select and compare.
#ifndef VIEWWORTH_RUN_RECORDED_SCORED_RUN_H
#define VIEWWORTH_RUN_RECORDED_SCORED_RUN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "run/recorded/recorded_run.h"
#include "viewworth/selection.h"

struct vw_scored_run {
    struct vw_recorded_run recorded;
    json_t *scene_options;                // owned: what the run's scene was opened with
    const struct vw_ledger_image *images; // lent by the ledger
    uint32_t image_count;
};

// Opens OUT's ledger. Returns VW_ERROR_MISMATCH for scores that steps and retrainings do not give, since a list is
// chosen by them. Close it also after a failure.
enum vw_status vw_scored_run_open(const char *out, struct vw_scored_run *run);
// Warns if the run is not finished, and if it injected corruption into another number of photos than `corrupt`, the
// number where its scores are used.
void vw_scored_run_warn(const struct vw_scored_run *run, uint32_t corrupt);
// Chooses by its scores, as vw_selection_make() does.
enum vw_status vw_scored_run_select(const struct vw_scored_run *run, const struct vw_selection_params *params,
                                    struct vw_selection *selection);
void vw_scored_run_close(struct vw_scored_run *run);

uint32_t vw_scored_run_train_count(const struct vw_scored_run *run);
// Writes a selection of the run's images to the path `to`, as vw_photo_list_write() does. Without a selection it only
// checks whether one can be written there.
enum vw_status vw_selection_list_write(const struct vw_scored_run *run, const struct vw_selection *selection,
                                       const char *to);

// Refuses what vw_selection_copy() would refuse of any selection: a run or a scene without photo files, and a folder
// with files.
enum vw_status vw_selection_copy_check(const struct vw_scored_run *run, const char *to);
// Copies the selected photos, and those that validate and test, to the folder `to`, as vw_scene_copy() does.
enum vw_status vw_selection_copy(const struct vw_scored_run *run, const struct vw_selection *selection, const char *to,
                                 const struct vw_interrupt *interrupt);

#endif
