// The consistency loss beside the effect appearance_encoder, with both fields: its passes against the reference, its
// gradients by the field against finite differences of what the device gives, and that they are added to the step's.
// Hard cases: pictures of few rays, finer than their photos, or of masked photos, and codes that are equal.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "support/encoder_check.h"
#include "train/effects/appearance_encoder.h"

static const double WEIGHT = 5.0;
static const uint64_t STEP = 3; // steps 1 to 3 are of both photos

static const struct step_case cases[] = {
    {"hash", .seed = 611, .rays = 30, .samples = 16},
    {"hash, one ray", .seed = 612, .rays = 3, .samples = 16, .loss = VW_LOSS_L2},
    {"hash, a picture finer than thumbnails", .seed = 613, .rays = 1100, .samples = 8, .levels = 4, .width = 16},
    {"hash, 7 samples, as on GPUs, background", .seed = 614, .rays = 16, .samples = 7, .width = 64, .levels = 2,
     .loss = VW_LOSS_L2, .random_background = true, .as_on_gpus = true, .effects = "background"},
    {"hash, other effects", .seed = 615, .rays = 16, .samples = 16, .width = 16, .loss = VW_LOSS_HUBER,
     .effects = "sky,visibility"},
    {"hash, importance samples", .seed = 617, .rays = 16, .samples = 16, .importance_samples = 16},
    {"mlp", .seed = 618, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 40, .rays = 26, .samples = 16},
};

static struct step_bench *open_case(size_t index, double weight) {
    struct step_case setup = cases[index];
    setup.another_effect = "appearance_encoder";
    setup.consistency_weight = weight;
    return step_bench_open(&setup);
}

// Masks all pixels, so that the step has no other gradient.
static void mask(struct step_bench *bench) {
    struct vw_pixel *pixels = vw_buffer_map(bench->pixel_buffer);
    for (uint32_t i = 0; i < bench->config.rays; i++) pixels[i].weight = 0.0f;
}

static void take_gradients(struct step_bench *bench) {
    if (bench->volume->d_grid) {
        void *zeros = test_allocate(vw_buffer_size_bytes(bench->volume->d_grid), 1);
        test_write(bench->volume->d_grid, zeros);
    }
    vw_submission_begin(bench->submission);
    vw_step_record_gradients(&bench->step, bench->submission, STEP, 0);
    test_submit(bench->submission);
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

static void compare(struct step_bench *bench, const char *what, const float *found, const double *expected,
                    size_t count, double tolerance) {
    double scale = fmax(largest(expected, count), 1e-30);
    for (size_t i = 0; i < count; i++) check_value(bench->where, what, i, found[i], expected[i], tolerance * scale);
}

// Checks the colours against the samples that the device holds, each of which stands for a stratum.
static void check_colours(struct step_bench *bench, const vw_float4 *colours) {
    const struct vw_consistency_effect *it = bench->step.consistency;
    const struct vw_specialization *s = &bench->model.specialization;
    const vw_uint4 key = vw_model_key_of_step(&bench->model, STEP);
    struct vw_ray *rays = test_read(it->rays);
    vw_float4 *samples = test_read(bench->volume->samples);
    struct reference_point *points = test_allocate(s->samples, sizeof *points);
    double sky[VW_SKY_COLUMNS][3];
    reference_sky_read(&bench->model, bench->params, sky);
    for (uint32_t i = 0; i < it->ray_count; i++) {
        const struct reference_ray ray = reference_ray_of(&rays[i]);
        double backdrop[3], colour[3];
        for (uint32_t k = 0; k < s->samples; k++) {
            vw_float4 sample = samples[i * s->samples + k];
            points[k] = (struct reference_point){{sample.x, sample.y, sample.z}, sample.w, ray.stride};
        }
        reference_backdrop(s, sky, ray.direction, i, key, backdrop);
        reference_composite(points, s->samples, backdrop, colour);
        compare(bench, "colour", &colours[i].x, colour, 3, 2e-5);
    }
}

static void read_thumbnail(struct step_bench *bench, struct reference_photo_encoding *encoding) {
    const vw_float4 *found = test_read(bench->step.consistency->thumbnail);
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
        const double values[4] = {found[i].x, found[i].y, found[i].z, found[i].w};
        memcpy(encoding->thumbnail[i], values, sizeof values);
    }
}

static void check_thumbnail(struct step_bench *bench, const vw_float4 *colours) {
    const struct vw_consistency_effect *it = bench->step.consistency;
    double(*exact)[3] = test_allocate(it->ray_count, sizeof *exact);
    struct reference_photo_encoding *found = test_allocate(1, sizeof *found),
                                    *expected = test_allocate(1, sizeof *found);
    for (uint32_t i = 0; i < it->ray_count; i++) {
        const double colour[3] = {colours[i].x, colours[i].y, colours[i].z};
        memcpy(exact[i], colour, sizeof colour);
    }
    read_thumbnail(bench, found);
    reference_picture_thumbnail(it->side, exact, expected->thumbnail);
    for (uint32_t i = 0; i < 4 * THUMBNAIL_PIXELS; i++)
        check_value(bench->where, "thumbnail", i, found->thumbnail[i / 4][i % 4], expected->thumbnail[i / 4][i % 4],
                    2e-6);
}

// Checks the slopes and the encoder's gradients, given the codes that the device found.
static void check_back(struct step_bench *bench, const double *network, const struct reference_photo_encoding *seen,
                       const struct reference_photo_encoding *given) {
    const struct vw_consistency_effect *it = bench->step.consistency;
    const uint32_t columns[] = {0, ENCODER_LAYER2, ENCODER_LAYER3, ENCODER_CODE, ENCODER_SHIFT};
    static double d_thumbnail[THUMBNAIL_PIXELS][4];
    float *own = test_read(it->d_weights), *of_encoder = own + 4 * (size_t)bench->model.specialization.encoder_column;
    double *expected = test_allocate(4 * ENCODER_SHIFT, sizeof *expected), d_code[REFERENCE_CODE],
           (*d_colours)[3] = test_allocate(it->ray_count, sizeof *d_colours), scale;
    struct vw_ray *rays = test_read(it->rays);
    for (int k = 0; k < REFERENCE_CODE; k++)
        d_code[k] = WEIGHT * bench->config.rays / REFERENCE_CODE * copysign(1.0, seen->code[k] - given->code[k]);
    reference_code_gradient(network, seen, d_code, expected, d_thumbnail);
    reference_picture_gradient(it->side, d_thumbnail, d_colours);
    for (int part = 0; part < 4; part++)
        compare(bench, "gradient of the encoder", of_encoder + 4 * (size_t)columns[part], expected + 4 * columns[part],
                4 * (columns[part + 1] - columns[part]), 5e-4);
    scale = largest(d_colours[0], 3 * (size_t)it->ray_count);
    assert_true(scale > 0.0);
    for (uint32_t i = 0; i < it->padded_rays; i++) {
        const float found[3] = {rays[i].target_weight.x, rays[i].target_weight.y, rays[i].target_weight.z};
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "slope", 3 * i + c, found[c], i < it->ray_count ? d_colours[i][c] : 0.0,
                        5e-4 * scale);
    }
}

static void check_codes(struct step_bench *bench) {
    const struct vw_consistency_effect *it = bench->step.consistency;
    float *params = test_read(bench->field.params), *seen_rows = test_read(it->encoder_rows),
          *given_rows = test_read(bench->field.effect_buffers[VW_SLOT_ENCODER_ROWS]);
    double *network = encoder_network(bench, params);
    struct reference_photo_encoding *seen = test_allocate(1, sizeof *seen), *given;
    read_thumbnail(bench, seen);
    reference_encode_photo(network, 4 * bench->model.specialization.width4, seen);
    given = encoder_reference(bench, network, vw_consistency_given_view(&bench->step, STEP));
    compare(bench, "code of the picture", seen_rows + 4 * ENCODER_ROW_CODE, seen->code, REFERENCE_CODE, 2e-5);
    compare(bench, "code given", given_rows + 4 * ENCODER_ROW_CODE, given->code, REFERENCE_CODE, 2e-5);
    check_back(bench, network, seen, given);
}

TEST_CASES(passes_are_the_references, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i, WEIGHT);
    take_gradients(bench);
    vw_float4 *colours = test_read(bench->step.consistency->colours);
    if (!cases[i].importance_samples) check_colours(bench, colours);
    check_thumbnail(bench, colours);
    check_codes(bench);
}

// ---- Finite differences ---------------------------------------------------------------------------------------------

// Returns the sum over rays, in double from the device's codes. The one given depends on the encoder alone.
static double loss_of(struct step_bench *bench, const float *params) {
    test_write(bench->field.params, params);
    take_gradients(bench);
    float *seen = test_read(bench->step.consistency->encoder_rows),
          *given = test_read(bench->field.effect_buffers[VW_SLOT_ENCODER_ROWS]);
    double sum = 0.0;
    for (uint32_t k = 4 * ENCODER_ROW_CODE; k < 4 * ENCODER_ROWS; k++) sum += fabs((double)seen[k] - given[k]);
    return WEIGHT * bench->config.rays / REFERENCE_CODE * sum;
}

// Checks the slope along the gradient itself, from `first` to `end` in the params: it is the gradient's length.
static void check_own_slope(struct step_bench *bench, const char *what, const double *gradient, size_t first,
                            size_t end) {
    const double MOVED = 0.0002, TOLERANCE = 0.02; // shares of loss and slope; activations between passes are bfloats
    size_t count = bench->model.param_bytes / sizeof(float);
    float *moved = test_allocate(count, sizeof *moved);
    double here = loss_of(bench, bench->params), square = 0.0, sides[2];
    for (size_t i = first; i < end; i++) square += gradient[i] * gradient[i];
    assert_true(square > 0.0);
    for (int side = 0; side < 2; side++) {
        memcpy(moved, bench->params, bench->model.param_bytes);
        for (size_t i = first; i < end; i++)
            moved[i] += (float)((side ? -1.0 : 1.0) * MOVED * here / square * gradient[i]);
        sides[side] = loss_of(bench, moved);
    }
    print_message("%s, %s: %.4f of the slope\n", bench->where, what, (sides[0] - sides[1]) / (2.0 * MOVED * here));
    check_value(bench->where, what, 0, (sides[0] - sides[1]) / (2.0 * MOVED * here), 1.0, TOLERANCE);
}

static double *read_gradient(struct step_bench *bench) {
    const struct vw_model *model = &bench->model;
    size_t count = model->param_bytes / sizeof(float), features = 2 * (size_t)vw_volume_of(model)->pair_count;
    double *gradient = test_allocate(count, sizeof *gradient);
    float *d_weights = test_read(bench->step.d_weights);
    for (size_t i = 0; i < 4 * (size_t)model->moved_columns; i++)
        gradient[model->weights.offset_bytes / sizeof(float) + i] = d_weights[i];
    if (!bench->volume->d_grid) return gradient;
    uint64_t *words = test_read(bench->volume->d_grid);
    int64_t *quanta = test_allocate(features, sizeof *quanta);
    reference_unpack_grid(model, words, quanta);
    for (size_t i = 0; i < features; i++)
        gradient[vw_volume_of(model)->grid.offset_bytes / sizeof(float) + i] =
            (double)quanta[i] * model->specialization.gradient_quantum;
    return gradient;
}

TEST_CASES(gradients_are_slopes, i, VW_ARRAY_COUNT(cases)) {
    if (cases[i].importance_samples) return; // their places move with the params
    struct step_bench *bench = open_case(i, WEIGHT);
    const struct vw_model *model = &bench->model;
    const struct vw_param_range *of_sky = &model->ranges[VW_SLOT_SKY], encoder = vw_encoder_network(model);
    size_t weights = model->weights.offset_bytes / 4,
           sky = (of_sky->size_bytes ? of_sky->offset_bytes : encoder.offset_bytes) / 4,
           sky_end = sky + of_sky->size_bytes / 4, shift = encoder.offset_bytes / 4 + 4 * ENCODER_SHIFT,
           shift_end = (encoder.offset_bytes + encoder.size_bytes) / 4;
    mask(bench);
    take_gradients(bench);
    double *gradient = read_gradient(bench);
    check_own_slope(bench, "weights", gradient, weights, sky);
    if (sky_end > sky) check_own_slope(bench, "sky", gradient, sky, sky_end);
    if (vw_volume_of(model)->grid.size_bytes)
        check_own_slope(bench, "grid", gradient, 0, 2 * (size_t)vw_volume_of(model)->pair_count);
    check_own_slope(bench, "code to shift", gradient, shift, shift_end);
}

// ---- In the step ----------------------------------------------------------------------------------------------------

TEST_CASES(it_is_added_to_the_step, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *with = open_case(i, WEIGHT), *without = open_case(i, 0.0), *alone = open_case(i, WEIGHT);
    uint32_t count = 4 * with->model.moved_columns;
    assert_null(without->step.consistency);
    mask(alone);
    take_gradients(with);
    take_gradients(without);
    take_gradients(alone);
    float *both = test_read(with->step.d_weights), *one = test_read(without->step.d_weights),
          *other = test_read(alone->step.d_weights);
    uint32_t differing = 0;
    for (uint32_t k = 0; k < count; k++) {
        float sum = one[k] + other[k];
        assert_true(sum == both[k]);
        differing += one[k] != both[k];
    }
    assert_true(differing > count / 10);
}

// A step's samples and a picture's may all fall into one entry of the grid.
TEST(words_of_the_grid_hold_both) {
    struct step_case setup = {
        .name = "many rays", .seed = 621, .rays = 700, .samples = 32, .levels = 2, .log2_table = 8};
    for (int with = 0; with < 2; with++) {
        setup.effects = with ? "appearance_encoder" : NULL;
        setup.consistency_weight = with ? WEIGHT : 0.0;
        struct step_bench *bench = step_bench_open(&setup);
        assert_int_equal(bench->model.specialization.wide_gradient, with);
        test_release(bench);
    }
}

// Given photos are those of steps that have been, all of them in time, and the same when asked again.
TEST(given_photos_are_those_of_earlier_steps) {
    struct step_bench *bench = open_case(0, WEIGHT);
    uint32_t seen = 0;
    assert_int_equal(vw_consistency_given_view(&bench->step, 1), vw_photo_order_view_of_step(&bench->photo_order, 1));
    for (uint64_t number = 1; number <= 40; number++) {
        uint32_t view = vw_consistency_given_view(&bench->step, number);
        assert_int_equal(view, vw_consistency_given_view(&bench->step, number));
        seen |= 1u << view;
    }
    assert_int_equal(seen, 3);
}

// ---- Hard cases -----------------------------------------------------------------------------------------------------

// Trains on photos of this size with pictures of so many rays. Every step must be sound.
static void train(struct hard_finding *finding, uint32_t width_px, uint32_t height_px, uint32_t rays, bool masked) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 4, .val_views = 2, .width_px = width_px, .height_px = height_px});
    struct vw_config config = hard_run_config();
    for (uint32_t view = 0; view < 4 && masked; view++) {
        scene->views[view].image.unusable = vw_allocate((size_t)width_px * height_px, 1);
        memset(scene->views[view].image.unusable, 1, (size_t)width_px * height_px);
    }
    strcpy(config.effects, "appearance_encoder");
    config.consistency_weight = 0.1;
    config.rays = rays;
    hard_equal(finding, "flagged steps", 0, hard_train(finding, scene, &config).flagged_steps, 0.0);
}

static void picture_of_one_ray(struct hard_finding *finding) {
    train(finding, 12, 8, 1, false);
    train(finding, 12, 8, 3, false);
}

static void rays_beside_a_picture(struct hard_finding *finding) {
    train(finding, 12, 8, 24, false);
    train(finding, 12, 8, 80, false);
}

static void picture_finer_than_its_photo(struct hard_finding *finding) {
    train(finding, 5, 3, 64, false);
    train(finding, 1, 1, 16, false);
}

// Checks that the picture is rendered all the same.
static void pictures_of_masked_photos(struct hard_finding *finding) { train(finding, 12, 8, 16, true); }

// Checks codes that are the same for all photos and pictures, as before the first step: L1 has no slope there.
static void equal_codes(struct hard_finding *finding) {
    struct step_bench *bench = open_case(0, 1.0);
    float *network = bench->params + vw_encoder_network(&bench->model).offset_bytes / 4;
    memset(network + 4 * ENCODER_CODE, 0, 4 * sizeof *network * (ENCODER_CODE_BIAS - ENCODER_CODE));
    step_bench_write_params(bench);
    step_bench_gradients(bench, 1);
    struct vw_consistency_effect *it = bench->step.consistency;
    float *own = test_read(it->d_weights);
    struct vw_ray *rays = test_read(it->rays);
    for (uint32_t i = 0; i < 4 * bench->model.moved_columns; i++) hard_equal(finding, "gradient", i, own[i], 0.0);
    for (uint32_t i = 0; i < it->padded_rays; i++) hard_equal(finding, "slope", i, rays[i].target_weight.x, 0.0);
}

static const struct hard_case hard[] = {
    {"a picture of one ray", "a thumbnail of one pixel, and padding", picture_of_one_ray},
    {"more rays than a picture has", "rays beside it in its groups", rays_beside_a_picture},
    {"a picture finer than its photo", "cells without a pixel", picture_finer_than_its_photo},
    {"pictures of masked photos", "0 of rays that weigh nothing", pictures_of_masked_photos},
    {"codes that are equal", "a slope of L1 at 0", equal_codes},
};
HARD_CASES("consistency of codes", hard)
