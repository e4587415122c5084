#include "check/beside.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"

enum { REACH_PX = 12, SIDE_PX = 2 * REACH_PX, NEAR_LEAST_PX = 3, ROUNDS = 10, FEW = 8, EVERY = 2 };
static const double NEAR_SHARE = 0.05;   // share of the longer side of a photo
static const double SCALES_APART = 0.5;  // log2 of magnification: beyond, a photo shows details of another size
static const double SHOWN_LEAST = 0.15;  // share of the points
static const double OPAQUE_LEAST = 0.25; // share of a window
// Added to sums of squares and of amplitudes, of the size that rounding to 8 bits makes.
static const double ROUNDING = 2e-6, CONTRAST_ROUNDING = 1e-4, NOISE_ROUNDING = 1e-3, DARK = 1e-3;

struct window {
    float values[SIDE_PX * SIDE_PX];
    double linear; // mean of its opaque pixels near the middle; NaN: too few
};

// Returns how far from the middle brightness is read: a small photo has another surface not far away.
static uint32_t near_of(const struct vw_image *image) {
    uint32_t longer_px = image->width_px > image->height_px ? image->width_px : image->height_px;
    return (uint32_t)fmin(fmax(NEAR_SHARE * longer_px, NEAR_LEAST_PX), REACH_PX);
}

static bool read_window(const struct vw_scene *scene, const struct vw_check_photo *photo, const double at_px[2],
                        struct window *window) {
    const struct vw_image *image = &photo->view->image;
    double x = at_px[0] / photo->small_per_px, y = at_px[1] / photo->small_per_px, linear = 0;
    uint32_t opaque = 0, near = near_of(image);
    if (!(x >= REACH_PX && y >= REACH_PX && x + REACH_PX <= image->width_px && y + REACH_PX <= image->height_px))
        return false;
    for (uint32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        uint32_t u = i % SIDE_PX, v = i / SIDE_PX, column = (uint32_t)x - REACH_PX + u,
                 row = (uint32_t)y - REACH_PX + v;
        float rgba[4] = {0, 0, 0, 1};
        if (!vw_view_keeps(photo->view, column, row)) return false;
        window->values[i] = (float)vw_image_luminance(image, column, row, scene->background);
        if (u < REACH_PX - near || v < REACH_PX - near || u >= REACH_PX + near || v >= REACH_PX + near) continue;
        if (image->has_alpha) vw_image_pixel(image, column, row, rgba);
        if (rgba[3] < 1) continue;
        linear += vw_srgb_decode(window->values[i]);
        opaque++;
    }
    window->linear = opaque >= OPAQUE_LEAST * 4 * near * near ? linear / opaque : NAN;
    return true;
}

// Computes the mean products of gradients (xx, xy, yy), and returns the variance of the values.
static double measure_level(const float *values, uint32_t side, double products[3]) {
    double sum = 0, squares = 0, count = (side - 1.0) * (side - 1.0);
    products[0] = products[1] = products[2] = 0;
    for (uint32_t i = 0; i < side * side; i++) sum += values[i], squares += (double)values[i] * values[i];
    for (uint32_t y = 0; y + 1 < side; y++)
        for (uint32_t x = 0; x + 1 < side; x++) {
            const float *at = values + y * side + x;
            double across = (at[1] - at[0] + at[side + 1] - at[side]) / 2;
            double down = (at[side] - at[0] + at[side + 1] - at[1]) / 2;
            products[0] += across * across / count, products[1] += across * down / count;
            products[2] += down * down / count;
        }
    return squares / (side * side) - sum / (side * side) * sum / (side * side);
}

// Halves the size in place: rows are read before they are written.
static void halve(float *values, uint32_t side) {
    for (uint32_t y = 0; y < side / 2; y++)
        for (uint32_t x = 0; x < side / 2; x++) {
            const float *at = values + 2 * y * side + 2 * x;
            values[y * (side / 2) + x] = (at[0] + at[1] + at[side] + at[side + 1]) / 4;
        }
}

// Returns the mean absolute response to the operator of Immerkaer (CVIU 1996), which straight edges do not move.
static double measure_noise(const float *values) {
    double sum = 0;
    for (uint32_t y = 1; y + 1 < SIDE_PX; y++)
        for (uint32_t x = 1; x + 1 < SIDE_PX; x++) {
            const float *at = values + y * SIDE_PX + x, *above = at - SIDE_PX, *below = at + SIDE_PX;
            sum += fabsf(4 * at[0] - 2 * (at[1] + at[-1] + above[0] + below[0]) + above[-1] + above[1] + below[-1] +
                         below[1]);
        }
    return sum / ((SIDE_PX - 2) * (SIDE_PX - 2));
}

static bool measure(const struct vw_scene *scene, const struct vw_check_photo *photo, const double at_px[2],
                    float measures[VW_BESIDE_COUNT]) {
    struct window window;
    double products[VW_SHARPNESS_LEVELS][3], contrast = 0;
    if (!read_window(scene, photo, at_px, &window)) return false;
    double noise = measure_noise(window.values);
    uint32_t side = SIDE_PX;
    for (int level = 0; level < VW_SHARPNESS_LEVELS; level++, side /= 2) {
        if (level) halve(window.values, 2 * side);
        contrast = fmax(measure_level(window.values, side, products[level]), 0);
    }
    measures[VW_BESIDE_STOPS] = (float)log2(window.linear + DARK);
    measures[VW_BESIDE_NOISE] = (float)(log(noise + NOISE_ROUNDING) - log(contrast + CONTRAST_ROUNDING) / 2);
    for (int i = 0; i < VW_SHARPNESS_LEVELS * VW_SHARPNESS_DIRECTIONS; i++) {
        double angle = M_PI * (i % VW_SHARPNESS_DIRECTIONS) / VW_SHARPNESS_DIRECTIONS, c = cos(angle), s = sin(angle);
        const double *of = products[i / VW_SHARPNESS_DIRECTIONS];
        double energy = c * c * of[0] + 2 * c * s * of[1] + s * s * of[2];
        measures[VW_BESIDE_SHARPNESS + i] = (float)(log(energy + ROUNDING) - log(contrast + CONTRAST_ROUNDING)) / 2;
    }
    return true;
}

uint32_t vw_beside_measure(const struct vw_check_photos *photos, uint32_t view, const struct vw_expected *expected,
                           struct vw_beside *made) {
    uint32_t count = 0, shown = 0;
    for (uint32_t i = 0; i < expected->count; i++) shown += expected->list[i].shown;
    bool only_shown = shown >= SHOWN_LEAST * expected->count; // cover tells nothing of the photo
    for (uint32_t i = 0; i < expected->count; i += EVERY) {
        const struct vw_expected_point *point = &expected->list[i];
        const struct vw_check_photo *photo = &photos->list[view];
        float here[VW_BESIDE_COUNT], there[VW_BESIDE_COUNT];
        if (only_shown && !point->shown) continue;
        if (!measure(photos->scene, photo, point->at_px, here)) continue;
        for (int k = 0; k < 2; k++) {
            const struct vw_check_photo *other = &photos->list[point->references[k]];
            double magnification = point->magnification[k] / photo->small_per_px * other->small_per_px;
            if (fabs(log2(magnification)) > SCALES_APART) continue;
            if (!measure(photos->scene, other, point->reference_px[k], there)) continue;
            made[count].other = point->references[k];
            made[count].shown = point->shown;
            for (int m = 0; m < VW_BESIDE_COUNT; m++) made[count].differences[m] = here[m] - there[m];
            count++;
        }
    }
    return count;
}

// A comparison, as it is for one of its two photos.
struct seen {
    const struct vw_beside *made;
    uint32_t other; // scene index
    float sign;
};

// All comparisons, photo by photo. Owned.
struct all_seen {
    struct seen *list;
    uint32_t *begins; // by photo, and one beyond
    uint32_t most;    // that a photo has
};

static void free_seen(struct all_seen *all) {
    free(all->list);
    free(all->begins);
}

// Lists each comparison with its photo, and with the other one unless something strange may be compared.
static enum vw_status list_seen(struct vw_beside *const *made, const uint32_t *counts, uint32_t view_count,
                                struct all_seen *all) {
    all->begins = vw_allocate((size_t)view_count + 2, sizeof *all->begins); // shifted by one while filling
    if (!all->begins) return VW_ERROR_MEMORY;
    uint32_t *ends = all->begins + 1;
    for (uint32_t v = 0; v < view_count; v++)
        for (uint32_t i = 0; i < counts[v]; i++) {
            ends[v + 1]++;
            ends[made[v][i].other + 1] += made[v][i].shown;
        }
    for (uint32_t v = 0; v < view_count; v++) {
        if (ends[v + 1] > all->most) all->most = ends[v + 1];
        ends[v + 1] += ends[v];
    }
    all->list = vw_allocate(ends[view_count], sizeof *all->list);
    for (uint32_t v = 0; v < view_count && all->list; v++)
        for (uint32_t i = 0; i < counts[v]; i++) {
            const struct vw_beside *one = &made[v][i];
            all->list[ends[v]++] = (struct seen){one, one->other, 1};
            if (one->shown) all->list[ends[one->other]++] = (struct seen){one, v, -1};
        }
    return all->list ? VW_OK : VW_ERROR_MEMORY;
}

// Sorts what a measure of a photo is by each comparison; returns how many there are.
static uint32_t sort_values(const struct all_seen *all, uint32_t view, int measure,
                            const struct vw_beside_level (*levels)[VW_BESIDE_COUNT], double *values) {
    uint32_t known = 0;
    for (uint32_t i = all->begins[view]; i < all->begins[view + 1]; i++) {
        const struct seen *seen = &all->list[i];
        double value = seen->sign * seen->made->differences[measure] + levels[seen->other][measure].median;
        if (!isnan(value)) values[known++] = value;
    }
    vw_sort(values, known);
    return known;
}

enum vw_status vw_beside_solve(struct vw_beside *const *made, const uint32_t *counts, uint32_t view_count,
                               struct vw_beside_level (*levels)[VW_BESIDE_COUNT]) {
    struct all_seen all = {0};
    enum vw_status status = list_seen(made, counts, view_count, &all);
    double *values = status ? NULL : vw_allocate(all.most, sizeof *values);
    if (!values) status = VW_ERROR_MEMORY;
    for (int round = 0; round < ROUNDS && !status; round++)
        for (uint32_t v = 0; v < view_count; v++)
            for (int m = 0; m < VW_BESIDE_COUNT; m++) {
                struct vw_beside_level *level = &levels[v][m];
                uint32_t known =
                    sort_values(&all, v, m, (const struct vw_beside_level(*)[VW_BESIDE_COUNT])levels, values);
                if (known >= FEW) level->median = vw_quantile_of_sorted(values, known, 0.5);
                if (round + 1 < ROUNDS) continue;
                level->low = known >= FEW ? vw_quantile_of_sorted(values, known, 0.25) : NAN;
                level->high = known >= FEW ? vw_quantile_of_sorted(values, known, 0.75) : NAN;
            }
    free(values);
    free_seen(&all);
    return status;
}
