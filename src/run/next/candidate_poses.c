#include "run/next/candidate_poses.h"

#include <math.h>
#include <string.h>

#include "base/random.h"
#include "base/statistics.h"
#include "scene/camera_path.h"

enum { NEIGHBOURS = 6, MIXED = 3 };
static const double LEAST_STEP = 0.5, MOST_STEP = 2; // in usual distances between neighbours' positions

// The mean of some cameras, moved.
struct mean_camera {
    uint32_t photos[MIXED], count; // places of known photos
    double weights[MIXED], offset_world[3];
};

// ---- What there is to look at --------------------------------------------------------------------------------------

static void list_targets(const struct vw_seen_points *points, struct vw_pose_base *base) {
    struct vw_ordered ordered[VW_SEEN_POINTS_MOST];
    vw_order(points->seen_by, points->count, ordered);
    base->target_count = points->count < VW_POSE_TARGETS ? points->count : VW_POSE_TARGETS;
    for (uint32_t k = 0; k < base->target_count; k++)
        memcpy(base->targets_world[k], points->points_world[ordered[k].place], sizeof base->targets_world[k]);
}

void vw_pose_base_find(const struct vw_known_photos *known, uint32_t photo, struct vw_pose_base *base) {
    const struct vw_view *view = vw_known_photo(known, photo);
    double depth = known->maps[photo].median_world;
    if (!(depth > 0)) depth = known->scene->box.half_extent_world; // it sees nothing
    for (int i = 0; i < 3; i++)
        base->focus_world[i] =
            view->camera_to_world[i][VW_POSE_POSITION] - depth * view->camera_to_world[i][VW_POSE_BACK];
    list_targets(&known->points[photo], base);
}

// ---- Places --------------------------------------------------------------------------------------------------------

// Lists the nearest other known photos, the nearest first.
static uint32_t list_neighbours(const struct vw_known_photos *known, uint32_t photo, uint32_t neighbours[NEIGHBOURS]) {
    double apart[NEIGHBOURS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < known->count; i++) {
        double distance = vw_view_apart(&known->scales, vw_known_photo(known, photo), vw_known_photo(known, i));
        uint32_t place = count < NEIGHBOURS ? count : NEIGHBOURS;
        for (; i != photo && place > 0 && distance < apart[place - 1]; place--)
            if (place < NEIGHBOURS) apart[place] = apart[place - 1], neighbours[place] = neighbours[place - 1];
        if (i == photo || place == NEIGHBOURS) continue;
        apart[place] = distance, neighbours[place] = i;
        count += count < NEIGHBOURS;
    }
    return count;
}

static struct mean_camera draw_between(const struct vw_known_photos *known, uint32_t photo, const uint32_t words[8]) {
    struct mean_camera mean = {.photos = {photo}, .count = 1};
    uint32_t neighbours[NEIGHBOURS], count = list_neighbours(known, photo, neighbours);
    for (uint32_t k = 0; k < 2 && count > 0; k++) {
        uint32_t place = vw_random_below(words[k], count);
        mean.photos[mean.count++] = neighbours[place];
        neighbours[place] = neighbours[--count];
    }
    double sum = 0;
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

static void mix_column(const struct vw_known_photos *known, const struct mean_camera *mean,
                       enum vw_pose_column column_of, double column[3]) {
    for (int i = 0; i < 3; i++) {
        column[i] = column_of == VW_POSE_POSITION ? mean->offset_world[i] : 0;
        for (uint32_t k = 0; k < mean->count; k++)
            column[i] += mean->weights[k] * vw_known_photo(known, mean->photos[k])->camera_to_world[i][column_of];
    }
}

bool vw_pose_draw(const struct vw_known_photos *known, const struct vw_pose_base *bases, uint32_t photo, uint32_t draw,
                  double camera_to_world[3][4]) {
    const struct vw_pose_base *own = &bases[photo];
    uint32_t words[8], kind = (photo + draw) % 4;
    double position[3], up[3], focus[3] = {0};
    for (uint32_t k = 0; k < 2; k++)
        vw_random_words(known->seed, VW_RANDOM_POSE, 0, known->views[photo], 2 * draw + k, words + 4 * (size_t)k);
    struct mean_camera mean = kind % 2 ? draw_beside(known, photo, words) : draw_between(known, photo, words);
    mix_column(known, &mean, VW_POSE_POSITION, position);
    mix_column(known, &mean, VW_POSE_UP, up);
    for (int i = 0; i < 3; i++)
        for (uint32_t k = 0; k < mean.count; k++) focus[i] += mean.weights[k] * bases[mean.photos[k]].focus_world[i];
    bool at_target = kind == 3 && own->target_count;
    const double *goal = at_target ? own->targets_world[vw_random_below(words[5], own->target_count)] : focus;
    return vw_camera_look_at(position, goal, up, camera_to_world);
}
