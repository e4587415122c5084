// The field mlp against its reference: what a step makes of rays, forward and back, and what validation renders; and
// likewise the coarse network that shows where importance samples go, by its own colours of the even samples. The slope
// of the reference's loss is held against the device's gradients by finite differences.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/mlp_field.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"
#include "train/fields/registry.h"

enum { STEP = 3 };

// One case per thing that may break on its own.
static const struct step_case cases[] = {
    {"one layer", .seed = 301, .mlp_depth = 1, .width = 16},
    {"widths that no tile of 16 rows divides", .seed = 302, .mlp_depth = 2, .width = 136, .rays = 9, .samples = 16},
    {"skip as the last layer", .seed = 303, .mlp_depth = 6, .width = 24, .frequencies = 3, .effects = "sky"},
    {"skip, by storage buffers", .seed = 304, .mlp_depth = 8, .width = 32, .as_on_gpus = true, .loss = VW_LOSS_L2},
    {"codes and unbounded rays", .seed = 305, .mlp_depth = 3, .width = 40, .loss = VW_LOSS_HUBER,
     .effects = "appearance,appearance_code,unbounded"},
    {"whole tiles, two of them", .seed = 306, .mlp_depth = 2, .width = 128, .rays = 8, .samples = 32},
    {"the highest frequencies", .seed = 307, .mlp_depth = 2, .width = 16, .frequencies = 16},
    {"large weights", .seed = 308, .mlp_depth = 3, .width = 16, .weight_scale = 1.5f, .samples = 4, .rays = 64},
    {"importance samples", .seed = 309, .mlp_depth = 2, .width = 24, .frequencies = 3, .samples = 7,
     .importance_samples = 20},
    {"a coarse network with a skip, of more samples", .seed = 310, .mlp_depth = 6, .width = 24, .frequencies = 3,
     .samples = 20, .importance_samples = 8, .own_coarse = true, .effects = "sky"},
    {"a coarse network beside codes, by storage buffers", .seed = 311, .mlp_depth = 2, .width = 40, .frequencies = 4,
     .samples = 8, .importance_samples = 20, .own_coarse = true, .as_on_gpus = true, .loss = VW_LOSS_L2,
     .effects = "appearance,appearance_code,unbounded"},
};

struct mlp_step { // the reference of a step
    struct reference_mlp mlp;
    struct step_bench *bench;
    bool coarse;                // the step is the coarse network's, not the field's
    struct vw_specialization s; // with its samples
    uint32_t first;             // float of the weights, of this network
    struct reference_step *rays;
    struct reference_mlp_sample *samples;
    double *params, *d_params, *shift;
    struct reference_params *others; // sky, photos and code weights
    double loss;
};

static uint32_t sample_count(const struct mlp_step *step) { return step->rays->ray_count * step->s.samples; }

static struct reference_params *read_others(const struct vw_model *model, const float *params) {
    struct reference_params *others = test_allocate(1, sizeof *others);
    reference_sky_read(model, params, others->sky);
    uint32_t photos = reference_photo_count(model);
    if (photos) others->photos = test_allocate(photos, sizeof *others->photos);
    for (uint32_t i = 0; i < photos; i++) others->photos[i] = reference_photo_of(model, params, i);
    for (size_t i = 0; i < model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / sizeof *params; i++)
        others->code_weights[i] = params[model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes / sizeof *params + i];
    return others;
}

// Takes the gradients of the device's step, and the loss and the activations of the field or of the coarse network,
// which runs again, since the field's take their place.
static void take_step(struct step_bench *bench, bool coarse) {
    step_bench_gradients(bench, STEP);
    if (!coarse) return;
    const struct vw_push_samples push = step_bench_push(bench, STEP);
    vw_submission_begin(bench->submission);
    vw_importance_record(&bench->model, &bench->volume->gradient.importance, bench->submission, &push);
    vw_step_record_loss(&bench->step, bench->submission, 0, 0);
    test_submit(bench->submission);
}

// Opens a step with the rays that the device has made for its last step.
static struct mlp_step *open_step(struct step_bench *bench, bool coarse) {
    struct mlp_step *step = test_allocate(1, sizeof *step);
    step->bench = bench;
    step->coarse = coarse;
    step->s = bench->model.specialization;
    if (coarse) {
        step->s.samples = bench->config.samples;
        step->s.importance = 0;
        step->first = 4 * bench->layout->coarse_column;
        assert_int_equal(bench->layout->coarse.size_bytes, bench->model.weights.size_bytes);
    }
    reference_mlp_lay_out(bench->config.mlp_depth, bench->config.width, bench->config.frequencies, &step->mlp);
    assert_int_equal(step->mlp.param_count, 4 * bench->model.weight_columns);
    step->rays = step_bench_reference(bench);
    step->samples = reference_mlp_samples(&step->mlp, sample_count(step));
    step->params = test_allocate(step->mlp.param_count, sizeof(double));
    step->d_params = test_allocate(step->mlp.param_count, sizeof(double));
    step->shift = test_allocate(bench->config.width, sizeof(double));
    step->others = read_others(&bench->model, bench->params);
    const float *weights = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t i = 0; i < step->mlp.param_count; i++) step->params[i] = weights[step->first + i];
    return step;
}

// Returns where the importance samples of a ray are; NULL where samples are even.
static const double *places_of(const struct mlp_step *step, uint32_t ray) {
    return step->s.importance ? &step->rays->sample_places[ray * step->s.samples] : NULL;
}

static void list_points(const struct mlp_step *step, uint32_t ray, struct reference_point *points) {
    const struct vw_specialization *s = &step->s;
    const struct reference_ray *line = &step->rays->rays[ray];
    const double *places = places_of(step, ray);
    for (uint32_t i = 0; i < s->samples; i++) {
        const struct reference_mlp_sample *sample = &step->samples[ray * s->samples + i];
        memcpy(points[i].rgb, sample->rgb, sizeof points[i].rgb);
        points[i].density = sample->density;
        points[i].length = places ? reference_listed_length(s, line, places, i) : reference_stratum_length(s, line, i);
    }
}

// Runs the reference forward; `training` adds jittered samples of step STEP and the photo's code.
static void forward(struct mlp_step *step, bool training) {
    struct vw_specialization s = step->s;
    vw_uint4 key = vw_model_key_of_step(&step->bench->model, STEP);
    const struct reference_photo *photo =
        training && step->others->photos ? &step->others->photos[step->bench->view] : NULL;
    struct reference_point points[64];
    s.training = training;
    step->loss = 0.0;
    memset(step->shift, 0, step->bench->config.width * sizeof(double));
    if (photo && !step->coarse) reference_mix_code(4 * s.width4, step->others->code_weights, photo->code, step->shift);
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++) {
        const struct reference_ray *line = &step->rays->rays[ray];
        const double *places = places_of(step, ray);
        double unused;
        for (uint32_t i = 0; i < s.samples; i++) {
            struct reference_mlp_sample *sample = &step->samples[ray * s.samples + i];
            double place = places ? places[i] : i + reference_stratum_offset(&s, ray, i, key);
            reference_position_at(&s, line, place, sample->position);
            memcpy(sample->direction, line->direction, sizeof sample->direction);
            reference_mlp_forward(&step->mlp, step->params, step->shift, sample);
        }
        reference_backdrop(&s, step->others->sky, line->direction, ray, key, step->rays->backdrops[ray]);
        list_points(step, ray, points);
        step->rays->left[ray] =
            reference_composite(points, s.samples, step->rays->backdrops[ray], step->rays->colours[ray]);
        for (int c = 0; c < 3; c++) {
            step->rays->errors[ray][c] = step->rays->colours[ray][c] - line->target[c];
            step->loss += line->weight / 3.0 * reference_loss(&s, step->rays->errors[ray][c], &unused);
        }
    }
}

static void backward(struct mlp_step *step) {
    const struct vw_specialization *s = &step->s;
    struct reference_point points[64];
    struct reference_d_point d_points[64];
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++) {
        double d_colour[3];
        for (int c = 0; c < 3; c++) {
            reference_loss(s, step->rays->errors[ray][c], &d_colour[c]);
            d_colour[c] *= step->rays->rays[ray].weight / 3.0;
        }
        list_points(step, ray, points);
        reference_composite_gradient(points, s->samples, step->rays->backdrops[ray], d_colour, d_points);
        for (uint32_t i = 0; i < s->samples; i++)
            reference_mlp_backward(&step->mlp, step->params, &step->samples[ray * s->samples + i], d_points[i].rgb,
                                   d_points[i].raw, step->d_params);
    }
}

static struct step_bench *open_case(size_t index) {
    struct step_case setup = cases[index];
    setup.field = VW_FIELD_MLP;
    return step_bench_open(&setup);
}

// ---- Encoding -------------------------------------------------------------------------------------------------------

// Checks what encode_samples wrote: sines of up to 2^15 half turns, where a driver's sin of so large a number is off by
// much.
static void check_encodings(const struct mlp_step *step) {
    struct step_bench *bench = step->bench;
    float *rows = test_read(bench->field.rows);
    uint32_t frequencies = bench->config.frequencies, count = 3 + 6 * frequencies, position4 = VW_ENCODED4(frequencies);
    for (uint32_t i = 0; i < sample_count(step); i++) {
        for (uint32_t k = 0; k < 4 * position4; k++) {
            float number = rows[4 * (size_t)VW_ROW_PLACE(bench->layout->row_count, k / 4, i) + k % 4];
            // The position is a float, off by 2^-24 and more after its way; a frequency multiplies that.
            double scale = k < 3 ? 1.0 : ldexp(M_PI, (int)(k - 3) / 6);
            check_value(bench->where, "encoded position", k, number, k < count ? step->samples[i].encodings[k] : 0.0,
                        3e-7 + 6e-7 * scale);
        }
        for (uint32_t k = 0; k < 27; k++) {
            float number = rows[4 * (size_t)VW_ROW_PLACE(bench->layout->row_count, position4 + k / 4, i) + k % 4];
            check_value(bench->where, "encoded direction", k, number, step->samples[i].encodings[count + k], 6e-6);
        }
    }
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

// Returns a wide tolerance for the highest frequencies, which amplify what positions are off by: there rendering and
// gradients are those of a field that is not quite the same.
static double tolerance_of(const struct step_bench *bench) { return bench->config.frequencies > 10 ? 0.1 : 2e-3; }

// Puts the device's ReLU decisions in the place of the reference's, which differ where a sum is next to 0.
static void adopt_gates(struct mlp_step *step) {
    const struct step_bench *bench = step->bench;
    float *rows = test_read(bench->field.rows);
    for (uint32_t i = 0; i < sample_count(step); i++) {
        uint32_t row = VW_ENCODED4(bench->config.frequencies) + VW_ENCODED4(VW_DIRECTION_FREQUENCIES);
        for (uint32_t l = 0; l < step->mlp.count; l++) {
            double *values = step->samples[i].values[l];
            for (uint32_t k = 0; k < step->mlp.layers[l].out && step->mlp.layers[l].relu; k++) {
                bool active = rows[4 * (size_t)VW_ROW_PLACE(bench->layout->row_count, row + k / 4, i) + k % 4] > 0.0f;
                if (active != (values[k] > 0.0))
                    check_value(bench->where, "gated", k, 0.0, values[k], 0.05 * tolerance_of(bench));
                values[k] = active ? fmax(values[k], 1e-300) : 0.0;
            }
            row += (step->mlp.layers[l].out + 3) / 4;
        }
    }
}

static double loss_of(void *step) {
    forward(step, true);
    return ((const struct mlp_step *)step)->loss;
}

// Checks the gradients of each layer against the reference, and against the slope of the reference's loss.
static void check_gradients(struct mlp_step *step) {
    struct step_bench *bench = step->bench;
    const struct slope_check check = {bench->where, loss_of, step, 1e-6, 0.01, 0.0};
    float *d_weights = (float *)test_read(bench->step.d_weights) + step->first;
    vw_float4 *scalars = test_read(bench->scalars);
    double tolerance = tolerance_of(bench);
    assert_true(scalars->z == 0.0f);
    check_value(bench->where, "loss", 0, (double)scalars->x + scalars->y, step->loss, 0.2 * tolerance * step->loss);
    for (uint32_t l = 0; l < step->mlp.count; l++) {
        const struct reference_layer *layer = &step->mlp.layers[l];
        uint32_t end = l + 1 < step->mlp.count ? layer[1].first_at : step->mlp.param_count;
        double most = largest(step->d_params + layer->first_at, end - layer->first_at);
        assert_true(most > 0.0);
        for (uint32_t i = layer->first_at; i < end; i++)
            check_value(bench->where, layer->name, i, d_weights[i], step->d_params[i], tolerance * most);
        if (bench->config.frequencies <= 10)
            check_slope(&check, layer->name, step->params + layer->first_at, d_weights + layer->first_at,
                        end - layer->first_at);
    }
}

static void check_rendering(struct step_bench *bench) {
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    vw_float4 *colours = test_allocate(bench->config.rays, sizeof *colours);
    assert_int_equal(vw_evaluator_render(evaluator, bench->pixels, bench->config.rays, colours), VW_OK);
    struct mlp_step *step = open_step(bench, false);
    struct vw_ray *rays = test_read(evaluator->rays);
    step->rays->sample_places = step_bench_sample_places(vw_volume_evaluation_of(evaluator)->places);
    for (uint32_t i = 0; i < bench->config.rays; i++) step->rays->rays[i] = reference_ray_of(&rays[i]);
    forward(step, false);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++)
        for (int i = 0; i < 3; i++)
            check_value(bench->where, "rendered", ray, (&colours[ray].x)[i], step->rays->colours[ray][i],
                        tolerance_of(bench) * 0.1);
}

TEST_CASES(steps_match_the_reference, c, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(c);
    for (int coarse = 0; coarse <= (int)cases[c].own_coarse; coarse++) {
        take_step(bench, coarse);
        struct mlp_step *step = open_step(bench, coarse);
        forward(step, true);
        if (!coarse) check_encodings(step);
        adopt_gates(step);
        backward(step);
        check_gradients(step);
    }
    check_rendering(bench);
}

TEST_GROUP(NULL, test_gpu_close)
