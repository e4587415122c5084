#include "run/next/next.h"

#include <stdlib.h>

#include "base/file.h"
#include "run/next/next_private.h"
#include "run/out_folder.h"
#include "run/out_lock.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static const double MATTER_SHARE = 0.5; // a ray ends at this transmittance

static enum vw_status render_depths(void *context, const uint32_t *views, const struct vw_view *poses, uint32_t count,
                                    float **depths_world) {
    return vw_trainer_render_poses(context, views, poses, count, MATTER_SHARE, depths_world);
}

static enum vw_status propose(const struct vw_next_params *params, const struct vw_recorded_run *run,
                              struct vw_trainer *trainer, struct vw_next *next) {
    struct vw_known_photos known;
    enum vw_status status = vw_known_photos_create(run->scene, run->config.seed, render_depths, trainer, &known);
    if (!status) status = vw_known_photos_measure(&known, trainer);
    if (!status)
        status = params->among
                     ? vw_camera_path_read(run->scene, params->among, known.views[known.usual], &next->candidates)
                     : vw_next_candidates_make(&known, &next->candidates);
    if (!status) status = vw_next_choose(&known, params->count, next);
    if (!status) status = vw_next_describe(&known, next);
    if (!status && next->proposal_count < params->count)
        vw_log_warning("%u places were found for --count %u; all are proposed", next->proposal_count, params->count);
    vw_known_photos_destroy(&known);
    return status;
}

static enum vw_status make_locked(const struct vw_next_params *params, struct vw_next *next) {
    struct vw_recorded_run run = {0};
    struct vw_trainer *trainer = NULL;
    enum vw_status status = vw_recorded_open(params->out, &run);
    if (!status) status = vw_recorded_open_scene(&run, params->device);
    if (!status) status = vw_recorded_load_field(&run, &trainer);
    if (!status) status = propose(params, &run, trainer, next);
    if (!status) status = vw_next_write(params, next, run.scene, trainer);
    vw_trainer_destroy(&trainer);
    vw_recorded_close(&run);
    return status;
}

enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next) {
    struct vw_out_lock *lock = NULL;
    *next = (struct vw_next){0};
    enum vw_status status = vw_out_check_target("to", params->to, params->out, true);
    if (!status && vw_folder_exists(params->out)) status = vw_out_lock_take(params->out, &lock);
    if (!status) status = make_locked(params, next);
    vw_out_lock_release(&lock);
    return status;
}

void vw_next_free(struct vw_next *next) {
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        free(next->proposals[k].nearest);
        free(next->proposals[k].move);
    }
    vw_camera_path_free(&next->candidates);
    free(next->proposals);
    *next = (struct vw_next){0};
}
