// The errors of panes, what nearby panes share of them, and the regions that remain.
#include "run/outputs/cover_regions.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

// Chosen on fox and chair_synthetic, each with a quarter of its photos covered.
static const double SEED_LEAST = 0.1;     // error of colours in [0,1]
static const double SEED_MEDIANS = 4;     // the same, in medians of the scene
static const double GROWN_SHARE = 0.5;    // the share of that which pixels around need
static const double SEEDS_LEAST = 0.25;   // share of a region
static const double REGION_LEAST = 0.005; // share of a photo
static const double SHARED = 1.5;         // times the error that nearby photos share
static const double DEPTH_APART = 0.1;    // relative; a place farther beyond what a photo sees is hidden from it
static const double FIT_MEDIANS = 3;      // errors beyond these and SEED_LEAST (plain grounds have none) are not fitted
static const double GAIN_MOST = 4;        // a fit of more, or less than its inverse, tells nothing
enum { SMOOTH_PX = 2, FITS = 4, NEIGHBOURS = 6, SHARING_LEAST = 2 };

static size_t pixels_of(const struct vw_cover_pane *pane) {
    return (size_t)pane->camera.width_px * pane->camera.height_px;
}

// ---- Errors --------------------------------------------------------------------------------------------------------

static void set_errors(const struct vw_panes *panes, const double gain[3], const double bias[3], float *errors) {
    for (size_t i = 0; i < (size_t)panes->size_px[0] * panes->size_px[1]; i++) {
        double sum = 0;
        for (size_t c = 0; c < 3; c++)
            sum += fabs(gain[c] * panes->render[3 * i + c] + bias[c] - panes->photo[3 * i + c]) / 3;
        errors[i] = panes->counts[i] ? (float)sum : NAN;
    }
}

// Returns the median of those that are known.
static double median_of(const float *errors, size_t count, double *scratch) {
    uint32_t known = 0;
    for (size_t i = 0; i < count; i++)
        if (!isnan(errors[i])) scratch[known++] = errors[i];
    return vw_median(scratch, known);
}

// Averages over a square around each pixel, of what is known.
static void smooth(const float *errors, uint32_t width_px, uint32_t height_px, float *smoothed) {
    for (uint32_t y = 0; y < height_px; y++)
        for (uint32_t x = 0; x < width_px; x++) {
            double sum = 0, count = 0;
            for (int64_t v = (int64_t)y - SMOOTH_PX; v <= (int64_t)y + SMOOTH_PX; v++)
                for (int64_t u = (int64_t)x - SMOOTH_PX; u <= (int64_t)x + SMOOTH_PX; u++) {
                    if (u < 0 || v < 0 || u >= width_px || v >= height_px) continue;
                    float error = errors[v * width_px + u];
                    if (!isnan(error)) sum += error, count++;
                }
            size_t i = (size_t)y * width_px + x;
            smoothed[i] = isnan(errors[i]) ? NAN : (float)(sum / count);
        }
}

static void compare(const struct vw_panes *panes, float *errors, double *scratch, float *smoothed) {
    double gain[3] = {1, 1, 1}, bias[3] = {0};
    set_errors(panes, gain, bias, errors);
    for (int i = 0; i < FITS; i++) {
        double median = median_of(errors, (size_t)panes->size_px[0] * panes->size_px[1], scratch);
        for (uint32_t c = 0; c < 3; c++) {
            vw_panes_fit(panes, c, errors, fmax(FIT_MEDIANS * median, SEED_LEAST), &gain[c], &bias[c]);
            if (!(gain[c] >= 1 / GAIN_MOST && gain[c] <= GAIN_MOST)) gain[c] = 1, bias[c] = 0;
        }
        set_errors(panes, gain, bias, errors);
    }
    smooth(errors, panes->size_px[0], panes->size_px[1], smoothed);
}

enum vw_status vw_cover_make_errors(const struct vw_panes *panes, struct vw_cover_pane *pane) {
    size_t pixels = (size_t)panes->size_px[0] * panes->size_px[1];
    float *errors = vw_allocate(pixels, sizeof *errors);
    double *scratch = vw_allocate(pixels, sizeof *scratch);
    pane->errors = vw_allocate(pixels, sizeof *pane->errors);
    bool made = errors && scratch && pane->errors;
    if (made) compare(panes, errors, scratch, pane->errors);
    free(errors);
    free(scratch);
    return made ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_cover_settle(struct vw_cover_panes *panes) {
    size_t most = 0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < panes->count; v++)
        if (panes->list[v].view && pixels_of(&panes->list[v]) > most) most = pixels_of(&panes->list[v]);
    double *scratch = vw_allocate(most, sizeof *scratch), *medians = vw_allocate(panes->count, sizeof *medians);
    for (uint32_t v = 0; scratch && medians && v < panes->count; v++) {
        const struct vw_cover_pane *pane = &panes->list[v];
        double median = pane->view ? median_of(pane->errors, pixels_of(pane), scratch) : NAN;
        if (!isnan(median)) medians[count++] = median;
    }
    enum vw_status status = scratch && medians ? VW_OK : VW_ERROR_MEMORY;
    if (!status) panes->seed_error = fmax(SEED_LEAST, SEED_MEDIANS * vw_median(medians, count));
    free(scratch);
    free(medians);
    return status;
}

// ---- What nearby photos share --------------------------------------------------------------------------------------

static uint32_t list_neighbours(const struct vw_cover_panes *panes, uint32_t place, uint32_t neighbours[NEIGHBOURS]) {
    double distances[NEIGHBOURS];
    uint32_t count = 0;
    for (uint32_t v = 0; v < panes->count; v++) {
        if (v == place || !panes->list[v].view || !panes->list[v].tells) continue;
        double apart = vw_view_apart(&panes->scales, panes->list[place].view, panes->list[v].view);
        uint32_t rank = count;
        while (rank && distances[rank - 1] > apart) rank--;
        if (rank == NEIGHBOURS) continue;
        count += count < NEIGHBOURS;
        for (uint32_t i = count - 1; i > rank; i--) distances[i] = distances[i - 1], neighbours[i] = neighbours[i - 1];
        distances[rank] = apart, neighbours[rank] = v;
    }
    return count;
}

static void to_camera(const struct vw_cover_pane *pane, const double place_world[3], double camera[3]) {
    for (int i = 0; i < 3; i++) camera[i] = 0;
    for (int row = 0; row < 3; row++)
        for (int i = 0; i < 3; i++)
            camera[i] += pane->view->camera_to_world[row][i] *
                         (place_world[row] - pane->view->camera_to_world[row][VW_POSE_POSITION]);
}

static double depth_of(const struct vw_cover_pane *pane, const double place_world[3]) {
    double camera[3];
    to_camera(pane, place_world, camera);
    return -camera[2];
}

// Computes the place that a pixel of a pane sees; where that is nothing, a place that it sees through, as far away as
// the middle of the scene. False where it has no ray.
static bool place_of(const struct vw_cover_panes *panes, const struct vw_cover_pane *pane, uint32_t x, uint32_t y,
                     double place_world[3]) {
    double direction[3], depth = pane->depths[(size_t)y * pane->camera.width_px + x];
    if (!(depth > 0)) depth = depth_of(pane, panes->middle_world);
    if (!(depth > 0) || !vw_camera_unproject(&pane->camera, x + 0.5, y + 0.5, direction)) return false;
    for (int row = 0; row < 3; row++) {
        const double *pose = pane->view->camera_to_world[row];
        place_world[row] = pose[VW_POSE_POSITION];
        for (int i = 0; i < 3; i++) place_world[row] += pose[i] * depth * direction[i];
    }
    return true;
}

// Returns the error of a pane at a place; NaN where it does not show it.
static double error_at(const struct vw_cover_pane *pane, const double place_world[3]) {
    double camera[3], x_px, y_px;
    to_camera(pane, place_world, camera);
    const struct vw_camera *size = &pane->camera;
    if (hypot(camera[0], camera[1]) > -camera[2] * vw_camera_fold(size)) return NAN; // a lens folds what is beyond
    if (!vw_camera_project(size, camera, &x_px, &y_px)) return NAN;
    if (!(x_px >= 0 && y_px >= 0 && x_px < size->width_px && y_px < size->height_px)) return NAN;
    size_t i = (size_t)y_px * size->width_px + (size_t)x_px;
    double depth = pane->depths[i];
    bool before_it = !(depth > 0) || -camera[2] <= depth * (1 + DEPTH_APART);
    return before_it ? pane->errors[i] : NAN;
}

// Returns the error that the best but one of the nearby photos has there (others may be covered, too); NaN: too few
// show it.
static double shared_error(const struct vw_cover_panes *panes, const struct vw_cover_pane *pane, uint32_t x, uint32_t y,
                           const uint32_t *neighbours, uint32_t count) {
    double place_world[3], errors[NEIGHBOURS];
    uint32_t known = 0;
    if (!place_of(panes, pane, x, y, place_world)) return NAN;
    for (uint32_t i = 0; i < count; i++) {
        double error = error_at(&panes->list[neighbours[i]], place_world);
        if (!isnan(error)) errors[known++] = error;
    }
    if (known < SHARING_LEAST) return NAN;
    vw_sort(errors, known);
    return errors[SHARING_LEAST - 1];
}

// ---- Regions -------------------------------------------------------------------------------------------------------

enum state { KEPT, GROWN, SEED, SEEN, COVERED }; // GROWN and SEED last until their region is seen

static void classify(const struct vw_cover_panes *panes, uint32_t place, uint8_t *states) {
    const struct vw_cover_pane *pane = &panes->list[place];
    uint32_t neighbours[NEIGHBOURS], count = list_neighbours(panes, place, neighbours);
    uint32_t width_px = pane->camera.width_px;
    double grown = GROWN_SHARE * panes->seed_error;
    for (uint32_t i = 0; i < pixels_of(pane); i++) {
        states[i] = KEPT;
        if (!(pane->errors[i] > grown)) continue;
        double shared = shared_error(panes, pane, i % width_px, i / width_px, neighbours, count);
        double excess = pane->errors[i] - SHARED * shared;
        states[i] = excess > panes->seed_error ? SEED : isnan(shared) || excess > grown ? GROWN : KEPT;
    }
}

// Walks the region around a pixel of a state below SEEN but not KEPT, and lists it; returns its pixels, and counts its
// seeds.
static size_t walk(uint8_t *states, uint32_t width_px, uint32_t height_px, uint32_t first, uint32_t *region,
                   size_t *seeds) {
    size_t count = 0;
    *seeds = states[first] == SEED;
    states[first] = SEEN;
    region[count++] = first;
    for (size_t next = 0; next < count; next++) {
        uint32_t x = region[next] % width_px, y = region[next] / width_px;
        const int64_t around[4] = {x ? (int64_t)region[next] - 1 : -1,
                                   x + 1 < width_px ? (int64_t)region[next] + 1 : -1, (int64_t)region[next] - width_px,
                                   y + 1 < height_px ? (int64_t)region[next] + width_px : -1};
        for (int i = 0; i < 4; i++) {
            if (around[i] < 0 || (states[around[i]] != GROWN && states[around[i]] != SEED)) continue;
            *seeds += states[around[i]] == SEED;
            states[around[i]] = SEEN;
            region[count++] = (uint32_t)around[i];
        }
    }
    return count;
}

// Marks the regions that are large enough and have enough seeds as covered; returns their share of the photo.
static double mark_regions(uint8_t *states, uint32_t width_px, uint32_t height_px, uint32_t *region) {
    size_t pixels = (size_t)width_px * height_px, covered = 0;
    for (uint32_t first = 0; first < pixels; first++) {
        size_t seeds = 0;
        if (states[first] != SEED) continue;
        size_t count = walk(states, width_px, height_px, first, region, &seeds);
        bool covers = count >= REGION_LEAST * (double)pixels && (double)seeds >= SEEDS_LEAST * (double)count;
        for (size_t i = 0; i < count; i++) states[region[i]] = covers ? COVERED : SEEN;
        covered += covers ? count : 0;
    }
    return (double)covered / (double)pixels;
}

enum vw_status vw_cover_find(const struct vw_cover_panes *panes, uint32_t place, bool *covered, double *share) {
    const struct vw_cover_pane *pane = &panes->list[place];
    uint8_t *states = vw_allocate(pixels_of(pane), 1);
    uint32_t *region = vw_allocate(pixels_of(pane), sizeof *region);
    enum vw_status status = states && region ? VW_OK : VW_ERROR_MEMORY;
    if (!status) {
        classify(panes, place, states);
        *share = mark_regions(states, pane->camera.width_px, pane->camera.height_px, region);
        for (size_t i = 0; i < pixels_of(pane); i++) covered[i] = states[i] == COVERED;
    }
    free(states);
    free(region);
    return status;
}
