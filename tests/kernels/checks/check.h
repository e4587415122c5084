// Functions that the registry of passes (test_passes.c) runs: one per pass, which feeds it on a bench with inputs of
// one kind and compares its results with the reference. A new pass gets a function here and a line there.
#ifndef VIEWWORTH_TESTS_KERNELS_CHECK_H
#define VIEWWORTH_TESTS_KERNELS_CHECK_H

#include <math.h>

#include "gpu/compute.h"
#include "reference/reference.h"
#include "reference/step_bench.h"

// ---- Inputs ---------------------------------------------------------------------------------------------------------

enum input_kind {
    INPUT_ORDINARY,      // as training has them
    INPUT_LARGE,         // 2^0 to 2^10
    INPUT_TINY,          // 2^-60 to 2^-20
    INPUT_ZERO,          // 0
    INPUT_NEGATIVE_ZERO, // -0
    INPUT_DENORMAL,      // below 2^-126: a device may take them for 0, and what comes out as well
    INPUT_SATURATING,    // 2^20 to 2^40: beyond what exp, clamps and fixed point hold
    INPUT_KINDS,
};
extern const char *const input_kind_names[INPUT_KINDS];
float input_draw(enum input_kind kind, struct test_random *random);
void input_fill(enum input_kind kind, struct test_random *random, float *values, size_t count);

// ---- Tolerances -----------------------------------------------------------------------------------------------------

#define FLOAT_ROUNDING 0x1p-24 // half a unit in the last place, relative
#define FLOAT_LEAST 0x1p-126   // smaller floats may be flushed to 0

// Returns how far a bfloat may be off whose float is off by up to `error`.
static inline double rounded_error(double expected, double error) {
    return error + BFLOAT_ROUNDING * (fabs(expected) + error) + FLOAT_LEAST;
}
// Finds how far matrix * in (transposed: in * matrix) may be off on the device, when each in[i] is off by up to
// in_error[i].
void product_errors(const struct reference_matrix *matrix, bool transposed, const double *in, const double *in_error,
                    double *errors);
// Checks a row of bfloats.
void check_row(const struct step_bench *bench, const float *rows, const char *what, uint32_t row, uint32_t sample,
               uint32_t count, const double *expected, const double *errors);
// Fails unless low <= device <= high.
void check_between(const char *where, const char *what, uint64_t index, double device, double low, double high);

// ---- Passes ---------------------------------------------------------------------------------------------------------

typedef void pass_check(struct step_bench *bench, enum input_kind kind);
pass_check check_fit_photo, check_fit_views;
pass_check check_generate_rays, check_forward_field, check_composite_rays, check_reduce_views, check_backward_rays,
    check_backward_field, check_gradient_weights, check_reduce_weights, check_scatter_grid, check_reduce_loss,
    check_update_grid, check_update_weights, check_trace_recipe;

// ---- Their parts, for the tests of what is special about a pass -----------------------------------------------------

// Puts a camera for generate_rays at `position` that looks at `target`, both in box coordinates.
void rays_look(struct vw_view *view, const struct vw_box *box, const double position[3], const double target[3]);
// Returns the box whose coordinates the rays of a bench are in.
struct vw_box rays_box(const struct step_bench *bench);
// Makes the rays of bench->pixels with the cameras of bench->scene.
struct vw_ray *rays_make(struct step_bench *bench);
// Makes the same rays and checks them against the reference, with `scale` times the usual tolerances. Returns how many
// hit the box.
uint32_t rays_check(struct step_bench *bench, double scale);

// Makes a chunk's activation rows for scatter_grid, with random positions and gradients of the kind.
float *scatter_rows(const struct step_bench *bench, enum input_kind kind);
// Adds the rows' gradients up from 0; `flags` are those it set.
void scatter_run(struct step_bench *bench, float *rows, struct vw_step_state *flags);
// Holds the words of the grid's gradient and the count of clamped contributions against the reference.
void scatter_check(const struct step_bench *bench, const float *rows, const uint64_t *words, uint32_t clamped);

// Runs gradient_weights and reduce_weights in turn, from a chunk's rows to d_weights.
void weight_gradients_run(struct step_bench *bench, float *rows);

// update_grid: all that the optimiser may change of the grid.
struct grid_state {
    float *grid, *moment1, *moment2; // per feature; moment1 NULL without momentum. The other params follow the grid
    uint32_t *visits;                // per pair
};
struct grid_state grid_read(struct step_bench *bench);
// Writes `quanta`, the integer gradient per feature.
void grid_write_gradient(struct step_bench *bench, const int64_t *quanta);
void grid_update(struct step_bench *bench, uint32_t number);

// reduce_views on views of its own, on any device.
enum { REDUCED_VIEWS = 5, REDUCED_RAYS = 3000 };
extern const struct vw_ray_range reduced_ranges[REDUCED_VIEWS];
struct view_reduction {
    struct vw_buffer *rays, *colours, *views, *scalars, *fits;
    struct vw_pass *pass, *fit_pass;
    struct vw_submission *submission;
    struct vw_ray *ray_data; // targets and weights
    vw_float4 *colour_data;  // rendered colours
};
// Makes the pass reduce_views and its buffers. `fitted`: it applies the fits, which are 0 until fit_pass or a test
// writes them.
struct view_reduction *reduction_open(struct vw_gpu *gpu, bool fitted);
// Draws random targets, and colours that are off by errors of the kind.
void reduction_fill(struct view_reduction *reduction, enum input_kind kind, uint64_t seed);
// Runs reduce_views for the sums of each view: squared error high, low, absolute error high, low.
void reduction_run(struct view_reduction *reduction, vw_float4 sums[REDUCED_VIEWS]);
struct reference_view_error reduction_reference(const struct view_reduction *reduction, uint32_t view);
void reduction_check(const char *where, struct view_reduction *reduction, vw_float4 sums[REDUCED_VIEWS]);

#endif
