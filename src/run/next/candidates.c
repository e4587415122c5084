#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "run/next/next_private.h"

enum { NEIGHBOURS = 6, MIXED = 3, TARGETS = 8 };
enum { DRAWS_PER_PHOTO = 20, DRAWS_LEAST = 200, DRAWS_MOST = 2000, ENOUGH = 400, BLOCK = 100 };
enum { SEEING_LEAST = 2, LINE_SIDE_PX = 3, LINE_PIXELS = LINE_SIDE_PX * LINE_SIDE_PX };
static const double LEAST_STEP = 0.5, MOST_STEP = 2; // in usual distances between neighbours' positions
static const double NEW_LEAST = 0.25;                // in usual distances
static const double CLEAR_LEAST = 0.5; // in distances from the nearest known camera to what is nearest to it
static const double FREE_LEAST = 1.25; // depths of surfaces are blurred
static const double SEEN_LEAST = 0.5;  // both shares: what two photos see, and what the median photo sees
static const double TILT = 0.01;       // so that a line may go straight up
static const double LINE_HALF_ANGLE = 3 * M_PI / 180;

// ---- Poses ---------------------------------------------------------------------------------------------------------

// The mean of some cameras, moved.
struct mean_camera {
    uint32_t photos[MIXED], count; // places of known photos
    double weights[MIXED], offset_world[3];
};

static struct mean_camera draw_between(const struct vw_known_photos *known, uint32_t photo, const uint32_t words[8]) {
    struct mean_camera mean = {.photos = {photo}, .count = 1};
    uint32_t others = known->count - 1 < NEIGHBOURS ? known->count - 1 : NEIGHBOURS;
    double sum = 0;
    for (uint32_t i = 0; i < known->count; i++)
        known->values[i] = vw_view_apart(&known->scales, vw_known_photo(known, photo), vw_known_photo(known, i));
    known->values[photo] = INFINITY;
    vw_order(known->values, known->count, known->ordered);
    for (uint32_t k = 0; k < 2 && others > 0; k++) {
        uint32_t place = vw_random_below(words[k], others);
        mean.photos[mean.count++] = known->ordered[place].place;
        known->ordered[place] = known->ordered[--others];
    }
    for (uint32_t k = 0; k < mean.count; k++)
        sum += mean.weights[k] = -log1p(-(double)vw_random_unit(words[2 + k])) + 1e-9; // uniform over all mixtures
    for (uint32_t k = 0; k < mean.count; k++) mean.weights[k] /= sum;
    return mean;
}

static struct mean_camera draw_beside(const struct vw_known_photos *known, uint32_t photo, const uint32_t words[8]) {
    struct mean_camera mean = {.photos = {photo}, .count = 1, .weights = {1}};
    double height = 2 * (double)vw_random_unit(words[0]) - 1, turn = 2 * M_PI * (double)vw_random_unit(words[1]);
    double share = (double)vw_random_unit(words[2]),
           step = known->scales.between_world * ((1 - share) * LEAST_STEP + share * MOST_STEP);
    mean.offset_world[0] = step * sqrt(1 - height * height) * cos(turn);
    mean.offset_world[1] = step * sqrt(1 - height * height) * sin(turn);
    mean.offset_world[2] = step * height;
    return mean;
}

// Adds the places that the cameras look at, in the same mean: on their axes, at their median depths.
static void mix(const struct vw_known_photos *known, const struct mean_camera *mean, double position[3], double up[3],
                double focus[3]) {
    for (int i = 0; i < 3; i++) {
        position[i] = mean->offset_world[i];
        up[i] = focus[i] = 0;
        for (uint32_t k = 0; k < mean->count; k++) {
            const double *row = vw_known_photo(known, mean->photos[k])->camera_to_world[i], weight = mean->weights[k];
            double depth = known->maps[mean->photos[k]].median_world;
            if (!(depth > 0)) depth = known->scene->box.half_extent_world; // it sees nothing
            position[i] += weight * row[VW_POSE_POSITION];
            up[i] += weight * row[VW_POSE_UP];
            focus[i] += weight * (row[VW_POSE_POSITION] - depth * row[VW_POSE_BACK]);
        }
    }
}

static const double *draw_target(const struct vw_seen_points *points, uint32_t word) {
    struct vw_ordered ordered[VW_SEEN_POINTS_MOST];
    vw_order(points->seen_by, points->count, ordered);
    return points
        ->points_world[ordered[vw_random_below(word, points->count < TARGETS ? points->count : TARGETS)].place];
}

bool vw_next_draw_pose(const struct vw_known_photos *known, uint32_t photo, uint32_t draw,
                       double camera_to_world[3][4]) {
    uint32_t words[8], kind = (photo + draw) % 4;
    double position[3], up[3], focus[3];
    for (uint32_t k = 0; k < 2; k++)
        vw_random_words(known->seed, VW_RANDOM_POSE, 0, known->views[photo], 2 * draw + k, words + 4 * (size_t)k);
    struct mean_camera mean = kind % 2 ? draw_beside(known, photo, words) : draw_between(known, photo, words);
    mix(known, &mean, position, up, focus);
    bool at_target = kind == 3 && known->points[photo].count;
    return vw_camera_look_at(position, at_target ? draw_target(&known->points[photo], words[5]) : focus, up,
                             camera_to_world);
}

// ---- Filters -------------------------------------------------------------------------------------------------------

static bool is_new(const struct vw_known_photos *known, const struct vw_view *pose) {
    for (uint32_t v = 0; v < known->scene->view_count; v++)
        if (vw_view_apart(&known->scales, pose, &known->scene->views[v]) < NEW_LEAST) return false;
    return true;
}

// Makes a camera of a few pixels at `from` that looks at another place.
static bool aim(const struct vw_view *from, const struct vw_view *to, struct vw_view *line) {
    double position[3], target[3], up[3], focal_px = LINE_SIDE_PX / (2 * tan(LINE_HALF_ANGLE));
    for (int i = 0; i < 3; i++) {
        position[i] = from->camera_to_world[i][VW_POSE_POSITION];
        target[i] = to->camera_to_world[i][VW_POSE_POSITION];
        up[i] = from->camera_to_world[i][VW_POSE_UP] + TILT * from->camera_to_world[i][VW_POSE_RIGHT];
    }
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

// Returns whether nothing hides a pose from the nearest known camera, by the depths of the line between them.
static bool is_reachable(const struct vw_view *nearest, const struct vw_view *pose, const float *line_world) {
    double length_world = vw_view_between_world(nearest, pose);
    for (uint32_t k = 0; k < LINE_PIXELS; k++)
        if (line_world[k] > 0 && (double)line_world[k] <= FREE_LEAST * length_world) return false;
    return true;
}

// Returns whether a pose is clear of what is there, and sees enough of what known photos see.
static bool sees_the_seen(const struct vw_known_photos *known, uint32_t nearest, const struct vw_depth_map *map) {
    struct vw_seen_points points;
    uint32_t seen = 0;
    if (map->seen_count < fmax(SEEN_LEAST * known->usual_count, 1)) return false;
    if (map->nearest_world < CLEAR_LEAST * known->maps[nearest].nearest_world) return false;
    vw_seen_points_find(map, known, SEEING_LEAST, &points);
    for (uint32_t i = 0; i < points.count; i++) seen += points.seen_by[i] == SEEING_LEAST;
    return points.count && seen >= SEEN_LEAST * points.count;
}

// ---- Candidates ----------------------------------------------------------------------------------------------------

// Poses whose maps are rendered together, since many small ones cost less so.
struct block {
    struct vw_view poses[BLOCK], lines[BLOCK]; // a line: from the nearest known camera to the pose
    uint32_t nearest[BLOCK], views[BLOCK];     // places and scene indices of the nearest known photos
    uint32_t count;
};

static void draw_block(const struct vw_known_photos *known, const uint32_t *order, uint32_t first, uint32_t end,
                       struct block *block) {
    block->count = 0;
    for (uint32_t place = first; place < end; place++) {
        struct vw_view *pose = &block->poses[block->count];
        *pose = (struct vw_view){.camera = vw_camera_pinhole(&vw_known_photo(known, known->usual)->camera)};
        if (!vw_next_draw_pose(known, order[place % known->count], place / known->count, pose->camera_to_world))
            continue;
        vw_camera_path_set_depths(known->scene, pose);
        if (!is_new(known, pose)) continue;
        uint32_t nearest = vw_known_photos_nearest(known, pose);
        block->nearest[block->count] = nearest;
        block->views[block->count] = known->views[nearest];
        block->count += aim(vw_known_photo(known, nearest), pose, &block->lines[block->count]);
    }
}

static enum vw_status keep(const struct vw_known_photos *known, const struct block *block,
                           struct vw_camera_path *kept) {
    float *lines_world = NULL;
    struct vw_depth_map *maps = NULL;
    if (!block->count) return VW_OK;
    enum vw_status status = known->render(known->context, block->views, block->lines, block->count, &lines_world);
    if (!status) status = vw_depth_maps_make(known, block->views, block->poses, block->count, &maps);
    for (uint32_t i = 0; i < block->count && !status && kept->count < ENOUGH; i++) {
        uint32_t nearest = block->nearest[i];
        if (is_reachable(vw_known_photo(known, nearest), &block->poses[i], lines_world + i * LINE_PIXELS) &&
            sees_the_seen(known, nearest, &maps[i]))
            kept->frames[kept->count++] = block->poses[i];
    }
    free(lines_world);
    free(maps);
    return status;
}

enum vw_status vw_next_candidates_make(const struct vw_known_photos *known, struct vw_camera_path *candidates) {
    uint64_t wanted = (uint64_t)DRAWS_PER_PHOTO * known->count;
    uint32_t draws = wanted < DRAWS_LEAST ? DRAWS_LEAST : wanted < DRAWS_MOST ? (uint32_t)wanted : DRAWS_MOST;
    uint32_t *order = vw_allocate(known->count, sizeof *order);
    struct block *block = vw_allocate(1, sizeof *block);
    *candidates = (struct vw_camera_path){.frames = vw_allocate(ENOUGH, sizeof *candidates->frames)};
    enum vw_status status = order && block && candidates->frames ? VW_OK : VW_ERROR_MEMORY;
    if (!status) vw_random_order(known->seed, 0, known->count, order);
    for (uint32_t first = 0; first < draws && candidates->count < ENOUGH && !status; first += BLOCK) {
        draw_block(known, order, first, first + BLOCK < draws ? first + BLOCK : draws, block);
        status = keep(known, block, candidates);
    }
    free(order);
    free(block);
    if (status || candidates->count) return status;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: no place around the cameras is free, new and sees what two photos see; name places by --among",
                   known->scene->path);
}
