// The effect transient against its reference, with both fields: what a step makes of samples and of the photo's code,
// forward and back. Gradients are held against finite differences of the reference's loss, which is in double.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/effects/transient.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"

enum { STEP = 3, SAMPLES_MAX = 32 };
static const double RENDERED_TOLERANCE = 1e-5; // sums of up to 64 products of exps, as in check_composite.c

// One case per thing that may break on its own. `density`, `uncertainty`: what the biases of these outputs are, where
// they are not 0.
static const struct {
    struct step_case setup;
    float density, uncertainty;
} cases[] = {
    {{"hash", .seed = 401, .rays = 8}, 0, 0},
    {{"hash, 7 samples, padded rays, by storage buffers", .seed = 402, .rays = 30, .samples = 7, .width = 16,
      .levels = 2, .as_on_gpus = true, .effects = "sky"},
     1,
     1},
    {{"hash, other effects", .seed = 403, .width = 64, .rays = 16, .samples = 16,
      .effects = "unbounded,appearance,appearance_code"},
     0,
     0},
    {{"mlp", .seed = 404, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 40, .rays = 16, .samples = 16}, 0, 0},
    {{"mlp, other effects", .seed = 405, .field = VW_FIELD_MLP, .mlp_depth = 6, .width = 24, .rays = 16, .samples = 16,
      .random_background = true, .effects = "background,appearance_code"},
     0,
     0},
    {{"transient density 0 everywhere, beta at its floor", .seed = 406, .width = 16, .rays = 16, .samples = 16,
      .effects = "appearance"},
     -200,
     0},
    {{"a photo that is transient alone", .seed = 407, .width = 16, .rays = 16, .samples = 16}, 300, 0},
    {{"hardly any density, hardly any uncertainty", .seed = 408, .width = 16, .rays = 16, .samples = 16}, -12, -30},
    {{"uncertain of everything", .seed = 409, .width = 16, .rays = 16, .samples = 16}, 5, 3000},
    {{"the least floor", .seed = 410, .width = 16, .rays = 16, .samples = 16, .beta_min = 0.001}, -3, -3},
};

struct transient_step { // the reference of a step: the field's part as the device has it
    struct step_bench *bench;
    struct reference_head head;
    struct reference_step *rays;
    uint32_t sample_count, feature_count;
    double *params, *features, code[REFERENCE_TRANSIENT_CODE];
    struct reference_point *points;
    double (*outputs)[REFERENCE_HEAD_OUTPUTS];
};

static float *weights_of(const struct step_bench *bench) {
    return bench->params + bench->model.weights.offset_bytes / sizeof(float);
}

static void lay_out_head(const struct step_bench *bench, struct reference_head *head) {
    const struct vw_specialization *s = &bench->model.specialization;
    if (bench->config.field == VW_FIELD_MLP) {
        struct reference_mlp mlp;
        reference_mlp_lay_out(bench->config.mlp_depth, bench->config.width, bench->config.frequencies, &mlp);
        reference_head_lay_out(bench->config.width, bench->config.width / 2, 4, mlp.param_count, head);
    } else {
        uint32_t columns = 4 * VW_WEIGHT_BLOCKS(s->levels * s->feature_pairs / 2, s->width4);
        reference_head_lay_out(16, bench->config.width, 2, 4 * columns, head);
    }
    assert_int_equal(head->end_at, 4 * bench->model.weight_columns);
}

static struct step_bench *open_case(size_t index) {
    struct step_case setup = cases[index].setup;
    struct reference_head head;
    setup.another_effect = "transient";
    setup.loss = VW_LOSS_L2;
    setup.optimizer = VW_OPTIMIZER_SGD; // so that steps tell gradients
    struct step_bench *bench = step_bench_open(&setup);
    lay_out_head(bench, &head);
    float *biases = weights_of(bench) + head.layers[head.count - 1].bias_at;
    biases[3] += cases[index].density;
    biases[4] += cases[index].uncertainty;
    step_bench_write_params(bench);
    return bench;
}

// Returns row `row` of a sample among those of layers.
static const float *row_of(const float *rows, uint32_t row_count, uint32_t row, uint32_t sample) {
    return rows + 4 * (size_t)VW_ROW_PLACE(row_count, row, sample);
}

// Features and samples that the device has found.
static void read_samples(struct transient_step *step) {
    struct step_bench *bench = step->bench;
    const struct vw_specialization *s = &bench->model.specialization;
    bool hash = bench->config.field == VW_FIELD_HASH;
    float *rows = test_read(hash ? bench->field.head_rows : bench->field.rows);
    vw_float4 *samples = test_read(bench->volume->samples);
    struct reference_mlp mlp;
    reference_mlp_lay_out(bench->config.mlp_depth, bench->config.width, bench->config.frequencies, &mlp);
    // The features of the field mlp follow encodings, trunk and density.
    uint32_t first = hash ? 0
                          : VW_ENCODED4(bench->config.frequencies) + VW_ENCODED4(VW_DIRECTION_FREQUENCIES) +
                                bench->config.mlp_depth * bench->config.width / 4 + 1;
    for (uint32_t i = 0; i < step->sample_count; i++) {
        for (uint32_t k = 0; k < step->feature_count; k++)
            step->features[i * step->feature_count + k] = row_of(rows, s->layer_rows, first + k / 4, i)[k % 4];
        step->points[i] = (struct reference_point){
            .rgb = {samples[i].x, samples[i].y, samples[i].z},
            .density = samples[i].w,
            .length = reference_stratum_length(s, &step->rays->rays[i / s->samples], i % s->samples)};
    }
}

static void read_rays(struct transient_step *step) {
    const struct step_bench *bench = step->bench;
    vw_uint4 key = vw_model_key_of_step(&bench->model, STEP);
    double sky[VW_SKY_COLUMNS][3];
    reference_sky_read(&bench->model, bench->params, sky);
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++)
        reference_backdrop(&bench->model.specialization, sky, step->rays->rays[ray].direction, ray, key,
                           step->rays->backdrops[ray]);
    const float *code = bench->params + bench->model.ranges[VW_SLOT_TRANSIENT_CODES].offset_bytes / sizeof(float);
    for (uint32_t k = 0; k < REFERENCE_TRANSIENT_CODE; k++)
        step->code[k] = code[REFERENCE_TRANSIENT_CODE * bench->view + k];
}

static void find_outputs(struct transient_step *step) {
    for (uint32_t i = 0; i < step->sample_count; i++)
        reference_head_forward(&step->head, step->params, step->features + i * step->feature_count, step->code,
                               step->outputs[i]);
}

// Opens the step that the device has taken last.
static struct transient_step *open_step(struct step_bench *bench) {
    struct transient_step *step = test_allocate(1, sizeof *step);
    *step = (struct transient_step){.bench = bench, .rays = step_bench_reference(bench)};
    lay_out_head(bench, &step->head);
    step->sample_count = step->rays->ray_count * bench->config.samples;
    step->feature_count = step->head.features;
    step->params = test_allocate(step->head.end_at, sizeof(double));
    for (uint32_t i = 0; i < step->head.end_at; i++) step->params[i] = weights_of(bench)[i];
    step->features = test_allocate((size_t)step->sample_count * step->feature_count, sizeof(double));
    step->points = test_allocate(step->sample_count, sizeof *step->points);
    step->outputs = test_allocate(step->sample_count, sizeof *step->outputs);
    read_samples(step);
    read_rays(step);
    find_outputs(step);
    return step;
}

static double ray_loss_of(const struct transient_step *step, uint32_t ray, double colour[3]) {
    uint32_t first = ray * step->bench->config.samples;
    const struct reference_transient_ray line = {.points = step->points + first,
                                                 .outputs = (const double(*)[5])step->outputs + first,
                                                 .count = step->bench->config.samples,
                                                 .backdrop = step->rays->backdrops[ray],
                                                 .target = step->rays->rays[ray].target,
                                                 .beta_min = step->bench->config.beta_min};
    return step->rays->rays[ray].weight * reference_transient_loss(&line, colour);
}

static double ray_loss(const struct transient_step *step, uint32_t ray) {
    double colour[3];
    return ray_loss_of(step, ray, colour);
}

static double whole_loss(void *of) {
    struct transient_step *step = of;
    double loss = 0.0;
    find_outputs(step);
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++) loss += ray_loss(step, ray);
    return loss;
}

enum { ALL_RAYS = UINT32_MAX };

// Returns the slope of the loss of a ray, or of the step, by a number, by central differences.
static double slope_by(struct transient_step *step, uint32_t ray, double *number) {
    const double distance = ray == ALL_RAYS ? 1e-6 : 1e-5, kept = *number;
    double losses[2];
    for (int ahead = 0; ahead < 2; ahead++) {
        *number = kept + (ahead ? distance : -distance);
        losses[ahead] = ray == ALL_RAYS ? whole_loss(step) : ray_loss(step, ray);
    }
    *number = kept;
    return (losses[1] - losses[0]) / (2.0 * distance);
}

// ---- Compositing and loss -------------------------------------------------------------------------------------------

// Returns the slope by the logarithm of a density.
static double slope_by_raw(const struct transient_step *step, uint32_t ray, struct reference_point *point) {
    const double distance = 1e-5, kept = point->density;
    point->density = kept * exp(distance);
    double ahead = ray_loss(step, ray);
    point->density = kept * exp(-distance);
    double behind = ray_loss(step, ray);
    point->density = kept;
    return (ahead - behind) / (2.0 * distance);
}

// The slopes of one sample: by rgb and raw density, then by the head's outputs.
enum { SLOPES = 4 + REFERENCE_HEAD_OUTPUTS };

static void find_slopes(struct transient_step *step, uint32_t sample, double slopes[SLOPES]) {
    uint32_t ray = sample / step->bench->config.samples;
    for (int c = 0; c < 3; c++) slopes[c] = slope_by(step, ray, &step->points[sample].rgb[c]);
    slopes[3] = slope_by_raw(step, ray, &step->points[sample]);
    for (int k = 0; k < REFERENCE_HEAD_OUTPUTS; k++) slopes[4 + k] = slope_by(step, ray, &step->outputs[sample][k]);
}

// Checks what fit_photo will find of every ray: its whole colour, with what is transient.
static void check_rendered(const struct transient_step *step) {
    struct step_bench *bench = step->bench;
    if (!bench->step.effect_buffers[VW_SLOT_RENDERED]) return;
    vw_float4 *rendered = test_read(bench->step.effect_buffers[VW_SLOT_RENDERED]);
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++) {
        double colour[3];
        ray_loss_of(step, ray, colour);
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "rendered", ray, (&rendered[ray].x)[c], colour[c], RENDERED_TOLERANCE);
        check_value(bench->where, "weight", ray, rendered[ray].w, step->rays->rays[ray].weight, 0.0);
    }
}

static void check_rays(struct transient_step *step, size_t c) {
    struct step_bench *bench = step->bench;
    const struct vw_specialization *s = &bench->model.specialization;
    float *losses = test_read(bench->step.ray_loss), *d_samples = test_read(bench->volume->d_samples),
          *d_rows = test_read(bench->field.d_rows);
    vw_float4 *scalars = test_read(bench->scalars);
    double(*slopes)[SLOPES] = test_allocate(step->sample_count, sizeof *slopes), most[SLOPES] = {0};
    assert_true(scalars->z == 0.0f);
    check_rendered(step);
    for (uint32_t ray = 0; ray < step->rays->ray_count; ray++)
        check_value(bench->where, "loss", ray, losses[ray], ray_loss(step, ray), 2e-5 * (1.0 + ray_loss(step, ray)));
    for (uint32_t i = 0; i < step->sample_count; i++) {
        find_slopes(step, i, slopes[i]);
        for (int k = 0; k < SLOPES; k++) most[k] = fmax(most[k], fabs(slopes[i][k]));
    }
    for (uint32_t i = 0; i < step->sample_count; i++) {
        const float *d_outputs = row_of(d_rows, s->d_layer_rows, s->d_transient_row, i),
                    *d_uncertainty = row_of(d_rows, s->d_layer_rows, s->d_transient_row + 1, i);
        for (int k = 0; k < SLOPES; k++) {
            float found = k < 4 ? d_samples[4 * i + (uint32_t)k] : k < 8 ? d_outputs[k - 4] : d_uncertainty[0];
            check_value(bench->where, k < 4 ? "d_sample" : "d_output", SLOPES * i + (uint32_t)k, found, slopes[i][k],
                        1e-4 * most[k] + 1e-9);
        }
        for (int k = 1; k < 4; k++) assert_true(d_uncertainty[k] == 0.0f);
    }
    if (cases[c].density == 0.0f)
        for (int k = 0; k < SLOPES; k++) assert_true(most[k] > 1e-7);
}

// ---- The head -------------------------------------------------------------------------------------------------------

// Checks all of a layer along the device's gradient, and some of its numbers alone.
static void check_layer(struct transient_step *step, const struct reference_layer *layer, uint32_t end,
                        const float *d_weights) {
    const struct slope_check check = {step->bench->where, whole_loss, step, 1e-7, 0.01, 1e-9};
    double most = 0.0;
    for (uint32_t i = layer->first_at; i < end; i++) most = fmax(most, fabs(d_weights[i]));
    check_slope(&check, layer->name, step->params + layer->first_at, d_weights + layer->first_at,
                end - layer->first_at);
    for (uint32_t i = layer->first_at; i < end; i += (end - layer->first_at) / 5)
        check_value(step->bench->where, layer->name, i, d_weights[i],
                    d_weights[i] == 0.0f ? 0.0 : slope_by(step, ALL_RAYS, &step->params[i]), 0.01 * most + 1e-9);
}

static void check_head(struct transient_step *step) {
    float *d_weights = test_read(step->bench->step.d_weights);
    for (uint32_t l = 0; l < step->head.count; l++) {
        const struct reference_layer *layer = &step->head.layers[l];
        check_layer(step, layer, l + 1 < step->head.count ? layer[1].first_at : step->head.end_at, d_weights);
    }
}

// Checks that plain descent moves the code by its gradient and a ridge; those of other photos stay.
static void check_code_moves(struct step_bench *bench) {
    const struct vw_param_range *codes = &bench->model.ranges[VW_SLOT_TRANSIENT_CODES];
    step_bench_step(bench, STEP);
    struct transient_step *step = open_step(bench);
    float *after = test_read(bench->field.params);
    double slopes[REFERENCE_TRANSIENT_CODE], rate = 20.0 * bench->config.learning_rate;
    for (uint32_t k = 0; k < REFERENCE_TRANSIENT_CODE; k++)
        slopes[k] = slope_by(step, ALL_RAYS, &step->code[k]) / bench->config.rays + 0.01 * step->code[k];
    double most = largest(slopes, REFERENCE_TRANSIENT_CODE);
    for (uint32_t i = 0; i < codes->size_bytes / sizeof(float); i++) {
        size_t at = codes->offset_bytes / sizeof(float) + i;
        uint32_t view = i / REFERENCE_TRANSIENT_CODE;
        double expected = view == bench->view ? slopes[i % REFERENCE_TRANSIENT_CODE] : 0.0;
        if (view != bench->view) assert_true(after[at] == bench->params[at]);
        check_value(bench->where, "code", i, ((double)bench->params[at] - after[at]) / rate, expected,
                    0.01 * most + 1e-6);
    }
}

// ---- Into the field -------------------------------------------------------------------------------------------------

// Checks that the features of the field hash have the head's gradient beside that of the colour network.
static void check_hash_features(struct transient_step *step, size_t c) {
    struct step_bench *bench = step->bench;
    const struct vw_specialization *s = &bench->model.specialization;
    const struct step_rows at = step_bench_rows(bench);
    float *d_rows = test_read(bench->field.d_rows), *rows = step_bench_read_rows(bench);
    const float *weights = weights_of(bench);
    double most = 0.0, most_all = 0.0;
    for (uint32_t i = 0; i < step->sample_count; i++)
        for (uint32_t k = 1; k < 16; k++) {
            most = fmax(most, fabs(row_of(d_rows, s->d_layer_rows, s->d_feature_row + k / 4, i)[k % 4]));
            most_all = fmax(most_all, fabs(step_bench_row(bench, rows, at.d_geo + k / 4, i)[k % 4]));
        }
    for (uint32_t i = 0; i < step->sample_count; i++) {
        for (uint32_t k = 1; k < 16; k++) {
            double by_colour = 0.0, by_head = row_of(d_rows, s->d_layer_rows, s->d_feature_row + k / 4, i)[k % 4];
            for (uint32_t unit = 0; unit < bench->config.width; unit++)
                by_colour += step_bench_row(bench, rows, at.d_hidden2 + unit / 4, i)[unit % 4] *
                             weights[reference_block_index(s, 2, unit, k)];
            check_value(bench->where, "d_geo", 16 * i + k, step_bench_row(bench, rows, at.d_geo + k / 4, i)[k % 4],
                        by_colour + by_head, 4.0 * BFLOAT_ROUNDING * most_all);
            if ((i + k) % 61 == 0)
                check_value(bench->where, "d_feature", 16 * i + k, by_head,
                            slope_by(step, ALL_RAYS, &step->features[i * step->feature_count + k]), 0.01 * most + 1e-9);
        }
    }
    if (cases[c].density == 0.0f) assert_true(most > 1e-3 * most_all);
}

struct trunk { // the part of the field mlp before the head
    struct transient_step *step;
    struct reference_mlp mlp;
    struct reference_mlp_sample *sample;
    double *shift;
};

// Returns the loss with the trunk and all that follows it found again.
static double trunk_loss(void *of) {
    const struct trunk *trunk = of;
    struct transient_step *step = trunk->step;
    const struct vw_specialization *s = &step->bench->model.specialization;
    struct reference_mlp_sample *it = trunk->sample;
    vw_uint4 key = vw_model_key_of_step(&step->bench->model, STEP);
    for (uint32_t i = 0; i < step->sample_count; i++) {
        uint32_t ray = i / s->samples, sample = i % s->samples;
        const struct reference_ray *line = &step->rays->rays[ray];
        reference_sample_position(s, line, sample, reference_stratum_offset(s, ray, sample, key), it->position);
        memcpy(it->direction, line->direction, sizeof it->direction);
        reference_mlp_forward(&trunk->mlp, step->params, trunk->shift, it);
        memcpy(step->features + i * step->feature_count, it->values[trunk->mlp.depth + 1],
               step->feature_count * sizeof(double));
        memcpy(step->points[i].rgb, it->rgb, sizeof it->rgb);
        step->points[i].density = it->density;
    }
    return whole_loss(step);
}

static void find_shift(const struct step_bench *bench, double *shift) {
    const struct vw_model *model = &bench->model;
    double *code_weights =
        test_allocate(model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / sizeof(float), sizeof *code_weights);
    const float *values = bench->params + model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes / sizeof(float);
    for (size_t i = 0; i < model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / sizeof(float); i++)
        code_weights[i] = values[i];
    struct reference_photo photo = reference_photo_of(model, bench->params, bench->view);
    reference_mix_code(4 * model->specialization.width4, code_weights, photo.code, shift);
}

// Checks that the trunk of the field mlp has the head's gradient.
static void check_mlp_trunk(struct transient_step *step) {
    struct step_bench *bench = step->bench;
    struct trunk trunk = {.step = step, .shift = test_allocate(bench->config.width, sizeof(double))};
    struct reference_mlp *mlp = &trunk.mlp;
    const struct slope_check check = {bench->where, trunk_loss, &trunk, 1e-7, 0.01, 0.0};
    reference_mlp_lay_out(bench->config.mlp_depth, bench->config.width, bench->config.frequencies, mlp);
    trunk.sample = reference_mlp_samples(mlp, 1);
    if (bench->model.ranges[VW_SLOT_CODES].size_bytes) find_shift(bench, trunk.shift);
    float *d_weights = test_read(bench->step.d_weights);
    for (uint32_t l = 0; l < mlp->count; l++) {
        uint32_t first = mlp->layers[l].first_at,
                 end = l + 1 < mlp->count ? mlp->layers[l + 1].first_at : mlp->param_count;
        assert_true(
            check_slope(&check, mlp->layers[l].name, trunk.step->params + first, d_weights + first, end - first) > 0.0);
    }
}

TEST_CASES(steps_match_differences, c, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(c);
    step_bench_gradients(bench, STEP);
    struct transient_step *step = open_step(bench);
    check_rays(step, c);
    check_head(step);
    if (cases[c].setup.field == VW_FIELD_HASH) check_hash_features(step, c);
    else check_mlp_trunk(step);
    check_code_moves(bench);
}

// ---- What is not finite ---------------------------------------------------------------------------------------------

TEST(what_is_not_finite_marks_the_step) {
    for (int infinite = 0; infinite < 2; infinite++) {
        struct step_bench *bench = open_case(0);
        struct reference_head head;
        lay_out_head(bench, &head);
        weights_of(bench)[head.layers[head.count - 1].bias_at + 3] = infinite ? INFINITY : NAN;
        step_bench_check_skipped(bench, STEP);
        test_release(bench);
    }
}

TEST_GROUP(NULL, test_gpu_close)
