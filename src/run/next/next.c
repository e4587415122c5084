#include "run/next/next.h"

#include <stdlib.h>

#include "base/memory.h"
#include "run/next/candidate_poses.h"
#include "run/next/candidate_scores.h"
#include "run/next/make_candidates.h"
#include "run/next/move.h"
#include "run/next/proposal_files.h"
#include "run/next/reasons.h"
#include "run/out_folder.h"
#include "run/recorded/rendering.h"
#include "train/trainer.h"
#include "viewworth/log.h"

enum { VAL_PIXELS_MAX = 4096 };         // pixels that the error of a validation photo is measured on
static const double MATTER_SHARE = 0.5; // a ray of more transmittance sees nothing

struct known {
    struct vw_known_views views;
    uint32_t *train, *val; // owned, as all below
    double *mse;
    struct vw_view_error *errors;
    struct vw_depth_map *maps; // by photo trained on
    struct vw_depth_source depths;
};

static enum vw_status measure_errors(struct vw_trainer *trainer, struct known *known) {
    uint32_t count = known->views.val_count;
    known->errors = vw_allocate(count, sizeof *known->errors);
    known->mse = vw_allocate(count, sizeof *known->mse);
    if (!known->errors || !known->mse) return VW_ERROR_MEMORY;
    enum vw_status status =
        count ? vw_trainer_measure_views(trainer, known->val, count, VAL_PIXELS_MAX, known->errors) : VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) known->mse[i] = known->errors[i].mse;
    return status;
}

static enum vw_status render_depths(void *context, const uint32_t *views, const struct vw_view *poses, uint32_t count,
                                    float **depths_world) {
    return vw_trainer_render_poses(context, views, poses, count, MATTER_SHARE, depths_world);
}

static enum vw_status map_known(const struct vw_known_views *known, const struct vw_depth_source *depths,
                                struct vw_depth_map **maps) {
    struct vw_view *poses = vw_allocate(known->count, sizeof *poses);
    if (!poses) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < known->count; i++) poses[i] = known->scene->views[known->views[i]];
    enum vw_status status = vw_depth_maps_make(depths, known->views, poses, known->count, maps);
    free(poses);
    return status;
}

static enum vw_status measure_known(const struct vw_scene *scene, struct vw_trainer *trainer, struct known *known) {
    uint32_t train_count = 0, val_count = 0;
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &known->train, &train_count);
    if (!status) status = vw_scene_list_views(scene, VW_SPLIT_VAL, &known->val, &val_count);
    known->views = (struct vw_known_views){.scene = scene,
                                           .trainer = trainer,
                                           .views = known->train,
                                           .count = train_count,
                                           .val_views = known->val,
                                           .val_count = val_count};
    known->depths = (struct vw_depth_source){render_depths, trainer};
    if (!status) status = vw_view_scales_find(scene, &known->views.scales);
    if (!status) status = measure_errors(trainer, known);
    if (!status) status = map_known(&known->views, &known->depths, &known->maps);
    known->views.val_mse = known->mse;
    return status;
}

static enum vw_status pick(const struct vw_next_params *params, const struct vw_candidate_score *score,
                           const struct vw_known_views *known, struct vw_next *next) {
    uint32_t count = next->candidate_count, wanted = params->count < count ? params->count : count;
    uint32_t *picks = vw_allocate(wanted, sizeof *picks);
    double *gains = vw_allocate(wanted, sizeof *gains);
    next->first_gains = vw_allocate(count, sizeof *next->first_gains);
    next->proposals = vw_allocate(wanted, sizeof *next->proposals);
    enum vw_status status =
        picks && gains && next->first_gains && next->proposals
            ? vw_next_candidates_pick(score, known, next->candidates, count, wanted, picks, gains, next->first_gains)
            : VW_ERROR_MEMORY;
    for (uint32_t k = 0; k < wanted && !status; k++)
        next->proposals[k] = (struct vw_proposal){.candidate = picks[k], .gain = gains[k]};
    next->proposal_count = status ? 0 : wanted;
    if (!status && wanted < params->count)
        vw_log_warning("%u places were found for --count %u; all are proposed", wanted, params->count);
    free(picks);
    free(gains);
    return status;
}

// Reads the candidates of a file, or makes them.
static enum vw_status find_candidates(const struct vw_next_params *params, const struct vw_recorded_run *run,
                                      struct known *known, struct vw_next *next) {
    if (params->among)
        return vw_next_candidates_read(run->scene, params->among,
                                       vw_usual_view(run->scene, known->train, known->views.count), &next->candidates,
                                       &next->candidate_count);
    struct vw_candidate_params made = {.scene = run->scene,
                                       .scales = &known->views.scales,
                                       .views = known->train,
                                       .count = known->views.count,
                                       .maps = known->maps,
                                       .depths = known->depths,
                                       .seed = run->config.seed};
    return vw_next_candidates_make(&made, &next->candidates, &next->candidate_count);
}

static enum vw_status describe(const struct vw_recorded_run *run, const struct known *known, struct vw_next *next) {
    enum vw_status status = vw_next_find_reasons(&known->views, known->maps, &known->depths, next);
    for (uint32_t k = 0; k < next->proposal_count && !status; k++) {
        struct vw_proposal *proposal = &next->proposals[k];
        proposal->nearest = vw_copy_text(run->scene->views[proposal->nearest_view].name);
        proposal->move = vw_next_describe_move(&known->views, &next->candidates[proposal->candidate].pose);
        if (!proposal->nearest || !proposal->move) status = VW_ERROR_MEMORY;
    }
    next->photo_count = known->views.count;
    vw_hash_to_hex(run->scene->hash, next->scene_hash);
    return status;
}

static void free_known(struct known *known) {
    free(known->train);
    free(known->val);
    free(known->mse);
    free(known->errors);
    free(known->maps);
}

static enum vw_status make_locked(const struct vw_next_params *params, const struct vw_candidate_score *score,
                                  struct vw_next *next) {
    struct vw_recorded_run run = {0};
    struct vw_trainer *trainer = NULL;
    struct known known = {0};
    enum vw_status status = vw_recorded_open(params->out, &run);
    if (!status) status = vw_recorded_open_scene(&run, params->device);
    if (!status) status = vw_recorded_load_field(&run, true, &trainer);
    if (!status) status = measure_known(run.scene, trainer, &known);
    if (!status) status = find_candidates(params, &run, &known, next);
    if (!status) status = pick(params, score, &known.views, next);
    if (!status) status = describe(&run, &known, next);
    const struct vw_proposal_files files = {params->out, params->to, run.scene, trainer, next};
    if (!status) status = vw_proposal_files_write(&files);
    free_known(&known);
    vw_trainer_destroy(&trainer);
    vw_recorded_close(&run);
    return status;
}

enum vw_status vw_next_make(const struct vw_next_params *params, struct vw_next *next) {
    const struct vw_candidate_score *score = NULL;
    struct vw_out_lock *lock = NULL;
    *next = (struct vw_next){0};
    enum vw_status status = vw_candidate_score_find(params->method, &score);
    if (!status) status = vw_out_check_target("to", params->to, params->out, true);
    if (!status) status = vw_rendering_lock(params->out, NULL, &lock);
    if (!status) next->method = score->name, next->summary = score->summary;
    if (!status) status = make_locked(params, score, next);
    vw_out_lock_release(&lock);
    return status;
}

void vw_next_free(struct vw_next *next) {
    for (uint32_t k = 0; k < next->proposal_count; k++) {
        free(next->proposals[k].nearest);
        free(next->proposals[k].move);
    }
    vw_next_candidates_free(&next->candidates, next->candidate_count);
    free(next->first_gains);
    free(next->proposals);
    *next = (struct vw_next){0};
}
