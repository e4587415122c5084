#include "run/next/next.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "run/next/next_private.h"
#include "run/out_folder.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static const double NEAR = 0.25;        // added to the square of a distance
static const double ERROR_LEAST = 1e-6; // without errors, distances decide alone
static const double CHOSEN = -1;        // in place of a distance
static const double FEW_MOST = 0.5;     // in parts of the usual number
static const double FAR_LEAST = 2;      // usual distances
static const double MATTER_SHARE = 0.5; // a ray ends at this transmittance
static const uint32_t VAL_LEAST = 3;    // photos, for a median of their errors

// ---- Which places --------------------------------------------------------------------------------------------------

static double error_at(const struct vw_known_photos *known, const struct vw_view *pose) {
    double sum = 0, weights = 0;
    for (uint32_t v = 0; v < known->val_count; v++) {
        double apart = vw_view_apart(&known->scales, &known->scene->views[known->val_views[v]], pose);
        sum += known->val_mse[v] / (apart * apart + NEAR);
        weights += 1 / (apart * apart + NEAR);
    }
    return weights > 0 ? fmax(sqrt(sum / weights), ERROR_LEAST) : 1;
}

static uint32_t find_best(const double *least, const double *errors, uint32_t count) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < count; i++)
        if (least[i] * errors[i] > least[best] * errors[best]) best = i;
    return best;
}

// Proposes the candidates of largest gains. `least`: distances from the nearest view that is known or chosen.
static void choose(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next, double *least,
                   double *errors) {
    const struct vw_view *poses = next->candidates.frames;
    for (uint32_t i = 0; i < next->candidates.count; i++) {
        vw_view_nearest(known->scene, &known->scales, known->views, known->count, &poses[i], &least[i]);
        errors[i] = error_at(known, &poses[i]);
    }
    for (; next->proposal_count < wanted; next->proposal_count++) {
        uint32_t best = find_best(least, errors, next->candidates.count);
        next->proposals[next->proposal_count] =
            (struct vw_proposal){.pose = &poses[best], .gain = least[best] * errors[best]};
        for (uint32_t i = 0; i < next->candidates.count; i++)
            least[i] = fmin(least[i], vw_view_apart(&known->scales, &poses[best], &poses[i]));
        least[best] = CHOSEN;
    }
}

enum vw_status vw_next_choose(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next) {
    uint32_t count = next->candidates.count;
    double *least = vw_allocate(count, sizeof *least), *errors = vw_allocate(count, sizeof *errors);
    next->proposals = vw_allocate(wanted, sizeof *next->proposals);
    bool made = least && errors && next->proposals;
    if (made) choose(known, wanted < count ? wanted : count, next, least, errors);
    free(least);
    free(errors);
    return made ? VW_OK : VW_ERROR_MEMORY;
}

// ---- Why -----------------------------------------------------------------------------------------------------------

static void add_reason(struct vw_proposal *proposal, const char *reason) {
    size_t used = strlen(proposal->reason);
    snprintf(proposal->reason + used, sizeof proposal->reason - used, "%s%s", used ? ", " : "", reason);
}

static bool has_high_error(const struct vw_known_photos *known, const struct vw_view *pose) {
    double apart;
    uint32_t nearest = vw_view_nearest(known->scene, &known->scales, known->val_views, known->val_count, pose, &apart);
    return known->val_count >= VAL_LEAST && apart <= FAR_LEAST && known->val_mse[nearest] > known->usual_mse;
}

// ---- The way -------------------------------------------------------------------------------------------------------

// Returns a column of a pose along the axes of a photo; its position from there.
static void express(const struct vw_view *photo, const struct vw_view *pose, enum vw_pose_column column,
                    double along[3]) {
    for (int axis = 0; axis < 3; axis++) {
        along[axis] = 0;
        for (int i = 0; i < 3; i++) {
            double start = column == VW_POSE_POSITION ? photo->camera_to_world[i][VW_POSE_POSITION] : 0;
            along[axis] += photo->camera_to_world[i][axis] * (pose->camera_to_world[i][column] - start);
        }
    }
}

// Appends an amount, if there is one after rounding to `unit`.
static void append(char text[128], const char *separator, double amount, double unit, const char *format,
                   const char *above, const char *below) {
    char number[32];
    size_t used = strlen(text);
    if (!(fabs(amount) >= 0.5 * unit)) return;
    snprintf(number, sizeof number, format, fabs(amount));
    snprintf(text + used, 128 - used, "%s%s %s", separator, number, amount > 0 ? above : below);
}

// Returns the way to a pose from the known photo of the nearest position, owned by the caller: its name without the
// folder, steps along its own axes in usual distances between neighbours, and turns.
static char *describe_move(const struct vw_known_photos *known, const struct vw_view *pose) {
    static const char *const names[3][2] = {{"right", "left"}, {"up", "down"}, {"back", "forward"}};
    const struct vw_view *photo = vw_known_photo(known, vw_known_photos_nearest(known, pose));
    double step[3], back[3], usual_world = known->scales.between_world * known->scales.typical;
    char steps[128] = "", turns[128] = "";
    express(photo, pose, VW_POSE_POSITION, step);
    express(photo, pose, VW_POSE_BACK, back);
    for (int axis = 0; axis < 3; axis++)
        append(steps, *steps ? ", " : "", step[axis] / usual_world, 0.1, "%.1f", names[axis][0], names[axis][1]);
    append(turns, "turn ", atan2(back[VW_POSE_RIGHT], back[VW_POSE_BACK]) * 180 / M_PI, 1, "%.0f deg", "left", "right");
    append(turns, *turns ? ", " : "turn ", asin(fmin(fmax(-back[VW_POSE_UP], -1), 1)) * 180 / M_PI, 1, "%.0f deg", "up",
           "down");
    const char *folder = strrchr(photo->name, '/'), *nothing = *turns ? "" : "the same place";
    return vw_format_text("%s: %s%s%s", folder ? folder + 1 : photo->name, *steps ? steps : nothing,
                          *steps && *turns ? "; " : "", turns);
}

// ---- Proposals -----------------------------------------------------------------------------------------------------

static enum vw_status describe(const struct vw_known_photos *known, struct vw_proposal *proposal) {
    const struct vw_view *pose = proposal->pose;
    struct vw_seen_points points;
    struct vw_depth_map *map = NULL;
    uint32_t nearest =
        vw_view_nearest(known->scene, &known->scales, known->views, known->count, pose, &proposal->apart);
    proposal->nearest_view = known->views[nearest];
    proposal->nearest = vw_copy_text(vw_known_photo(known, nearest)->name);
    proposal->move = describe_move(known, pose);
    if (!proposal->nearest || !proposal->move) return VW_ERROR_MEMORY;
    enum vw_status status = vw_depth_maps_make(known, &proposal->nearest_view, pose, 1, &map);
    if (!status) vw_seen_points_find(map, known, known->count, &points);
    if (!status) proposal->seen_by = vw_seen_points_median(&points);
    bool seen = !status && map->seen_count;
    free(map);
    if (seen && proposal->seen_by <= FEW_MOST * known->usual_seen_by) add_reason(proposal, "seen by few");
    if (has_high_error(known, pose)) add_reason(proposal, "high error");
    if (proposal->apart > FAR_LEAST) add_reason(proposal, "extrapolates");
    if (!seen) add_reason(proposal, "sees nothing");
    if (!*proposal->reason && proposal->apart < 1) add_reason(proposal, "between photos");
    return status;
}

enum vw_status vw_next_describe(const struct vw_known_photos *known, struct vw_next *next) {
    enum vw_status status = VW_OK;
    for (uint32_t k = 0; k < next->proposal_count && !status; k++) status = describe(known, &next->proposals[k]);
    next->photo_count = known->count;
    vw_hash_to_hex(known->scene->hash, next->scene_hash);
    return status;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

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
