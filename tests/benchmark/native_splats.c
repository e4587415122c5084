// Yardstick: training of Gaussian splats in plain single-threaded C. Photos, their squares, initial splats and rates
// are those of our own steps; the arithmetic is written for what a compiler makes of one core (flags:
// tests/CMakeLists.txt).
//
//     native_splats SCENE DOWNSCALE STEPS [SPLATS]
//
// Prints the median time of a step and the mean PSNR of the validation photos after the last one, all of their pixels.
// Harmonics are of degree 1, lenses are those of pinholes, and the loss is squared.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "train/field.h"
#include "train/photo_order.h"
#include "train/pixels.h"
#include "viewworth/scene.h"

enum { SIDE = VW_SPLAT_SQUARE, PIXELS = SIDE * SIDE, COEFFICIENTS = 4, SQUARES = 12 };
// The numbers of a splat.
enum { MEAN, LOGIT = 3, SCALE, TURN = 7, HARMONICS = 11, NUMBERS = HARMONICS + 3 * COEFFICIENTS };
enum { Q, QX, QY, QXX, QXY, QYY, RED, SUMS = RED + 3 }; // sums over the pixels that a splat colours
static const float ALPHA_LEAST = 1.0f / 255, ALPHA_MOST = 0.99f, LEFT_LEAST = 1e-4f, LOW_PASS = 0.3f;

struct vector {
    float x, y, z;
};

struct flat {                    // a splat on a photo
    struct vector at, direction; // in the camera's axes; from the camera, of length 1
    float distance, x, y, conic[3], opacity, colour[3];
    float turn[3][3], scale[3]; // turn: columns
    struct vector u[2], v[2];   // rows of J W and of J W R S
    bool within[2];             // the slope is not clamped
    int columns[2], rows[2];    // first and last square
};

struct splat {
    float number[NUMBERS], square[NUMBERS]; // params, second moments
    uint32_t visits;
};

struct training {
    struct vw_scene *scene;
    struct vw_config config;
    struct vw_model model;
    struct vw_photo_order order;
    struct splat *splats;
    struct flat *flats;
    float (*sums)[SUMS];
    uint32_t *nearest; // splats that the photo shows, by depth
    uint32_t shown, *pairs;
    struct vw_pixel *pixels;
};

// ---- Vectors --------------------------------------------------------------------------------------------------------

static struct vector of(const float *a) { return (struct vector){a[0], a[1], a[2]}; }
static float dot(struct vector a, struct vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static struct vector add(struct vector a, float by, struct vector b) {
    return (struct vector){a.x + by * b.x, a.y + by * b.y, a.z + by * b.z};
}
static struct vector times(float by, struct vector a) { return (struct vector){by * a.x, by * a.y, by * a.z}; }

// Writes the columns of a turn, and returns the length of its quaternion.
static float turn_columns(const float *q, float unit[4], float m[3][3]) {
    float length = sqrtf(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++) unit[i] = q[i] / length;
    float w = unit[0], x = unit[1], y = unit[2], z = unit[3];
    const float columns[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
                                 {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
                                 {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
    memcpy(m, columns, sizeof columns);
    return length;
}

// ---- From splats to a photo -----------------------------------------------------------------------------------------

struct photo {
    struct vw_gpu_camera camera;
    struct vector right, down, ahead;
    float width_px, height_px;
};

static struct photo photo_of(const struct training *t, uint32_t view) {
    const struct vw_view *own = &t->scene->views[view];
    struct photo photo = {.camera = vw_field_camera(&t->model, own, &t->model.box),
                          .width_px = (float)own->image.width_px,
                          .height_px = (float)own->image.height_px};
    photo.right = (struct vector){photo.camera.right.x, photo.camera.right.y, photo.camera.right.z};
    photo.down = (struct vector){-photo.camera.up.x, -photo.camera.up.y, -photo.camera.up.z};
    photo.ahead = (struct vector){-photo.camera.back.x, -photo.camera.back.y, -photo.camera.back.z};
    return photo;
}

// Writes one row of J W and of J W R S.
static void project_row(struct flat *f, int row, struct vector axis, struct vector ahead, float slope, float focal) {
    f->u[row] = times(focal / f->at.z, add(axis, -slope, ahead));
    float along[3];
    for (int k = 0; k < 3; k++) along[k] = dot(f->u[row], of(f->turn[k])) * f->scale[k];
    f->v[row] = of(along);
}

static float clamped(float value, float centre, float size, float focal, bool *within) {
    float margin = 0.15f * size / focal, least = -centre / focal - margin, most = (size - centre) / focal + margin;
    *within = value >= least && value <= most;
    return fminf(fmaxf(value, least), most);
}

// Returns whether a length of pixels touches squares, and which.
static bool touch(float centre, float reach, float size, int touched[2]) {
    touched[0] = (int)fmaxf(floorf((centre - reach) / SIDE), 0);
    touched[1] = (int)fminf(floorf((centre + reach) / SIDE), ceilf(size / SIDE) - 1);
    return touched[0] <= touched[1];
}

static void colour(const float *number, struct flat *f) {
    struct vector d = f->direction;
    const float basis[COEFFICIENTS] = {0.28209479f, -0.48860251f * d.y, 0.48860251f * d.z, -0.48860251f * d.x};
    for (int c = 0; c < 3; c++) {
        f->colour[c] = 0.5f;
        for (int k = 0; k < COEFFICIENTS; k++) f->colour[c] += basis[k] * number[HARMONICS + 3 * k + c];
        f->colour[c] = fmaxf(f->colour[c], 0);
    }
}

// Says whether the photo shows the splat.
static bool project(const struct photo *photo, const float *number, struct flat *f) {
    const vw_float4 *reference = &photo->camera.reference;
    float focal_x = photo->camera.right.w, focal_y = photo->camera.up.w, unit[4];
    struct vector offset = {number[0] - reference->x, number[1] - reference->y, number[2] - reference->z};
    f->at =
        (struct vector){dot(offset, photo->right), dot(offset, photo->down), dot(offset, photo->ahead) + reference->w};
    f->opacity = 1 / (1 + expf(-number[LOGIT]));
    if (!(f->at.z >= 0.02f) || f->opacity < ALPHA_LEAST) return false;
    struct vector seen = add(offset, reference->w, photo->ahead);
    f->distance = sqrtf(dot(seen, seen));
    f->direction = times(1 / f->distance, seen);
    turn_columns(number + TURN, unit, f->turn);
    for (int k = 0; k < 3; k++) f->scale[k] = expf(number[SCALE + k]);
    float slope_x = f->at.x / f->at.z, slope_y = f->at.y / f->at.z;
    f->x = focal_x * slope_x + photo->camera.back.w;
    f->y = focal_y * slope_y + photo->camera.more.x;
    slope_x = clamped(slope_x, photo->camera.back.w, photo->width_px, focal_x, &f->within[0]);
    slope_y = clamped(slope_y, photo->camera.more.x, photo->height_px, focal_y, &f->within[1]);
    project_row(f, 0, photo->right, photo->ahead, slope_x, focal_x);
    project_row(f, 1, photo->down, photo->ahead, slope_y, focal_y);
    float xx = dot(f->v[0], f->v[0]) + LOW_PASS, xy = dot(f->v[0], f->v[1]), yy = dot(f->v[1], f->v[1]) + LOW_PASS,
          determinant = xx * yy - xy * xy, reach = sqrtf(2 * logf(255 * f->opacity));
    f->conic[0] = yy / determinant;
    f->conic[1] = -xy / determinant;
    f->conic[2] = xx / determinant;
    colour(number, f);
    return determinant > 0 && touch(f->x, reach * sqrtf(xx), photo->width_px, f->columns) &&
           touch(f->y, reach * sqrtf(yy), photo->height_px, f->rows);
}

static const struct flat *by_depth_of;
static int by_depth(const void *a, const void *b) {
    uint32_t i = *(const uint32_t *)a, j = *(const uint32_t *)b;
    float x = by_depth_of[i].at.z, y = by_depth_of[j].at.z;
    return x != y ? (x < y ? -1 : 1) : (i > j) - (i < j);
}

static void project_all(struct training *t, const struct photo *photo) {
    t->shown = 0;
    for (uint32_t i = 0; i < t->model.splats.count; i++)
        if (project(photo, t->splats[i].number, &t->flats[i])) t->nearest[t->shown++] = i;
    by_depth_of = t->flats;
    qsort(t->nearest, t->shown, sizeof *t->nearest, by_depth);
}

// ---- A square -------------------------------------------------------------------------------------------------------

static struct {
    float x[PIXELS], y[PIXELS], left[PIXELS], rest[PIXELS], weight[PIXELS];
    float colour[3][PIXELS], target[3][PIXELS], slope[3][PIXELS];
} square;

// Returns exp(x) for x <= 0, with a relative error below 2e-4.
static inline float exp_below(float x) {
    float power = fmaxf(x * 1.442695041f, -126), whole = floorf(power), part = power - whole;
    union {
        int32_t bits;
        float value;
    } two = {.bits = ((int32_t)whole + 127) << 23};
    return two.value * (1 + part * (0.69315147f + part * (0.24022651f + part * (0.05550411f + part * 0.01094953f))));
}

static void begin_square(const struct vw_pixel *pixels) {
    for (int p = 0; p < PIXELS; p++) {
        square.x[p] = pixels[p].x_px;
        square.y[p] = pixels[p].y_px;
        square.left[p] = 1;
        square.weight[p] = pixels[p].weight;
        square.target[0][p] = pixels[p].rgba.x;
        square.target[1][p] = pixels[p].rgba.y;
        square.target[2][p] = pixels[p].rgba.z;
        for (int c = 0; c < 3; c++) square.colour[c][p] = 0;
    }
}

// Lists the splats that touch the square, nearest first.
static uint32_t list_pairs(struct training *t, const struct vw_pixel *pixels) {
    int column = (int)pixels[0].x_px / SIDE, row = (int)pixels[0].y_px / SIDE;
    uint32_t count = 0;
    for (uint32_t i = 0; i < t->shown; i++) {
        const struct flat *f = &t->flats[t->nearest[i]];
        if (column >= f->columns[0] && column <= f->columns[1] && row >= f->rows[0] && row <= f->rows[1])
            t->pairs[count++] = t->nearest[i];
    }
    return count;
}

// Blends front to back; returns how many splats until no light was left.
static uint32_t blend(const struct training *t, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const struct flat *f = &t->flats[t->pairs[i]];
        float most = 0;
        for (int p = 0; p < PIXELS; p++) {
            float x = square.x[p] - f->x, y = square.y[p] - f->y;
            float exponent = 0.5f * (f->conic[0] * x * x + f->conic[2] * y * y) + f->conic[1] * x * y;
            float alpha = fminf(f->opacity * exp_below(-exponent), ALPHA_MOST), left = square.left[p];
            alpha = alpha < ALPHA_LEAST || left < LEFT_LEAST ? 0 : alpha;
            float weight = left * alpha;
            for (int c = 0; c < 3; c++) square.colour[c][p] += weight * f->colour[c];
            square.left[p] = left - weight;
            most = fmaxf(most, square.left[p]);
        }
        if (most < LEFT_LEAST) return i + 1;
    }
    return count;
}

// Returns the summed squared error, and leaves slopes.
static double compare(void) {
    double sum = 0;
    for (int p = 0; p < PIXELS; p++) {
        square.rest[p] = 0;
        square.left[p] = 1;
        for (int c = 0; c < 3; c++) {
            float error = (square.colour[c][p] - square.target[c][p]) * square.weight[p];
            sum += error * error;
            square.slope[c][p] = error * (2.0f / 3);
            square.rest[p] += square.slope[c][p] * square.colour[c][p];
        }
    }
    return sum;
}

// Goes through the pairs again, front to back: what is still to come shrinks from the whole pixel's colour.
static void blend_back(const struct training *t, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const struct flat *f = &t->flats[t->pairs[i]];
        float q_sum = 0, qx = 0, qy = 0, qxx = 0, qxy = 0, qyy = 0, red = 0, green = 0, blue = 0;
        for (int p = 0; p < PIXELS; p++) {
            float x = square.x[p] - f->x, y = square.y[p] - f->y, before = square.left[p];
            float exponent = 0.5f * (f->conic[0] * x * x + f->conic[2] * y * y) + f->conic[1] * x * y;
            float raw = f->opacity * exp_below(-exponent), alpha = fminf(raw, ALPHA_MOST);
            alpha = alpha < ALPHA_LEAST || before < LEFT_LEAST ? 0 : alpha;
            float weight = before * alpha;
            float slope = square.slope[0][p] * f->colour[0] + square.slope[1][p] * f->colour[1] +
                          square.slope[2][p] * f->colour[2];
            square.rest[p] -= weight * slope;
            square.left[p] = before - weight;
            float q = raw * (before * slope - square.rest[p] / (1 - alpha));
            q = alpha > 0 && raw < ALPHA_MOST ? q : 0;
            q_sum += q, qx += q * x, qy += q * y;
            qxx += q * x * x, qxy += q * x * y, qyy += q * y * y;
            red += weight * square.slope[0][p];
            green += weight * square.slope[1][p];
            blue += weight * square.slope[2][p];
        }
        float *sums = t->sums[t->pairs[i]];
        const float own[SUMS] = {q_sum, qx, qy, qxx, qxy, qyy, red, green, blue};
        for (int k = 0; k < SUMS; k++) sums[k] += own[k];
    }
}

// ---- Back to the splats ---------------------------------------------------------------------------------------------

static void turn_back(const float *q, float d[3][3], float *gradient) { // d: by the columns
    float unit[4], m[3][3], length = turn_columns(q, unit, m), w = unit[0], x = unit[1], y = unit[2], z = unit[3];
    const float along[4] = {
        2 * (x * (d[1][2] - d[2][1]) + y * (d[2][0] - d[0][2]) + z * (d[0][1] - d[1][0])),
        2 * (-2 * x * (d[1][1] + d[2][2]) + y * (d[0][1] + d[1][0]) + z * (d[0][2] + d[2][0]) +
             w * (d[1][2] - d[2][1])),
        2 * (x * (d[0][1] + d[1][0]) - 2 * y * (d[0][0] + d[2][2]) + z * (d[1][2] + d[2][1]) + w * (d[2][0] - d[0][2])),
        2 * (x * (d[0][2] + d[2][0]) + y * (d[1][2] + d[2][1]) - 2 * z * (d[0][0] + d[1][1]) +
             w * (d[0][1] - d[1][0]))};
    float outward = unit[0] * along[0] + unit[1] * along[1] + unit[2] * along[2] + unit[3] * along[3];
    for (int k = 0; k < 4; k++) gradient[k] = (along[k] - unit[k] * outward) / length;
}

// Writes the gradient of the colour's coefficients, and returns that of the direction.
static struct vector colour_back(const float *number, const struct flat *f, const float *d_colour, float *gradient) {
    struct vector d = f->direction, back = {0, 0, 0};
    const float basis[COEFFICIENTS] = {0.28209479f, -0.48860251f * d.y, 0.48860251f * d.z, -0.48860251f * d.x};
    float along[COEFFICIENTS] = {0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < COEFFICIENTS; k++) {
            float own = f->colour[c] > 0 ? d_colour[c] : 0;
            gradient[HARMONICS + 3 * k + c] = basis[k] * own;
            along[k] += own * number[HARMONICS + 3 * k + c];
        }
    back = (struct vector){-0.48860251f * along[3], -0.48860251f * along[1], 0.48860251f * along[2]};
    return times(1 / f->distance, add(back, -dot(back, d), d));
}

static void project_back(const struct photo *photo, const float *number, const struct flat *f, const float *sums,
                         float *gradient) {
    float a = f->conic[0], b = f->conic[1], c = f->conic[2], focal[2] = {photo->camera.right.w, photo->camera.up.w};
    float centre[2] = {a * sums[QX] + b * sums[QY], b * sums[QX] + c * sums[QY]};
    float xx = a * sums[QXX] + b * sums[QXY], xy = a * sums[QXY] + b * sums[QYY], yx = b * sums[QXX] + c * sums[QXY],
          yy = b * sums[QXY] + c * sums[QYY];
    float covariance[3] = {xx * a + xy * b, xx * b + xy * c, yx * b + yy * c}; // twice the gradient by it
    struct vector d_v[2] = {add(times(covariance[0], f->v[0]), covariance[1], f->v[1]),
                            add(times(covariance[1], f->v[0]), covariance[2], f->v[1])};
    struct vector d_u[2] = {{0, 0, 0}, {0, 0, 0}};
    float d_turn[3][3];
    for (int k = 0; k < 3; k++) {
        float own[2] = {(&d_v[0].x)[k], (&d_v[1].x)[k]};
        struct vector d_column = add(times(own[0], f->u[0]), own[1], f->u[1]);
        for (int row = 0; row < 2; row++) d_u[row] = add(d_u[row], own[row] * f->scale[k], of(f->turn[k]));
        gradient[SCALE + k] = f->scale[k] * dot(of(f->turn[k]), d_column);
        for (int i = 0; i < 3; i++) d_turn[k][i] = (&d_column.x)[i] * f->scale[k];
    }
    turn_back(number + TURN, d_turn, gradient + TURN);
    float nearness = 1 / f->at.z, d_slope[2];
    for (int i = 0; i < 2; i++)
        d_slope[i] = (f->within[i] ? -nearness * focal[i] * dot(d_u[i], photo->ahead) : 0) + focal[i] * centre[i];
    float depth =
        -(d_slope[0] * f->at.x + d_slope[1] * f->at.y) * nearness - dot(d_u[0], f->u[0]) - dot(d_u[1], f->u[1]);
    struct vector d_mean = colour_back(number, f, sums + RED, gradient);
    d_mean = add(d_mean, nearness * d_slope[0], photo->right);
    d_mean = add(add(d_mean, nearness * d_slope[1], photo->down), nearness * depth, photo->ahead);
    memcpy(gradient + MEAN, &d_mean, sizeof d_mean);
    gradient[LOGIT] = sums[Q] * (1 - f->opacity);
}

// Moves a splat by lazy Adam without momentum.
static void update(struct splat *splat, const float *gradient, const float *rates) {
    splat->visits++;
    float correction = 1 / (1 - powf(0.999f, (float)splat->visits));
    for (int k = 0; k < NUMBERS; k++) {
        splat->square[k] = 0.999f * splat->square[k] + 0.001f * gradient[k] * gradient[k];
        splat->number[k] -= rates[k] * gradient[k] / (sqrtf(splat->square[k] * correction) + 1e-15f);
    }
}

// ---- The training ---------------------------------------------------------------------------------------------------

static void list_rates(const struct training *t, uint32_t step, uint32_t steps, float rates[NUMBERS]) {
    double rate = t->config.learning_rate, decay = pow(t->config.learning_rate_decay, (double)step / steps);
    for (int k = 0; k < NUMBERS; k++)
        rates[k] = (float)(rate * (k < LOGIT           ? 1.6e-4 * t->model.splats.extent_edges * decay
                                   : k == LOGIT        ? 2.5e-2
                                   : k < TURN          ? 5e-3
                                   : k < HARMONICS     ? 1e-3
                                   : k < HARMONICS + 3 ? 2.5e-3
                                                       : 1.25e-4));
}

static void take_step(struct training *t, uint32_t step, uint32_t steps) {
    uint32_t view = vw_photo_order_view_of_step(&t->order, step);
    const struct vw_pixel_draw draw = {.seed = t->config.seed, .step = step, .masks = true};
    struct vw_photo_tile squares[SQUARES];
    uint32_t count = vw_pixels_draw_squares(t->scene, view, &draw, SIDE, SIDE, SQUARES * PIXELS, squares);
    const struct photo photo = photo_of(t, view);
    float rates[NUMBERS];
    project_all(t, &photo);
    memset(t->sums, 0, t->model.splats.count * sizeof *t->sums);
    for (uint32_t i = 0; i < count; i++) {
        vw_pixels_take_tile(t->scene, view, true, squares[i], SIDE, t->pixels);
        begin_square(t->pixels);
        uint32_t drawn = blend(t, list_pairs(t, t->pixels));
        compare();
        blend_back(t, drawn);
    }
    list_rates(t, step, steps, rates);
    for (uint32_t i = 0; i < t->shown; i++) {
        uint32_t splat = t->nearest[i];
        const float *sums = t->sums[splat];
        float gradient[NUMBERS];
        if (sums[Q] == 0 && sums[RED] == 0 && sums[RED + 1] == 0 && sums[RED + 2] == 0) continue;
        project_back(&photo, t->splats[splat].number, &t->flats[splat], sums, gradient);
        update(&t->splats[splat], gradient, rates);
    }
}

static double validate_view(struct training *t, uint32_t view) {
    const struct photo photo = photo_of(t, view);
    const struct vw_image *image = &t->scene->views[view].image;
    double sum = 0;
    project_all(t, &photo);
    for (uint32_t top = 0; top < image->height_px; top += SIDE)
        for (uint32_t left = 0; left < image->width_px; left += SIDE) {
            for (uint32_t p = 0; p < PIXELS; p++) {
                uint32_t x = left + p % SIDE, y = top + p / SIDE;
                bool inside = x < image->width_px && y < image->height_px;
                t->pixels[p] = inside ? vw_pixels_at(t->scene, view, true, x, y)
                                      : (struct vw_pixel){.x_px = (float)x + 0.5f, .y_px = (float)y + 0.5f};
            }
            begin_square(t->pixels);
            blend(t, list_pairs(t, t->pixels));
            sum += compare();
        }
    return -10 * log10(sum / (3.0 * image->width_px * image->height_px));
}

static double validate(struct training *t) {
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t view = 0; view < t->scene->view_count; view++) {
        if (t->scene->views[view].split != VW_SPLIT_VAL) continue;
        sum += validate_view(t, view);
        count++;
    }
    return sum / count;
}

// ---- The program ----------------------------------------------------------------------------------------------------

// Takes the splats from the columns of params.
static enum vw_status begin_splats(struct training *t) {
    uint32_t count = t->model.splats.count;
    float *params = vw_allocate(t->model.param_bytes, 1);
    enum vw_status status = params ? vw_model_initialise(&t->model, t->scene, t->config.seed, params) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++) {
        float *number = t->splats[i].number;
        for (uint32_t column = 0; column < VW_SPLAT_COLUMNS(1); column++) {
            const float *own = params + 4 * ((size_t)column * count + i);
            if (column == SPLAT_MEAN) memcpy(number + MEAN, own, 4 * sizeof *own);
            else if (column == SPLAT_SCALE) memcpy(number + SCALE, own, 3 * sizeof *own);
            else if (column == SPLAT_TURN) memcpy(number + TURN, own, 4 * sizeof *own);
            else memcpy(number + HARMONICS + 3 * (column - SPLAT_HARMONICS), own, 3 * sizeof *own);
        }
    }
    free(params);
    return status;
}

static enum vw_status open_training(const char *path, uint32_t downscale, uint32_t splats, struct training *t) {
    const struct vw_scene_params params = {.path = path, .downscale = downscale};
    const struct vw_gpu_limits limits = {.storage_binding_bytes = UINT32_MAX, .buffer_bytes = UINT32_MAX};
    const struct vw_device_choices choices = {0};
    t->config = vw_config_of_field(VW_FIELD_SPLATS);
    t->config.splats = splats;
    snprintf(t->config.effects, sizeof t->config.effects, "none");
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    vw_effects_list(effects, &effect_count);
    enum vw_status status = vw_effects_choose(t->config.effects, effects, effect_count);
    if (!status) status = vw_scene_open(&params, &t->scene);
    if (!status) status = vw_scene_decode_all(t->scene);
    if (!status) status = vw_model_create(&t->config, t->scene, NULL, 0, effects, &choices, &limits, &t->model);
    if (!status) status = vw_photo_order_create(t->scene, NULL, 0, &t->config, &t->order);
    if (status) return status;
    uint32_t count = t->model.splats.count;
    t->splats = vw_allocate(count, sizeof *t->splats);
    t->flats = vw_allocate(count, sizeof *t->flats);
    t->sums = vw_allocate(count, sizeof *t->sums);
    t->nearest = vw_allocate(count, sizeof *t->nearest);
    t->pairs = vw_allocate(count, sizeof *t->pairs);
    t->pixels = vw_allocate(SQUARES * PIXELS, sizeof *t->pixels);
    bool made = t->splats && t->flats && t->sums && t->nearest && t->pairs && t->pixels;
    return made ? begin_splats(t) : VW_ERROR_MEMORY;
}

static void close_training(struct training *t) {
    free(t->splats);
    free(t->flats);
    free(t->sums);
    free(t->nearest);
    free(t->pairs);
    free(t->pixels);
    vw_photo_order_destroy(&t->order);
    vw_scene_close(&t->scene);
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static enum vw_status run(struct training *t, uint32_t steps) {
    double *ms = vw_allocate(steps, sizeof *ms);
    if (!ms) return VW_ERROR_MEMORY;
    for (uint32_t step = 1; step <= steps; step++) {
        double start_s = vw_now_s();
        take_step(t, step, steps);
        ms[step - 1] = 1e3 * (vw_now_s() - start_s);
    }
    qsort(ms, steps, sizeof *ms, ascending);
    printf("train_ms %.3f steps %u splats %u val_psnr %.3f\n", ms[steps / 2], steps, t->model.splats.count,
           validate(t));
    free(ms);
    return VW_OK;
}

int main(int argc, char **argv) {
    struct training t = {0};
    if (argc < 4) return fputs("usage: native_splats SCENE DOWNSCALE STEPS [SPLATS]\n", stderr), 2;
    uint32_t steps = (uint32_t)strtoul(argv[3], NULL, 10), splats = argc > 4 ? (uint32_t)strtoul(argv[4], NULL, 10) : 0;
    enum vw_status status = open_training(argv[1], (uint32_t)strtoul(argv[2], NULL, 10), splats, &t);
    if (!status) status = run(&t, steps ? steps : 1);
    close_training(&t);
    if (status) fprintf(stderr, "native_splats: %s\n", vw_error_message());
    return vw_exit_code(status);
}
