#include "run/next/candidates.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "run/next/candidate_poses.h"

enum { DRAWS_PER_PHOTO = 20, DRAWS_LEAST = 200, DRAWS_MOST = 2000, ENOUGH = 400, BLOCK = 100 };
enum { SEEING_LEAST = 2, LINE_SIDE_PX = 3, LINE_PIXELS = LINE_SIDE_PX * LINE_SIDE_PX };
static const double NEW_LEAST = 0.25;  // in usual distances
static const double CLEAR_LEAST = 0.5; // in distances from the nearest known camera to what is nearest to it
static const double FREE_LEAST = 1.25; // depths of surfaces are blurred
static const double SEEN_LEAST = 0.5;  // both shares: what two photos see, and what the median photo sees
static const double TILT = 0.01;       // so that a line may go straight up
static const double LINE_HALF_ANGLE = 3 * M_PI / 180;

struct making {
    const struct vw_known_photos *known;
    struct vw_pose_base *bases; // owned; by known photo
    uint32_t *order;            // owned; of known photos
    struct vw_camera camera;
    double seen_least; // pixels of a map
    struct vw_camera_path *kept;
};

// A block of poses that pass the filters so far.
struct block {
    struct vw_view poses[BLOCK], lines[BLOCK]; // a line: from the nearest known camera to the pose
    uint32_t nearest[BLOCK], views[BLOCK];     // places and scene indices of the nearest known photos
    uint32_t count;
};

static enum vw_status find_seen_least(struct making *making) {
    const struct vw_known_photos *known = making->known;
    double *counts = vw_allocate(known->count, sizeof *counts);
    if (!counts) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < known->count; i++) counts[i] = known->maps[i].seen_count;
    making->seen_least = fmax(SEEN_LEAST * vw_median(counts, known->count), 1);
    free(counts);
    return VW_OK;
}

static enum vw_status prepare(struct making *making) {
    const struct vw_known_photos *known = making->known;
    making->bases = vw_allocate(known->count, sizeof *making->bases);
    making->order = vw_allocate(known->count, sizeof *making->order);
    making->kept->frames = vw_allocate(ENOUGH, sizeof *making->kept->frames);
    enum vw_status status = making->bases && making->order && making->kept->frames ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = find_seen_least(making);
    if (status) return status;
    for (uint32_t i = 0; i < known->count; i++) vw_pose_base_find(known, i, &making->bases[i]);
    making->camera = vw_camera_pinhole(&vw_known_photo(known, vw_known_photos_usual(known))->camera);
    vw_random_order(known->seed, 0, known->count, making->order);
    return VW_OK;
}

// ---- Filters -------------------------------------------------------------------------------------------------------

static bool is_new(const struct making *making, const struct vw_view *pose) {
    for (uint32_t v = 0; v < making->known->scene->view_count; v++)
        if (vw_view_apart(&making->known->scales, pose, &making->known->scene->views[v]) < NEW_LEAST) return false;
    return true;
}

// Makes a camera of a few pixels at `from` that looks at another place.
static bool aim(const struct vw_view *from, const struct vw_view *to, struct vw_view *line) {
    double position[3], target[3], up[3];
    for (int i = 0; i < 3; i++) {
        position[i] = from->camera_to_world[i][VW_POSE_POSITION];
        target[i] = to->camera_to_world[i][VW_POSE_POSITION];
        up[i] = from->camera_to_world[i][VW_POSE_UP] + TILT * from->camera_to_world[i][VW_POSE_RIGHT];
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
    uint32_t count = making->known->count;
    if (!vw_pose_draw(making->known, making->bases, making->order[place % count], place / count, pose->camera_to_world))
        return false;
    vw_camera_path_set_depths(making->known->scene, pose);
    return is_new(making, pose);
}

static void draw_block(const struct making *making, uint32_t first, uint32_t end, struct block *block) {
    block->count = 0;
    for (uint32_t place = first; place < end; place++) {
        struct vw_view *pose = &block->poses[block->count];
        if (!draw_pose(making, place, pose)) continue;
        uint32_t nearest = vw_known_photos_nearest(making->known, pose);
        block->nearest[block->count] = nearest;
        block->views[block->count] = making->known->views[nearest];
        block->count += aim(vw_known_photo(making->known, nearest), pose, &block->lines[block->count]);
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
    const struct vw_depth_source *depths = &making->known->depths;
    bool keeps[BLOCK];
    float *lines_world = NULL;
    if (!block->count) return VW_OK;
    enum vw_status status = depths->render(depths->context, block->views, block->lines, block->count, &lines_world);
    for (uint32_t i = 0; i < block->count && !status; i++) {
        double length = vw_view_between_world(vw_known_photo(making->known, block->nearest[i]), &block->poses[i]);
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
    const struct vw_known_photos *known = making->known;
    struct vw_seen_points points;
    uint32_t seen = 0;
    if (map->seen_count < making->seen_least) return false;
    if (map->nearest_world < CLEAR_LEAST * known->maps[nearest].nearest_world) return false;
    vw_seen_points_find(map, known->maps, known->count, SEEING_LEAST, &points);
    for (uint32_t i = 0; i < points.count; i++) seen += points.seen_by[i] == SEEING_LEAST;
    return points.count && seen >= SEEN_LEAST * points.count;
}

static enum vw_status keep_seeing(struct making *making, const struct block *block) {
    struct vw_camera_path *kept = making->kept;
    struct vw_depth_map *maps = NULL;
    if (!block->count) return VW_OK;
    enum vw_status status = vw_depth_maps_make(&making->known->depths, block->views, block->poses, block->count, &maps);
    for (uint32_t i = 0; i < block->count && !status && kept->count < ENOUGH; i++)
        if (sees_the_seen(making, block->nearest[i], &maps[i])) kept->frames[kept->count++] = block->poses[i];
    free(maps);
    return status;
}

// ---- All of them ---------------------------------------------------------------------------------------------------

static uint32_t count_draws(uint32_t known) {
    uint64_t draws = (uint64_t)DRAWS_PER_PHOTO * known;
    return draws < DRAWS_LEAST ? DRAWS_LEAST : draws < DRAWS_MOST ? (uint32_t)draws : DRAWS_MOST;
}

static enum vw_status make_blocks(struct making *making) {
    uint32_t draws = count_draws(making->known->count);
    struct block *block = vw_allocate(1, sizeof *block);
    enum vw_status status = block ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t first = 0; first < draws && making->kept->count < ENOUGH && !status; first += BLOCK) {
        draw_block(making, first, first + BLOCK < draws ? first + BLOCK : draws, block);
        status = keep_reachable(making, block);
        if (!status) status = keep_seeing(making, block);
    }
    free(block);
    if (status || making->kept->count) return status;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: no place around the cameras is free, new and sees what two photos see; name places by --among",
                   making->known->scene->path);
}

enum vw_status vw_next_candidates_make(const struct vw_known_photos *known, struct vw_camera_path *candidates) {
    struct making making = {.known = known, .kept = candidates};
    *candidates = (struct vw_camera_path){0};
    enum vw_status status = prepare(&making);
    if (!status) status = make_blocks(&making);
    free(making.bases);
    free(making.order);
    return status;
}
