#include "train/validation/measure_views.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/evaluator.h"

enum { NUMBERS = 4 * CODE4, STEPS = 4, TRIES = 3 };
static const double DIFFERENCE = 1.0 / 64.0; // in a code's numbers; renders have 24 bits

struct fitting {
    struct vw_radiance_field *field;
    struct vw_evaluator evaluator;
    const struct vw_pixel *pixels;
    uint32_t count;
    vw_float4 *colours, *targets;
    float *code_weights;   // [unit][NUMBERS]
    const float *original; // borrowed: the columns that a code shifts
    float *shifted;
    double *rendered, *jacobian; // per value; [NUMBERS][value]
};

// ---- The constant input's weights -----------------------------------------------------------------------------------

// Returns the range from the first to the last column that a code shifts.
static struct vw_param_range shifted_range(const struct vw_radiance_field *field) {
    const struct vw_specialization *s = &field->model->specialization;
    return (struct vw_param_range){.offset_bytes = field->model->weights.offset_bytes + 16 * (uint64_t)s->shift_column,
                                   .size_bytes = 16 * ((uint64_t)s->shift_stride * (s->width4 - 1) + 1)};
}

// Computes what mix_code adds in training.
static enum vw_status shift(struct fitting *fitting, const double *code) {
    const struct vw_param_range range = shifted_range(fitting->field);
    const struct vw_specialization *s = &fitting->field->model->specialization;
    memcpy(fitting->shifted, fitting->original, range.size_bytes);
    for (uint32_t unit = 0; unit < 4 * s->width4; unit++) {
        double sum = 0;
        for (uint32_t k = 0; k < NUMBERS; k++) sum += fitting->code_weights[(size_t)NUMBERS * unit + k] * code[k];
        fitting->shifted[4 * (size_t)s->shift_stride * (unit / 4) + unit % 4] += (float)sum;
    }
    return vw_buffer_write(fitting->field->params, range.offset_bytes, fitting->shifted, range.size_bytes);
}

// ---- Objective ------------------------------------------------------------------------------------------------------

// Renders with `code`, 0 at pixels that weigh nothing.
static enum vw_status render(struct fitting *fitting, const double *code, double *rendered) {
    enum vw_status status = shift(fitting, code);
    if (!status) status = vw_evaluator_render(&fitting->evaluator, fitting->pixels, fitting->count, fitting->colours);
    for (uint32_t i = 0; i < fitting->count && !status; i++) {
        double counts = fitting->targets[i].w != 0.0f;
        rendered[3 * i] = counts * fitting->colours[i].x;
        rendered[3 * i + 1] = counts * fitting->colours[i].y;
        rendered[3 * i + 2] = counts * fitting->colours[i].z;
    }
    return status;
}

static double missing_at(const struct fitting *fitting, const double *rendered, uint32_t value) {
    const vw_float4 *target = &fitting->targets[value / 3];
    double wanted = value % 3 == 0 ? target->x : value % 3 == 1 ? target->y : target->z;
    return target->w == 0.0f ? 0.0 : wanted - rendered[value];
}

// Returns half of the mean squared error plus the ridge, whose gradients update_code adds.
static double objective(const struct fitting *fitting, const double *rendered, const double *code) {
    double squares = 0, ridge = 0;
    for (uint32_t i = 0; i < 3 * fitting->count; i++) squares += pow(missing_at(fitting, rendered, i), 2);
    for (uint32_t k = 0; k < NUMBERS; k++) ridge += code[k] * code[k];
    return 0.5 * (squares / (3.0 * fitting->count) + PHOTO_RIDGE * ridge);
}

// ---- One step -------------------------------------------------------------------------------------------------------

static enum vw_status differentiate(struct fitting *fitting, double *code) {
    uint32_t values = 3 * fitting->count;
    enum vw_status status = VW_OK;
    for (uint32_t k = 0; k < NUMBERS && !status; k++) {
        double *column = fitting->jacobian + (size_t)values * k, before = code[k];
        code[k] += DIFFERENCE;
        status = render(fitting, code, column);
        code[k] = before;
        for (uint32_t i = 0; i < values; i++) column[i] = (column[i] - fitting->rendered[i]) / DIFFERENCE;
    }
    return status;
}

// Solves a symmetric positive definite system by elimination; the solution replaces `right`.
static void solve(double matrix[NUMBERS][NUMBERS], double right[NUMBERS]) {
    for (int i = 0; i < NUMBERS; i++)
        for (int j = i + 1; j < NUMBERS; j++) {
            double factor = matrix[j][i] / matrix[i][i];
            for (int k = i; k < NUMBERS; k++) matrix[j][k] -= factor * matrix[i][k];
            right[j] -= factor * right[i];
        }
    for (int i = NUMBERS; i-- > 0;) {
        for (int k = i + 1; k < NUMBERS; k++) right[i] -= matrix[i][k] * right[k];
        right[i] /= matrix[i][i];
    }
}

static void propose(const struct fitting *fitting, const double *code, double damping, double moved[NUMBERS]) {
    uint32_t values = 3 * fitting->count;
    double matrix[NUMBERS][NUMBERS];
    for (int i = 0; i < NUMBERS; i++) {
        const double *left = fitting->jacobian + (size_t)values * i;
        moved[i] = -PHOTO_RIDGE * code[i];
        for (uint32_t v = 0; v < values; v++) moved[i] += left[v] * missing_at(fitting, fitting->rendered, v) / values;
        for (int j = 0; j <= i; j++) {
            double sum = i == j ? PHOTO_RIDGE + damping : 0;
            for (uint32_t v = 0; v < values; v++) sum += left[v] * fitting->jacobian[(size_t)values * j + v] / values;
            matrix[i][j] = matrix[j][i] = sum;
        }
    }
    solve(matrix, moved);
    for (int i = 0; i < NUMBERS; i++) moved[i] += code[i];
}

// Moves the code where that lowers the objective, by ever shorter steps; *lower tells.
static enum vw_status take_step(struct fitting *fitting, double *code, double *rendered, bool *lower) {
    double before = objective(fitting, fitting->rendered, code), moved[NUMBERS], damping = 0;
    enum vw_status status = differentiate(fitting, code);
    *lower = false;
    for (int i = 0; i < TRIES && !status && !*lower; i++) {
        propose(fitting, code, damping, moved);
        damping = damping > 0 ? 10 * damping : 10 * PHOTO_RIDGE;
        status = render(fitting, moved, rendered);
        *lower = !status && objective(fitting, rendered, moved) < before;
    }
    if (!*lower) return status;
    memcpy(code, moved, sizeof moved);
    memcpy(fitting->rendered, rendered, 3 * fitting->count * sizeof *rendered);
    return status;
}

// ---- All of it ------------------------------------------------------------------------------------------------------

static enum vw_status open_fitting(struct fitting *fitting) {
    const struct vw_model *model = fitting->field->model;
    size_t values = 3 * (size_t)fitting->count;
    fitting->colours = vw_allocate(fitting->count, sizeof *fitting->colours);
    fitting->targets = vw_allocate(fitting->count, sizeof *fitting->targets);
    fitting->code_weights = vw_allocate(1, model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes);
    fitting->shifted = vw_allocate(1, shifted_range(fitting->field).size_bytes);
    fitting->rendered = vw_allocate(values, sizeof *fitting->rendered);
    fitting->jacobian = vw_allocate(NUMBERS * values, sizeof *fitting->jacobian);
    if (!fitting->colours || !fitting->targets || !fitting->code_weights || !fitting->shifted || !fitting->rendered ||
        !fitting->jacobian)
        return VW_ERROR_MEMORY;
    enum vw_status status = vw_evaluator_create(fitting->field, fitting->count, false, &fitting->evaluator);
    if (!status)
        status = vw_buffer_read(fitting->field->params, model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes,
                                fitting->code_weights, model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes);
    if (!status) status = vw_evaluator_set_pixels(&fitting->evaluator, fitting->pixels, fitting->count);
    for (uint32_t i = 0; i < fitting->count && !status; i++) {
        struct vw_ray ray;
        status = vw_buffer_read(fitting->evaluator.rays, i * sizeof ray, &ray, sizeof ray);
        fitting->targets[i] = ray.target_weight;
    }
    return status;
}

static void close_fitting(struct fitting *fitting) {
    vw_evaluator_destroy(&fitting->evaluator);
    free(fitting->colours);
    free(fitting->targets);
    free(fitting->code_weights);
    free(fitting->shifted);
    free(fitting->rendered);
    free(fitting->jacobian);
}

static enum vw_status run_steps(struct fitting *fitting) {
    double *rendered = vw_allocate(3 * (size_t)fitting->count, sizeof *rendered), code[NUMBERS] = {0};
    bool lower = true;
    enum vw_status status = rendered ? render(fitting, code, fitting->rendered) : VW_ERROR_MEMORY;
    for (int i = 0; i < STEPS && lower && !status; i++) status = take_step(fitting, code, rendered, &lower);
    free(rendered);
    return !status ? shift(fitting, code) : status;
}

enum vw_status vw_code_fit_apply(struct vw_radiance_field *field, const struct vw_pixel *pixels, uint32_t count,
                                 struct vw_code_fit *fit) {
    *fit = (struct vw_code_fit){0};
    if (!field->model->ranges[VW_SLOT_CODES].size_bytes || !count) return VW_OK;
    const struct vw_param_range range = shifted_range(field);
    float *weights = vw_allocate(1, range.size_bytes);
    enum vw_status status =
        weights ? vw_buffer_read(field->params, range.offset_bytes, weights, range.size_bytes) : VW_ERROR_MEMORY;
    if (status) {
        free(weights);
        return status;
    }
    struct fitting fitting = {.field = field, .pixels = pixels, .count = count, .original = weights};
    fit->weights = weights;
    status = open_fitting(&fitting);
    if (!status) status = run_steps(&fitting);
    close_fitting(&fitting);
    if (status) (void)vw_code_fit_undo(field, fit); // the first failure is told
    return status;
}

enum vw_status vw_code_fit_undo(struct vw_radiance_field *field, struct vw_code_fit *fit) {
    const struct vw_param_range range = shifted_range(field);
    enum vw_status status =
        fit->weights ? vw_buffer_write(field->params, range.offset_bytes, fit->weights, range.size_bytes) : VW_OK;
    free(fit->weights);
    *fit = (struct vw_code_fit){0};
    return status;
}
