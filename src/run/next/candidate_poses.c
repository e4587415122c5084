#include "run/next/candidate_poses.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "scene/camera_path.h"

enum { NEIGHBOURS = 6, MIXED = 3 };
static const double LEAST_STEP = 0.5, MOST_STEP = 2; // in usual distances between neighbours' positions

enum axis { UP = 1, POSITION = 3 }; // columns of camera_to_world

// The mean of some cameras, moved.
struct mean_camera {
    uint32_t bases[MIXED], count;
    double weights[MIXED], offset_world[3];
};

static double focal_share(const struct vw_camera *camera) {
    return camera->focal_x_px / fmax(camera->width_px, camera->height_px);
}

uint32_t vw_usual_view(const struct vw_scene *scene, const uint32_t *views, uint32_t count) {
    uint32_t usual = views[0];
    for (uint32_t i = 0; i < count; i++) {
        uint32_t below = 0;
        for (uint32_t j = 0; j < count; j++) {
            double difference =
                focal_share(&scene->views[views[j]].camera) - focal_share(&scene->views[views[i]].camera);
            below += difference < 0 || (difference == 0 && j < i);
        }
        if (below == (count - 1) / 2) usual = views[i];
    }
    return usual;
}

static const struct vw_view *view_of(const struct vw_pose_bases *known, uint32_t base) {
    return &known->scene->views[known->bases[base].view];
}

// Lists the nearest other known photos, the nearest first.
static uint32_t list_neighbours(const struct vw_pose_bases *known, uint32_t base, uint32_t neighbours[NEIGHBOURS]) {
    double apart[NEIGHBOURS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < known->count; i++) {
        double distance = vw_view_apart(known->scales, view_of(known, base), view_of(known, i));
        uint32_t place = count < NEIGHBOURS ? count : NEIGHBOURS;
        for (; i != base && place > 0 && distance < apart[place - 1]; place--)
            if (place < NEIGHBOURS) apart[place] = apart[place - 1], neighbours[place] = neighbours[place - 1];
        if (i == base || place == NEIGHBOURS) continue;
        apart[place] = distance, neighbours[place] = i;
        count += count < NEIGHBOURS;
    }
    return count;
}

static struct mean_camera draw_between(const struct vw_pose_bases *known, uint32_t base, const uint32_t words[8]) {
    struct mean_camera mean = {.bases = {base}, .count = 1};
    uint32_t neighbours[NEIGHBOURS], count = list_neighbours(known, base, neighbours);
    for (uint32_t k = 0; k < 2 && count > 0; k++) {
        uint32_t place = vw_random_below(words[k], count);
        mean.bases[mean.count++] = neighbours[place];
        neighbours[place] = neighbours[--count];
    }
    double sum = 0;
    for (uint32_t k = 0; k < mean.count; k++)
        sum += mean.weights[k] = -log1p(-(double)vw_random_unit(words[2 + k])) + 1e-9; // uniform over all mixtures
    for (uint32_t k = 0; k < mean.count; k++) mean.weights[k] /= sum;
    return mean;
}

static struct mean_camera draw_beside(const struct vw_pose_bases *known, uint32_t base, const uint32_t words[8]) {
    struct mean_camera mean = {.bases = {base}, .count = 1, .weights = {1}};
    double height = 2 * (double)vw_random_unit(words[0]) - 1, turn = 2 * M_PI * (double)vw_random_unit(words[1]);
    double share = (double)vw_random_unit(words[2]),
           step = known->scales->between_world * ((1 - share) * LEAST_STEP + share * MOST_STEP);
    mean.offset_world[0] = step * sqrt(1 - height * height) * cos(turn);
    mean.offset_world[1] = step * sqrt(1 - height * height) * sin(turn);
    mean.offset_world[2] = step * height;
    return mean;
}

static void mix_column(const struct vw_pose_bases *known, const struct mean_camera *mean, enum axis axis,
                       double column[3]) {
    for (int i = 0; i < 3; i++) {
        column[i] = axis == POSITION ? mean->offset_world[i] : 0;
        for (uint32_t k = 0; k < mean->count; k++)
            column[i] += mean->weights[k] * view_of(known, mean->bases[k])->camera_to_world[i][axis];
    }
}

bool vw_pose_draw(const struct vw_pose_bases *known, uint32_t base, uint32_t draw, double camera_to_world[3][4]) {
    const struct vw_pose_base *own = &known->bases[base];
    uint32_t words[8];
    double position[3], up[3], target[3] = {0};
    for (uint32_t k = 0; k < 2; k++)
        vw_random_words(known->seed, VW_RANDOM_POSE, 0, own->view, 2 * draw + k, words + 4 * (size_t)k);
    uint32_t kind = (base + draw) % 4;
    struct mean_camera mean = kind % 2 ? draw_beside(known, base, words) : draw_between(known, base, words);
    mix_column(known, &mean, POSITION, position);
    mix_column(known, &mean, UP, up);
    bool at_target = kind == 3 && own->target_count;
    for (int i = 0; i < 3; i++)
        for (uint32_t k = 0; k < mean.count; k++)
            target[i] += mean.weights[k] * known->bases[mean.bases[k]].focus_world[i];
    const double *goal = at_target ? own->targets_world[vw_random_below(words[5], own->target_count)] : target;
    return vw_camera_look_at(position, goal, up, camera_to_world);
}
