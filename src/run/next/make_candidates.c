#include "run/next/make_candidates.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "run/next/candidate_poses.h"
#include "scene/camera_path.h"

enum { DRAWS_PER_PHOTO = 20, DRAWS_LEAST = 200, DRAWS_MOST = 2000, ENOUGH = 400, BLOCK = 100 };
enum { SEEING_MOST = 255, SEEING_LEAST = 2, LINE_SIDE_PX = 3, LINE_PIXELS = LINE_SIDE_PX * LINE_SIDE_PX };
static const double NEW_LEAST = 0.25;  // in usual distances
static const double CLEAR_LEAST = 0.5; // in distances from the nearest known camera to what is nearest to it
static const double FREE_LEAST = 1.25; // depths of surfaces are blurred
static const double SEEN_LEAST = 0.5;  // both shares: what two photos see, and what the median photo sees
static const double TILT = 0.01;       // a line may go straight up
static const double LINE_HALF_ANGLE = 3 * M_PI / 180;

enum axis { RIGHT, UP, BACK, POSITION }; // columns of camera_to_world

struct making {
    const struct vw_candidate_params *params;
    struct vw_pose_bases known;
    struct vw_camera camera;
    double seen_least;         // pixels of a map
    uint32_t *order;           // owned; of bases
    struct vw_candidate *kept; // owned
    uint32_t kept_count;
};

// A block of poses that pass the filters so far.
struct block {
    struct vw_view poses[BLOCK], lines[BLOCK]; // a line: from the nearest known camera to the pose
    uint32_t nearest[BLOCK], views[BLOCK];     // places and scene indices of the nearest known photos
    uint32_t count;
};

// ---- Sources of poses ----------------------------------------------------------------------------------------------

// Lists the points that a known photo sees and the fewest photos see.
static void find_targets(const struct vw_candidate_params *params, const struct vw_depth_map *map,
                         struct vw_pose_base *base) {
    double seeing[VW_SPARSE_PIXELS];
    struct vw_sight points[VW_SPARSE_PIXELS];
    struct vw_ordered ordered[VW_SPARSE_PIXELS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < VW_SPARSE_PIXELS; i++)
        if (vw_depth_map_point(map, vw_sparse_pixel(i), &points[count]))
            seeing[count] = vw_depth_maps_count_seeing(params->maps, params->count, &points[count], SEEING_MOST),
            count++;
    vw_order(seeing, count, ordered);
    base->target_count = count < VW_POSE_TARGETS ? count : VW_POSE_TARGETS;
    for (uint32_t k = 0; k < base->target_count; k++)
        memcpy(base->targets_world[k], points[ordered[k].place].point_world, sizeof base->targets_world[k]);
}

static void fill_base(const struct vw_candidate_params *params, uint32_t place, struct vw_pose_base *base) {
    const struct vw_view *view = &params->scene->views[params->views[place]];
    double depth = params->maps[place].median_world;
    base->view = params->views[place];
    if (!(depth > 0)) depth = params->scene->box.half_extent_world; // it sees nothing
    for (int i = 0; i < 3; i++)
        base->focus_world[i] = view->camera_to_world[i][POSITION] - depth * view->camera_to_world[i][BACK];
    find_targets(params, &params->maps[place], base);
}

static enum vw_status find_seen_least(struct making *making) {
    double *counts = vw_allocate(making->params->count, sizeof *counts);
    if (!counts) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < making->params->count; i++) counts[i] = making->params->maps[i].seen_count;
    making->seen_least = fmax(SEEN_LEAST * vw_median(counts, making->params->count), 1);
    free(counts);
    return VW_OK;
}

static enum vw_status prepare(struct making *making) {
    const struct vw_candidate_params *params = making->params;
    struct vw_pose_base *bases = vw_allocate(params->count, sizeof *bases);
    making->known = (struct vw_pose_bases){params->scene, params->scales, bases, params->count, params->seed};
    making->order = vw_allocate(params->count, sizeof *making->order);
    making->kept = vw_allocate(ENOUGH, sizeof *making->kept);
    enum vw_status status = bases && making->order && making->kept ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = find_seen_least(making);
    if (status) return status;
    for (uint32_t i = 0; i < params->count; i++) fill_base(params, i, &bases[i]);
    uint32_t usual = vw_usual_view(params->scene, params->views, params->count);
    making->camera = vw_camera_pinhole(&params->scene->views[usual].camera);
    vw_random_order(params->seed, 0, params->count, making->order);
    return VW_OK;
}

// ---- Filters -------------------------------------------------------------------------------------------------------

static double between(const struct vw_view *a, const struct vw_view *b) {
    double step[3];
    for (int i = 0; i < 3; i++) step[i] = a->camera_to_world[i][POSITION] - b->camera_to_world[i][POSITION];
    return sqrt(vw_dot(step, step, 3));
}

static const struct vw_view *known_view(const struct making *making, uint32_t base) {
    return &making->params->scene->views[making->params->views[base]];
}

static uint32_t find_nearest(const struct making *making, const struct vw_view *pose) {
    uint32_t nearest = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < making->params->count; i++) {
        double distance = between(pose, known_view(making, i));
        if (distance < least) least = distance, nearest = i;
    }
    return nearest;
}

static bool is_new(const struct making *making, const struct vw_view *pose) {
    for (uint32_t v = 0; v < making->params->scene->view_count; v++)
        if (vw_view_apart(making->params->scales, pose, &making->params->scene->views[v]) < NEW_LEAST) return false;
    return true;
}

// Makes a camera of a few pixels at `from` that looks at another place.
static bool aim(const struct vw_view *from, const struct vw_view *to, struct vw_view *line) {
    double position[3], target[3], up[3];
    for (int i = 0; i < 3; i++) {
        position[i] = from->camera_to_world[i][POSITION];
        target[i] = to->camera_to_world[i][POSITION];
        up[i] = from->camera_to_world[i][UP] + TILT * from->camera_to_world[i][RIGHT]; // so that it may aim upwards
    }
    double focal_px = LINE_SIDE_PX / (2 * tan(LINE_HALF_ANGLE));
    *line = (struct vw_view){.camera = {.width_px = LINE_SIDE_PX,
                                        .height_px = LINE_SIDE_PX,
                                        .focal_x_px = focal_px,
                                        .focal_y_px = focal_px,
                                        .centre_x_px = 0.5 * LINE_SIDE_PX,
                                        .centre_y_px = 0.5 * LINE_SIDE_PX},
                             .near_world = from->near_world,
                             .far_world = from->far_world};
    return vw_camera_look_at(position, target, up, line->camera_to_world);
}

static bool draw_pose(const struct making *making, uint32_t place, struct vw_view *pose) {
    *pose = (struct vw_view){.camera = making->camera};
    uint32_t count = making->known.count;
    if (!vw_pose_draw(&making->known, making->order[place % count], place / count, pose->camera_to_world)) return false;
    vw_camera_path_set_depths(making->params->scene, pose);
    return is_new(making, pose);
}

static void draw_block(const struct making *making, uint32_t first, uint32_t end, struct block *block) {
    block->count = 0;
    for (uint32_t place = first; place < end; place++) {
        struct vw_view *pose = &block->poses[block->count];
        if (!draw_pose(making, place, pose)) continue;
        uint32_t nearest = find_nearest(making, pose);
        block->nearest[block->count] = nearest;
        block->views[block->count] = making->params->views[nearest];
        block->count += aim(known_view(making, nearest), pose, &block->lines[block->count]);
    }
}

static void keep_only(struct block *block, const bool *keeps) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < block->count; i++) {
        if (!keeps[i]) continue;
        block->poses[count] = block->poses[i];
        block->nearest[count] = block->nearest[i];
        block->views[count++] = block->views[i];
    }
    block->count = count;
}

// Drops poses that something hides from the nearest known camera.
static enum vw_status keep_reachable(const struct making *making, struct block *block) {
    const struct vw_depth_source *depths = &making->params->depths;
    bool keeps[BLOCK];
    float *lines_world = NULL;
    if (!block->count) return VW_OK;
    enum vw_status status = depths->render(depths->context, block->views, block->lines, block->count, &lines_world);
    for (uint32_t i = 0; i < block->count && !status; i++) {
        double length = between(known_view(making, block->nearest[i]), &block->poses[i]);
        keeps[i] = true;
        for (uint32_t k = 0; k < LINE_PIXELS; k++) {
            double depth = (double)lines_world[i * LINE_PIXELS + k];
            keeps[i] &= depth == 0 || depth > FREE_LEAST * length;
        }
    }
    free(lines_world);
    if (!status) keep_only(block, keeps);
    return status;
}

// Returns whether a pose is clear of what is there, and sees enough of what known photos see.
static bool sees_the_seen(const struct making *making, uint32_t nearest, const struct vw_depth_map *map) {
    const struct vw_candidate_params *params = making->params;
    struct vw_sight sight;
    uint32_t points = 0, seen = 0;
    if (map->seen_count < making->seen_least) return false;
    if (map->nearest_world < CLEAR_LEAST * params->maps[nearest].nearest_world) return false;
    for (uint32_t i = 0; i < VW_SPARSE_PIXELS; i++) {
        if (!vw_depth_map_point(map, vw_sparse_pixel(i), &sight)) continue;
        points++;
        seen += vw_depth_maps_count_seeing(params->maps, params->count, &sight, SEEING_LEAST) == SEEING_LEAST;
    }
    return points && seen >= SEEN_LEAST * points;
}

static enum vw_status keep_seeing(struct making *making, const struct block *block) {
    struct vw_depth_map *maps = NULL;
    if (!block->count) return VW_OK;
    enum vw_status status =
        vw_depth_maps_make(&making->params->depths, block->views, block->poses, block->count, &maps);
    for (uint32_t i = 0; i < block->count && !status && making->kept_count < ENOUGH; i++)
        if (sees_the_seen(making, block->nearest[i], &maps[i]))
            making->kept[making->kept_count++] = (struct vw_candidate){.pose = block->poses[i]};
    free(maps);
    return status;
}

// ---- All of them ---------------------------------------------------------------------------------------------------

static uint32_t count_draws(uint32_t known) {
    uint64_t draws = (uint64_t)DRAWS_PER_PHOTO * known;
    return draws < DRAWS_LEAST ? DRAWS_LEAST : draws < DRAWS_MOST ? (uint32_t)draws : DRAWS_MOST;
}

static enum vw_status make_blocks(struct making *making) {
    uint32_t draws = count_draws(making->known.count);
    struct block *block = vw_allocate(1, sizeof *block);
    enum vw_status status = block ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t first = 0; first < draws && making->kept_count < ENOUGH && !status; first += BLOCK) {
        draw_block(making, first, first + BLOCK < draws ? first + BLOCK : draws, block);
        status = keep_reachable(making, block);
        if (!status) status = keep_seeing(making, block);
    }
    free(block);
    if (status || making->kept_count) return status;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: no place around the cameras is free, new and sees what two photos see; name places by --among",
                   making->params->scene->path);
}

enum vw_status vw_next_candidates_make(const struct vw_candidate_params *params, struct vw_candidate **candidates,
                                       uint32_t *count) {
    struct making making = {.params = params};
    enum vw_status status = prepare(&making);
    if (!status) status = make_blocks(&making);
    free((void *)making.known.bases);
    free(making.order);
    if (!status) {
        *candidates = making.kept;
        *count = making.kept_count;
    } else free(making.kept);
    return status;
}
