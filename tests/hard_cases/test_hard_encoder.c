// Hard photos for the encoder of the effect appearance_encoder: all masked, of one colour, of one pixel; and networks
// that are dead, or beyond the floats.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/encoder_check.h"
#include "support/synthetic_scene.h"
#include "train/effects/appearance_encoder.h"

static const struct step_case setup = {.name = "encoder",
                                       .seed = 521,
                                       .rays = 32,
                                       .samples = 16,
                                       .levels = 4,
                                       .log2_table = 8,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .effects = "appearance_encoder"};

static struct vw_scene *scene;

static void make_scene(uint32_t width_px, uint32_t height_px) {
    scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 4, .val_views = 2, .width_px = width_px, .height_px = height_px});
}

// Checks the encoder's part of a step on photo 1 of the scene; then trains on the scene.
static void check_photo(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_thumbnail_choice whole = {vw_pixels_all_columns(scene, 1), true};
    assert_int_equal(vw_encoder_set_thumbnail(&bench->field, scene, 1, &whole), VW_OK);
    encoder_check(finding, bench, 1);
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "appearance_encoder");
    struct hard_run run = hard_train(finding, scene, &config);
    hard_equal(finding, "flagged steps", 0, run.flagged_steps, 0.0);
}

// Checks that a masked photo's thumbnail is 0, and so the same as that of a photo of nothing but transparency.
static void masked_photo(struct hard_finding *finding) {
    static vw_float4 thumbnail[THUMBNAIL_PIXELS];
    static const vw_float4 nothing[THUMBNAIL_PIXELS];
    make_scene(12, 8);
    scene->views[1].image.unusable = vw_allocate(12 * 8, 1);
    memset(scene->views[1].image.unusable, 1, 12 * 8);
    vw_thumbnail_make(&scene->views[1], &(struct vw_thumbnail_choice){vw_pixels_all_columns(scene, 1), true},
                      thumbnail);
    hard_same_bits(finding, "thumbnail", thumbnail, nothing, sizeof nothing);
    check_photo(finding);
}

static void photos_of_one_colour(struct hard_finding *finding) {
    make_scene(12, 8);
    for (uint32_t view = 0; view < scene->view_count; view++)
        memset(scene->views[view].image.pixels, view % 2 ? 255 : 0, (size_t)12 * 8 * 4);
    check_photo(finding);
}

static void photos_of_one_pixel(struct hard_finding *finding) {
    make_scene(1, 1);
    check_photo(finding);
}

static float *network_of(struct step_bench *bench) {
    return bench->params + vw_encoder_network(&bench->model).offset_bytes / 4;
}

// Checks convolutions no unit of which is above 0: the code is that of the biases, which alone have gradients before
// it.
static void dead_units(struct hard_finding *finding) {
    static const uint32_t biases[] = {ENCODER_LAYER2 - ENCODER4, ENCODER_LAYER3 - ENCODER4, ENCODER_CODE - ENCODER4};
    for (size_t layer = 0; layer < VW_ARRAY_COUNT(biases); layer++) {
        struct step_bench *bench = step_bench_open(&setup);
        float *network = network_of(bench);
        for (uint32_t i = 0; i < 4 * ENCODER4; i++) network[4 * biases[layer] + i] = -1e3f;
        step_bench_write_params(bench);
        encoder_check(finding, bench, 1);
        float *d_weights = step_bench_read(bench, bench->step.d_weights),
              *own = d_weights + 4 * (size_t)bench->model.specialization.encoder_column;
        double most = 0.0;
        for (uint32_t i = 0; i < 4 * biases[layer]; i++) hard_equal(finding, "gradient before it", i, own[i], 0.0);
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) most = fmax(most, fabs(own[4 * ENCODER_CODE_BIAS + k]));
        hard_require(finding, most > 0.0, "biases of the code have a gradient");
        test_release(bench);
    }
}

// Codes that are not finite make colours that are not: the step is skipped and says so.
static void check_infinite_codes(struct hard_finding *finding, struct step_bench *bench) {
    float *network = network_of(bench);
    for (uint32_t k = 0; k < REFERENCE_CODE; k++) network[4 * ENCODER_CODE_BIAS + k] = 3e38f;
    for (uint32_t i = 0; i < 16 * CODE4 * bench->model.specialization.width4; i++)
        network[4 * ENCODER_SHIFT + i] = i % 2 ? 1e3f : -1e3f;
    step_bench_write_params(bench);
    step_bench_step(bench, 1);
    struct hard_state after = hard_state_read(bench);
    hard_require(finding, after.skipped, "the step is skipped");
    hard_require(finding, after.scalars.z != 0.0f, "the step is flagged");
    hard_same_bits(finding, "params of a skipped step", after.grid.grid, bench->params, bench->model.param_bytes);
}

static void infinite_codes(struct hard_finding *finding) { check_infinite_codes(finding, step_bench_open(&setup)); }

// ---- The consistency loss -------------------------------------------------------------------------------------------

// Trains for two epochs with the consistency loss. Every step must be sound.
static void train_consistently(struct hard_finding *finding, uint32_t rays) {
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "appearance_encoder");
    config.consistency_weight = 0.1;
    config.rays = rays;
    struct hard_run run = hard_train(finding, scene, &config);
    hard_equal(finding, "flagged steps", 0, run.flagged_steps, 0.0);
}

static void picture_of_one_ray(struct hard_finding *finding) {
    make_scene(12, 8);
    train_consistently(finding, 1);
    train_consistently(finding, 3);
}

static void rays_beside_a_picture(struct hard_finding *finding) {
    make_scene(12, 8);
    train_consistently(finding, 24);
    train_consistently(finding, 80);
}

static void picture_finer_than_its_photo(struct hard_finding *finding) {
    make_scene(5, 3);
    train_consistently(finding, 64);
    make_scene(1, 1);
    train_consistently(finding, 16);
}

// Checks that the picture is rendered all the same.
static void pictures_of_masked_photos(struct hard_finding *finding) {
    make_scene(12, 8);
    for (uint32_t view = 0; view < 4; view++) {
        scene->views[view].image.unusable = vw_allocate(12 * 8, 1);
        memset(scene->views[view].image.unusable, 1, 12 * 8);
    }
    train_consistently(finding, 16);
}

static struct step_bench *open_consistent(void) {
    struct step_case consistent = setup;
    consistent.consistency_weight = 1.0;
    return step_bench_open(&consistent);
}

// Checks codes that are the same for all photos and pictures, as before the first step: L1 has no slope there.
static void equal_codes(struct hard_finding *finding) {
    struct step_bench *bench = open_consistent();
    float *network = network_of(bench);
    memset(network + 4 * ENCODER_CODE, 0, 4 * sizeof *network * (ENCODER_CODE_BIAS - ENCODER_CODE));
    step_bench_write_params(bench);
    step_bench_gradients(bench, 1);
    struct vw_consistency_effect *it = bench->step.consistency;
    float *own = step_bench_read(bench, it->d_weights);
    struct vw_ray *rays = step_bench_read(bench, it->rays);
    for (uint32_t i = 0; i < 4 * bench->model.moved_columns; i++) hard_equal(finding, "gradient", i, own[i], 0.0);
    for (uint32_t i = 0; i < it->padded_rays; i++) hard_equal(finding, "slope", i, rays[i].target_weight.x, 0.0);
}

static void infinite_codes_of_pictures(struct hard_finding *finding) {
    check_infinite_codes(finding, open_consistent());
}

static const struct hard_case cases[] = {
    {"all pixels of a photo masked", "a mean over nothing", masked_photo},
    {"photos of one colour", "0/0 where nothing differs", photos_of_one_colour},
    {"photos of one pixel", "a pixel that fills all of a thumbnail", photos_of_one_pixel},
    {"units that are never above 0", "0/0 in Adam; a code that cannot move", dead_units},
    {"codes beyond the floats", "a step that no flag tells", infinite_codes},
    {"a picture of one ray", "a thumbnail of one pixel, and padding", picture_of_one_ray},
    {"more rays than a picture has", "rays beside it in its groups", rays_beside_a_picture},
    {"a picture finer than its photo", "cells without a pixel", picture_finer_than_its_photo},
    {"pictures of masked photos", "0 of rays that weigh nothing", pictures_of_masked_photos},
    {"codes that are equal", "a slope of L1 at 0", equal_codes},
    {"codes beyond the floats, of pictures", "a step that no flag tells", infinite_codes_of_pictures},
};

int main(void) { return hard_cases_run("encoder", cases, VW_ARRAY_COUNT(cases)); }
