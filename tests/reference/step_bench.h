// The real passes of one training step, set up on a small scene for a table of cases, and read back to be held against
// the reference. Every function stops the test, naming case and seed, when it cannot do its work; what it returns is
// the test's (cmocka_test.h).
#ifndef VIEWWORTH_TESTS_REFERENCE_STEP_BENCH_H
#define VIEWWORTH_TESTS_REFERENCE_STEP_BENCH_H

#include "gpu/compute.h"
#include "reference/reference.h"
#include "support/gpu_fixture.h"
#include "support/synthetic_scene.h"
#include "train/effects/appearance_encoder.h"
#include "train/effects/effects.h"
#include "train/evaluator.h"
#include "train/photo_order.h"
#include "train/renderers/volume/volume.h"

// Zero means the default in brackets.
struct step_case {
    const char *name;
    uint64_t seed;
    uint32_t rays, samples;          // [20], [32]
    uint32_t importance_samples;     // [none]
    bool own_coarse;                 // --coarse-network own
    uint32_t levels, features;       // [8], [2]
    uint32_t log2_table;             // [14]
    bool one_entry;                  // log2_table is 0: every sample falls into the same entry
    uint32_t base_resolution;        // [8]
    uint32_t width;                  // [32]
    enum vw_field field;             // [VW_FIELD_HASH]
    uint32_t mlp_depth, frequencies; // for VW_FIELD_MLP [8], [10]
    enum vw_loss loss;
    double huber_length; // 0: the default
    enum vw_optimizer optimizer;
    double learning_rate;                           // [0.003]
    double beta1, beta2;                            // [0], [0.99]
    const char *effects;                            // [none] as --effects lists them
    const char *another_effect;                     // [none] what a program adds to all of its cases
    bool random_background;                         // the form of the effect background
    double beta_min;                                // for transient [0.1]
    double consistency_weight;                      // with appearance_encoder [0]
    bool wide;                                      // 64-bit gradient words
    enum vw_scatter_form scatter;                   // [SCATTER_ATOMICS], whatever the device
    bool as_on_gpus;                                // the other choices as on GPUs (src/train/device_choices.c)
    uint32_t slice_samples, slice_parts, ray_lanes; // [by these choices]
    uint32_t distortion;                            // the lenses that generate_rays undoes [by the scene]
    float grid_scale;                               // the grid is uniform in +-this [0.5]
    float weight_scale; // the networks' initial weights times this [1]; the sky's coefficients are uniform in +-this
    uint32_t chunk_samples; // [the whole step in one chunk]
};

struct step_bench {
    char where[192];    // the case and its seed, for messages
    struct vw_gpu *gpu; // borrowed
    struct vw_config config;
    struct vw_scene *scene;
    struct vw_model model;
    struct vw_radiance_field field;
    struct vw_photo_order photo_order; // over both photos
    struct vw_step_passes step;
    struct vw_volume_model *layout; // the model's, and the step's part, of the renderer volume
    struct vw_volume_step *volume;
    struct vw_buffer *pixel_buffer, *scalars;
    struct vw_submission *submission;
    struct vw_evaluator evaluator; // after step_bench_evaluator
    struct vw_pixel *pixels;       // config.rays of them, of view 0 and 1
    uint32_t view;                 // view of the first pixel, whose photo the step takes for its own
    float *params;                 // values of the params block as it was set; its grid may be halves
    uint32_t padded_samples;       // the step's
};

// One case per thing that may break on its own: every sample count kind, width, features, table, loss and effect; see
// step_cases.c.
extern const struct step_case step_cases[];
extern const uint32_t step_case_count;

// Opens a bench on test_gpu(), or on a device of its own with limits clamped; what validation has to say of that one
// fails the test when the bench is released.
struct step_bench *step_bench_open(const struct step_case *setup);
struct step_bench *step_bench_open_clamped(const struct step_case *setup, const struct vw_gpu_limits *clamp);
// Returns the evaluator over the bench's field for its padded rays, made at the first call.
struct vw_evaluator *step_bench_evaluator(struct step_bench *bench);
struct vw_evaluator *step_bench_evaluate(struct step_bench *bench);

void step_bench_write_params(struct step_bench *bench);
// Runs step `number` up to the loss and the gradients, without the optimiser; the grid's gradient keeps adding up.
void step_bench_gradients(struct step_bench *bench, uint64_t number);
void step_bench_step(struct step_bench *bench, uint64_t number);
// Runs it where params are not finite: it must be flagged, and change none of them.
void step_bench_check_skipped(struct step_bench *bench, uint64_t number);
// Checks that chunks of so many samples change no bit of the params after step `number`.
void step_bench_check_chunks(const struct step_case *setup, uint32_t chunk_samples, uint64_t number);
void step_bench_dispatch(struct step_bench *bench, const struct vw_pass *pass, const void *push, size_t push_bytes,
                         uint64_t invocations);
// Returns the invocations of a pass in which the model's lanes share a ray.
uint64_t step_bench_lanes(const struct step_bench *bench, uint32_t rays);
// Returns how many passes have met a param that would not be finite, since the flags were cleared last; clears them.
uint32_t step_bench_take_overflows(struct step_bench *bench);
// Returns the push block of a step in one chunk.
struct vw_push_samples step_bench_push(const struct step_bench *bench, uint64_t number);

// Returns the place of every sample of a chunk from the buffer that lists them; NULL where none does.
double *step_bench_sample_places(struct vw_buffer *places);
// Makes the reference of the step that the device has just taken, from its rays and with its slots.
struct reference_step *step_bench_reference(struct step_bench *bench);

// ---- Activation rows ------------------------------------------------------------------------------------------------

// Numbers of the first rows, in the order of shaders/networks/mlp.glsl; the last two are those that scatter_grid reads.
struct step_rows {
    uint32_t encoding, hidden1, colour_in, hidden2, d_hidden1, d_geo, d_hidden2, d_logit, d_encoding, position, count;
};
struct step_rows step_bench_rows(const struct step_bench *bench);
// Makes all rows of a chunk as floats, all 0.
float *step_bench_new_rows(const struct step_bench *bench, size_t *count);
float *step_bench_read_rows(struct step_bench *bench);
// Writes them, and rounds `rows` as the device holds them.
void step_bench_write_rows(struct step_bench *bench, float *rows);
// Returns the four floats of a slot.
float *step_bench_row(const struct step_bench *bench, const float *rows, uint32_t row, uint32_t slot);
// Reads which hidden units of every slot were above 0: two words per layer.
vw_uint4 *step_bench_read_active(struct step_bench *bench);
#define BFLOAT_ROUNDING 0x1p-8 // half a unit in the last place, relative: activations but those of the grid are bfloats

// ---- Gradients ------------------------------------------------------------------------------------------------------

// A range of params that a step finds the gradient of, the sum over rays, by the reference and on the device.
struct step_range {
    const char *name;
    double *values;         // in the reference's params
    const double *expected; // the reference's gradient
    float *gradient;        // the device's
    size_t count;
    double tolerance; // share of the largest that the device's may be off
};
enum { STEP_RANGES_MAX = 10 };
// Lists all ranges but the grid, whose gradient is in integers: the networks' matrices, and what the effects that are
// on have. `d_weights` is the device's. Returns how many.
uint32_t step_bench_ranges(const struct step_bench *bench, struct reference_step *reference,
                           struct reference_params *params, const float *d_weights,
                           struct step_range ranges[STEP_RANGES_MAX]);

// ---- Comparison -----------------------------------------------------------------------------------------------------

// Fails unless |device - expected| <= tolerance (NaN fails); the message names the case, `what` and the index.
void check_value(const char *where, const char *what, uint64_t index, double device, double expected, double tolerance);
void check_same_bits(const char *where, const char *what, const void *device, const void *expected, size_t size_bytes);
double largest(const double *values, size_t count); // magnitude

// The way in which slopes of a loss of the reference are found.
struct slope_check {
    const char *where;
    double (*loss)(void *step);
    void *step;
    double distance;         // by which each value moves
    double tolerance, least; // share of the sum of all magnitudes, and what it may be off beside
};
// Checks that moving each value up where the device's gradient says that the loss rises, and down where it says that it
// falls, raises the reference's loss by the sum of all magnitudes, which it returns.
double check_slope(const struct slope_check *check, const char *what, double *values, const float *gradient,
                   size_t count);

// Seeded numbers for tests: uniform in [-1, 1), the next one at each call.
struct test_random {
    uint64_t seed;
    uint32_t drawn;
};
float test_random_next(struct test_random *random);

// Returns a pass of an effect by the name of its shader, that of halves as well; NULL where it is off.
const struct vw_pass *step_bench_effect_pass(const struct step_bench *bench, const char *name);

#endif
