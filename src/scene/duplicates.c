#include "scene/duplicates.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/image.h"
#include "viewworth/scene.h"

enum { CELLS = 16, CELL_COUNT = CELLS * CELLS, SAMPLES = 8 }; // SAMPLES: largest number per cell along each axis
static const double ANGLE_MOST = 2.0 * M_PI / 180;
static const double SIMILARITY_LEAST = 0.98;
static const double FLAT_CONTRAST = 1.0 / 255; // standard deviation below which a photo has nothing to compare

// Luminances of the cells minus their mean, scaled to length 1; all 0 for a photo with nothing to compare.
struct fingerprint {
    float cells[CELL_COUNT];
};

// ---- What photos show ----

// Returns the pixel of sample `index` along a side.
static uint32_t pixel_of(uint32_t index, uint32_t side_px) {
    return (uint32_t)(((uint64_t)2 * index + 1) * side_px / (2 * CELLS * SAMPLES));
}

// Averages over a grid of samples whose size does not depend on the photo's; 0 if no pixel can be used.
static double mean_of_cell(const struct vw_view *view, uint32_t cell_x, uint32_t cell_y) {
    static const float black[3] = {0, 0, 0};
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < SAMPLES * SAMPLES; i++) {
        uint32_t x_px = pixel_of(cell_x * SAMPLES + i % SAMPLES, view->image.width_px);
        uint32_t y_px = pixel_of(cell_y * SAMPLES + i / SAMPLES, view->image.height_px);
        if (!vw_view_can_use(view, x_px, y_px)) continue;
        sum += vw_image_luminance(&view->image, x_px, y_px, black);
        count++;
    }
    return count ? sum / count : 0;
}

static void take_fingerprint(const struct vw_view *view, struct fingerprint *fingerprint) {
    double cells[CELL_COUNT], mean = 0, squares = 0;
    for (uint32_t i = 0; i < CELL_COUNT; i++) {
        cells[i] = mean_of_cell(view, i % CELLS, i / CELLS);
        mean += cells[i] / CELL_COUNT;
    }
    for (uint32_t i = 0; i < CELL_COUNT; i++) squares += (cells[i] - mean) * (cells[i] - mean);
    bool flat = squares < CELL_COUNT * FLAT_CONTRAST * FLAT_CONTRAST;
    for (uint32_t i = 0; i < CELL_COUNT; i++)
        fingerprint->cells[i] = flat ? 0 : (float)((cells[i] - mean) / sqrt(squares));
}

static double correlate(const struct fingerprint *a, const struct fingerprint *b) {
    double sum = 0;
    for (uint32_t i = 0; i < CELL_COUNT; i++) sum += (double)a->cells[i] * b->cells[i];
    return fmin(sum, 1);
}

// ---- Where they were taken ----

static double distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

// Returns the distance of the nearest thing in the view: its near depth if known, otherwise the distance of the box's
// centre.
static double depth_of(const struct vw_scene *scene, const struct vw_view *view) {
    if (view->near_world > 0) return view->near_world;
    const double position[3] = {view->camera_to_world[0][3], view->camera_to_world[1][3], view->camera_to_world[2][3]};
    return distance(position, scene->box.centre_world);
}

static bool stand_together(const struct vw_scene *scene, const struct vw_view *a, const struct vw_view *b) {
    double depth = fmin(depth_of(scene, a), depth_of(scene, b)), between = 0, trace = 0;
    for (int i = 0; i < 3; i++) {
        between = hypot(between, a->camera_to_world[i][3] - b->camera_to_world[i][3]);
        for (int j = 0; j < 3; j++) trace += a->camera_to_world[i][j] * b->camera_to_world[i][j];
    }
    double turn = acos(fmin(fmax((trace - 1) / 2, -1), 1)); // angle of the rotation between the cameras
    return between <= tan(ANGLE_MOST) * depth && turn <= ANGLE_MOST;
}

// ---- Groups ----

static bool is_asked(const struct vw_view *view) {
    return view->split == VW_SPLIT_TRAIN || view->split == VW_SPLIT_VAL;
}

static double similarity_of(const struct vw_scene *scene, const struct fingerprint *prints, uint32_t a, uint32_t b) {
    const struct vw_view *first = &scene->views[a], *second = &scene->views[b];
    if (memcmp(first->sha256, second->sha256, sizeof first->sha256) == 0) return 1;
    return stand_together(scene, first, second) ? correlate(&prints[a], &prints[b]) : 0;
}

// Sets leaders[v] to the first view that v is a near-duplicate of; v itself if there is none.
static void find_leaders(const struct vw_scene *scene, const struct fingerprint *prints, uint32_t *leaders,
                         double *similarities) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        leaders[v] = v;
        similarities[v] = 1;
        for (uint32_t first = 0; is_asked(&scene->views[v]) && first < v && leaders[v] == v; first++) {
            if (!is_asked(&scene->views[first]) || leaders[first] != first) continue;
            double similarity = similarity_of(scene, prints, first, v);
            if (similarity < SIMILARITY_LEAST) continue;
            leaders[v] = first;
            similarities[v] = similarity;
        }
    }
}

// Lists all groups of more than one photo; returns their number of photos. At worst O(photos^2) comparisons in memory.
static uint32_t list_groups(uint32_t view_count, const uint32_t *leaders, const double *similarities,
                            struct vw_duplicate *duplicates) {
    uint32_t count = 0, group = 0;
    for (uint32_t first = 0; first < view_count; first++) {
        uint32_t begin = count;
        if (leaders[first] != first) continue;
        for (uint32_t v = first; v < view_count; v++)
            if (leaders[v] == first) duplicates[count++] = (struct vw_duplicate){group, v, similarities[v]};
        if (count - begin > 1) group++;
        else count = begin;
    }
    return count;
}

enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates,
                                        uint32_t *count) {
    struct fingerprint *prints = vw_allocate(scene->view_count, sizeof *prints);
    uint32_t *leaders = vw_allocate(scene->view_count, sizeof *leaders);
    double *similarities = vw_allocate(scene->view_count, sizeof *similarities);
    struct vw_duplicate *found = vw_allocate(scene->view_count, sizeof *found);
    enum vw_status status = prints && leaders && similarities && found ? vw_scene_decode_all(scene) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        if (is_asked(&scene->views[v])) take_fingerprint(&scene->views[v], &prints[v]);
    if (!status) {
        find_leaders(scene, prints, leaders, similarities);
        *count = list_groups(scene->view_count, leaders, similarities, found);
        *duplicates = found;
    } else {
        free(found);
    }
    free(prints);
    free(leaders);
    free(similarities);
    return status;
}
