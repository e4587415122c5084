#include "run/next/next.h"

#include <stdlib.h>

#include "base/file.h"
#include "base/memory.h"
#include "run/next/candidates.h"
#include "run/next/farthest.h"
#include "run/next/move.h"
#include "run/next/proposal_files.h"
#include "run/next/reasons.h"
#include "run/out_folder.h"
#include "run/out_lock.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static const double MATTER_SHARE = 0.5; // a ray of more transmittance sees nothing

static enum vw_status render_depths(void *context, const uint32_t *views, const struct vw_view *poses, uint32_t count,
                                    float **depths_world) {
    return vw_trainer_render_poses(context, views, poses, count, MATTER_SHARE, depths_world);
}

static enum vw_status describe(const struct vw_known_photos *known, struct vw_next *next) {
    enum vw_status status = vw_next_find_reasons(known, next);
    for (uint32_t k = 0; k < next->proposal_count && !status; k++) {
        struct vw_proposal *proposal = &next->proposals[k];
        proposal->nearest = vw_copy_text(known->scene->views[proposal->nearest_view].name);
        proposal->move = vw_next_describe_move(known, proposal->pose);
        if (!proposal->nearest || !proposal->move) status = VW_ERROR_MEMORY;
    }
    next->photo_count = known->count;
    vw_hash_to_hex(known->scene->hash, next->scene_hash);
    return status;
}

static enum vw_status propose(const struct vw_next_params *params, const struct vw_recorded_run *run,
                              struct vw_trainer *trainer, struct vw_next *next) {
    const struct vw_depth_source depths = {render_depths, trainer};
    struct vw_known_photos known;
    enum vw_status status = vw_known_photos_create(run->scene, &depths, run->config.seed, &known);
    if (!status) status = vw_known_photos_measure(&known, trainer);
    if (!status)
        status = params->among ? vw_camera_path_read(run->scene, params->among,
                                                     known.views[vw_known_photos_usual(&known)], &next->candidates)
                               : vw_next_candidates_make(&known, &next->candidates);
    if (!status) status = vw_farthest_pick(&known, params->count, next);
    if (!status) status = describe(&known, next);
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
    const struct vw_proposal_files files = {params->out, params->to, run.scene, trainer, next};
    if (!status) status = vw_proposal_files_write(&files);
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
    free(next->first_gains);
    free(next->proposals);
    *next = (struct vw_next){0};
}
