// The effect appearance_encoder: thumbnails and its passes against the reference, with both fields, and the reference's
// gradient against finite differences. What its code does to a field is held against the same weights without it. In
// whole trainings every view has the code of its own photo, and whole views show it their left halves alone. Hard
// cases: photos that are masked, of one colour or of one pixel; networks that are dead, or beyond the floats.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/text.h"
#include "gpu/compute.h"
#include "hard_cases/hard_step.h"
#include "support/encoder_check.h"
#include "support/trainer_fixture.h"
#include "train/effects/appearance_encoder.h"
#include "train/trainer.h"

static const struct step_case cases[] = {
    {"hash", .seed = 501, .rays = 16, .samples = 16},
    {"hash, 7 samples, as on GPUs", .seed = 502, .rays = 30, .samples = 7, .width = 64, .levels = 2, .loss = VW_LOSS_L2,
     .as_on_gpus = true, .effects = "background"},
    {"hash, other effects", .seed = 503, .rays = 16, .samples = 16, .width = 16, .loss = VW_LOSS_HUBER,
     .effects = "sky,visibility"},
    {"mlp", .seed = 504, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 40, .rays = 16, .samples = 16},
    {"mlp, transients", .seed = 505, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 24, .rays = 16, .samples = 16,
     .loss = VW_LOSS_L2, .effects = "transient"},
};

static struct step_bench *open_case(size_t index, bool with) {
    struct step_case setup = cases[index];
    if (with) setup.another_effect = "appearance_encoder";
    return step_bench_open(&setup);
}

TEST_CASES(passes_are_the_references, i, VW_ARRAY_COUNT(cases)) {
    struct step_bench *bench = open_case(i, true);
    struct hard_finding finding = {.where = bench->where};
    encoder_check(&finding, bench, 3);
}

// ---- Thumbnails -----------------------------------------------------------------------------------------------------

static void check_thumbnail(uint32_t width_px, uint32_t height_px, bool masked) {
    static double expected[THUMBNAIL_PIXELS][4];
    static vw_float4 found[THUMBNAIL_PIXELS];
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 2, .val_views = 1, .width_px = width_px, .height_px = height_px, .alpha = true});
    struct vw_view *view = &scene->views[1];
    if (masked) view->mask = vw_allocate((size_t)width_px * height_px, 1); // bytes to be chosen
    for (uint32_t i = 0; masked && i < width_px * height_px; i++) view->mask[i] = i % 3 ? VW_MASK_KEEP : VW_MASK_HIDE;
    for (int half = 0; half < 2; half++) {
        const struct vw_thumbnail_choice choice = {{half ? width_px / 2 : 0, width_px}, half == 0};
        vw_thumbnail_make(view, &choice, found);
        reference_thumbnail(view, choice.columns.begin, width_px, choice.masks, expected);
        for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
            check_value("thumbnail", "red", i, found[i].x, expected[i][0], 1e-6);
            check_value("thumbnail", "green", i, found[i].y, expected[i][1], 1e-6);
            check_value("thumbnail", "blue", i, found[i].z, expected[i][2], 1e-6);
            check_value("thumbnail", "share that counts", i, found[i].w, expected[i][3], 1e-6);
        }
    }
}

TEST(thumbnails_are_area_means) {
    check_thumbnail(64, 96, false);
    check_thumbnail(37, 50, true);
    check_thumbnail(5, 3, true);
    check_thumbnail(1, 1, false);
}

// ---- Finite differences ---------------------------------------------------------------------------------------------

// A photo as the reference encodes it, with the gradient by the shift that its loss has.
struct encoding {
    double *network;
    uint32_t width;
    double d_shift[REFERENCE_WIDTH_MAX];
    struct reference_photo_encoding *photo;
};

static double loss_of(void *of) {
    const struct encoding *it = of;
    double loss = 0.0;
    reference_encode_photo(it->network, it->width, it->photo);
    for (uint32_t unit = 0; unit < it->width; unit++) loss += it->d_shift[unit] * it->photo->shift[unit];
    return loss;
}

TEST(the_references_gradient_is_the_slope) {
    struct step_bench *bench = open_case(0, true);
    struct test_random random = {.seed = 77};
    struct encoding it = {.width = 4 * bench->model.specialization.width4,
                          .network = encoder_network(bench, bench->params)};
    const uint32_t columns[] = {
        0, ENCODER_LAYER2, ENCODER_LAYER3, ENCODER_CODE, ENCODER_SHIFT, VW_ENCODER_COLUMNS(it.width / 4)};
    const struct slope_check check = {bench->where, loss_of, &it, 1e-7, 1e-3, 0.0};
    double *exact = test_allocate(4 * (size_t)columns[5], sizeof *exact);
    it.photo = encoder_reference(bench, it.network, 1);
    for (uint32_t i = 0; i < it.width; i++) it.d_shift[i] = test_random_next(&random);
    reference_encode_photo_gradient(it.network, it.width, it.photo, it.d_shift, exact);
    for (int part = 0; part < 5; part++) {
        size_t first = 4 * (size_t)columns[part], count = 4 * (size_t)columns[part + 1] - first;
        float *gradient = test_allocate(count, sizeof *gradient);
        for (size_t i = 0; i < count; i++) gradient[i] = (float)exact[first + i];
        assert_true(check_slope(&check, "part of the network", it.network + first, gradient, count) > 0.0);
    }
}

// ---- What the code does to a field ----------------------------------------------------------------------------------

// Sets the params of `without` to those of `with`, whose code is added to the weights that it shifts.
static void fold_code(struct step_bench *with, struct step_bench *without) {
    const struct vw_specialization *s = &with->model.specialization;
    float *shift = test_read(with->field.effect_buffers[VW_SLOT_CODE_SHIFT]), *params = without->params;
    memcpy(params, with->params, with->model.weights.offset_bytes + 16 * (size_t)s->encoder_column);
    params += with->model.weights.offset_bytes / sizeof *params;
    for (uint32_t unit = 0; unit < 4 * s->width4; unit++)
        params[4 * (s->shift_column + s->shift_stride * (unit / 4)) + unit % 4] += shift[unit];
    step_bench_write_params(without);
}

static void render(struct step_bench *bench, vw_float4 *colours) {
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    assert_int_equal(vw_evaluator_render(evaluator, bench->pixels, bench->config.rays, colours), VW_OK);
}

// Photos 0 and 1 of a bench have half of the rays each. A step takes photo 1's code; renders take each its own.
TEST_CASES(codes_shift_the_colour_network, i, VW_ARRAY_COUNT(cases)) {
    if (vw_word_list_has(cases[i].effects, "visibility") || vw_word_list_has(cases[i].effects, "transient"))
        return; // their params lie elsewhere without the effect
    struct step_bench *with = open_case(i, true), *without = open_case(i, false);
    uint32_t rays = with->config.rays;
    vw_float4 *seen = test_allocate(rays, sizeof *seen), *expected = test_allocate(rays, sizeof *expected);
    memcpy(without->pixels, with->pixels, rays * sizeof *with->pixels);
    memcpy(vw_buffer_map(without->pixel_buffer), with->pixels, rays * sizeof *with->pixels);
    step_bench_gradients(with, 3);
    fold_code(with, without);
    step_bench_gradients(without, 3);
    float *losses = test_read(with->step.ray_loss), *losses_without = test_read(without->step.ray_loss);
    check_same_bits(with->where, "losses", losses, losses_without, rays * sizeof *losses);
    render(with, seen); // ends with photo 0's code
    for (uint32_t view = 0; view < 2; view++) {
        fold_code(with, without);
        render(without, expected);
        for (uint32_t ray = 0; ray < rays; ray++)
            if (with->pixels[ray].view == view)
                check_same_bits(with->where, "colour", &seen[ray], &expected[ray], sizeof *seen);
        step_bench_gradients(with, 3); // photo 1's code
    }
}

// ---- Codes of views -------------------------------------------------------------------------------------------------

static struct vw_trainer *train(const struct vw_scene *scene, const struct vw_config *config) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    test_run_of(trainer);
    return trainer;
}

static void read_colours(struct vw_trainer *trainer, vw_float4 *colours, uint32_t count) {
    struct vw_evaluator *evaluator = &trainer->validation.evaluator;
    ASSERT_OK(vw_evaluator_run(evaluator));
    ASSERT_OK(vw_buffer_read(evaluator->colours, 0, colours, count * sizeof *colours));
}

// Views whose rays fill no whole groups: validation sees each pixel as a render of its view does, and another photo's
// thumbnail changes its own view alone.
TEST(every_view_has_the_code_of_its_photo) {
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_SPLATS; field++) { // splats have no encoder
        struct vw_config config = test_config_of(field);
        strcpy(config.effects, "appearance_encoder");
        config.val_rays = 101;
        config.samples = 7;
        struct vw_trainer *trainer = train(scene, &config);
        uint32_t count = trainer->validation.ray_count, changed = 0;
        vw_float4 *before = test_allocate(count, sizeof *before), *after = test_allocate(count, sizeof *after),
                  colour = {0};
        const struct vw_pixel *pixels = vw_buffer_map(trainer->validation.evaluator.pixels);
        struct vw_evaluator one = {0};
        ASSERT_OK(vw_evaluator_create(&trainer->field, 1, false, &one));
        read_colours(trainer, before, count);
        for (uint32_t i = 0; i < count; i += 5) {
            ASSERT_OK(vw_evaluator_render(&one, &pixels[i], 1, &colour));
            assert_memory_equal(&colour, &before[i], sizeof colour);
        }
        uint32_t view = trainer->validation.views[1];
        const struct vw_thumbnail_choice corner = {{0, 1}, true};
        ASSERT_OK(vw_encoder_set_thumbnail(&trainer->field, scene, view, &corner));
        read_colours(trainer, after, count);
        for (uint32_t i = 0; i < count; i++) {
            bool differs = memcmp(&before[i], &after[i], sizeof *before) != 0;
            if (pixels[i].view != view) assert_false(differs);
            changed += differs;
        }
        assert_true(changed > 20);
        vw_evaluator_destroy(&one);
        test_release(trainer);
    }
}

static void brighten(struct vw_scene *scene, uint32_t view, uint32_t first, uint32_t end) {
    const struct vw_image *image = &scene->views[view].image;
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++)
        if (i % image->width_px >= first && i % image->width_px < end) memset((uint8_t *)image->pixels + 4 * i, 250, 3);
}

// The render depends on the left half alone; afterwards the whole photo is seen again.
TEST(whole_views_show_their_left_halves) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_with("appearance_encoder");
    struct vw_trainer *trainer = train(scene, &config);
    struct vw_whole_view seen[3] = {0};
    float *renders[2] = {NULL};
    uint32_t view = trainer->validation.views[0], width = scene->views[view].image.width_px,
             count = width * scene->views[view].image.height_px;
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[0]));
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &seen[0]));
    ASSERT_OK(vw_trainer_render(trainer, view, &renders[1]));
    assert_memory_equal(renders[0], renders[1], 3 * count * sizeof *renders[0]);
    brighten(scene, view, width / 2 + 1, width);
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &seen[1]));
    assert_memory_equal(seen[0].rendered, seen[1].rendered, 3 * count * sizeof *seen[0].rendered);
    assert_true(seen[0].error.mse != seen[1].error.mse);
    brighten(scene, view, 0, width / 2);
    ASSERT_OK(vw_trainer_measure_whole(trainer, NULL, view, &seen[2]));
    assert_memory_not_equal(seen[0].rendered, seen[2].rendered, 3 * count * sizeof *seen[0].rendered);
    for (uint32_t i = 0; i < count; i++) assert_int_equal(seen[0].counts[i], i % width >= (width + 1) / 2);
    for (int i = 0; i < 3; i++) vw_whole_view_free(&seen[i]);
    free(renders[0]);
    free(renders[1]);
}

// ---- Hard cases -----------------------------------------------------------------------------------------------------

static const struct step_case setup = {.name = "encoder",
                                       .seed = 521,
                                       .rays = 32,
                                       .samples = 16,
                                       .levels = 4,
                                       .log2_table = 8,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .effects = "appearance_encoder"};

// Checks the encoder's part of a step on photo 1 of the scene.
static void check_photo(struct hard_finding *finding, struct vw_scene *scene) {
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_thumbnail_choice whole = {vw_pixels_all_columns(scene, 1), true};
    assert_int_equal(vw_encoder_set_thumbnail(&bench->field, scene, 1, &whole), VW_OK);
    encoder_check(finding, bench, 1);
}

static struct vw_scene *make_scene(uint32_t width_px, uint32_t height_px) {
    return synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 4, .val_views = 2, .width_px = width_px, .height_px = height_px});
}

// Checks that a masked photo's thumbnail is 0, and so the same as that of a photo of nothing but transparency.
static void masked_photo(struct hard_finding *finding) {
    static vw_float4 thumbnail[THUMBNAIL_PIXELS];
    static const vw_float4 nothing[THUMBNAIL_PIXELS];
    struct vw_scene *scene = make_scene(12, 8);
    scene->views[1].image.unusable = vw_allocate(12 * 8, 1);
    memset(scene->views[1].image.unusable, 1, 12 * 8);
    vw_thumbnail_make(&scene->views[1], &(struct vw_thumbnail_choice){vw_pixels_all_columns(scene, 1), true},
                      thumbnail);
    hard_same_bits(finding, "thumbnail", thumbnail, nothing, sizeof nothing);
    check_photo(finding, scene);
}

static void photos_of_one_colour(struct hard_finding *finding) {
    struct vw_scene *scene = make_scene(12, 8);
    memset(scene->views[1].image.pixels, 255, (size_t)12 * 8 * 4);
    check_photo(finding, scene);
}

static void photos_of_one_pixel(struct hard_finding *finding) { check_photo(finding, make_scene(1, 1)); }

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
        float *d_weights = test_read(bench->step.d_weights),
              *own = d_weights + 4 * (size_t)bench->model.specialization.encoder_column;
        double most = 0.0;
        for (uint32_t i = 0; i < 4 * biases[layer]; i++) hard_equal(finding, "gradient before it", i, own[i], 0.0);
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) most = fmax(most, fabs(own[4 * ENCODER_CODE_BIAS + k]));
        hard_require(finding, most > 0.0, "biases of the code have a gradient");
        test_release(bench);
    }
}

// Checks that codes that are not finite, which make colours that are not, skip the step, also where pictures take part.
static void infinite_codes(struct hard_finding *finding) {
    for (int consistent = 0; consistent < 2; consistent++) {
        struct step_case c = setup;
        c.consistency_weight = consistent;
        struct step_bench *bench = step_bench_open(&c);
        float *network = network_of(bench);
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) network[4 * ENCODER_CODE_BIAS + k] = 3e38f;
        for (uint32_t i = 0; i < 16 * CODE4 * bench->model.specialization.width4; i++)
            network[4 * ENCODER_SHIFT + i] = i % 2 ? 1e3f : -1e3f;
        step_bench_check_skipped(bench, 1);
        hard_require(finding, hard_state_read(bench).skipped, "the step is skipped");
        hard_equal(finding, "flag", 0, hard_state_read(bench).scalars.z, 1.0);
        test_release(bench);
    }
}

static const struct hard_case hard[] = {
    {"all pixels of a photo masked", "a mean over nothing", masked_photo},
    {"photos of one colour", "0/0 where nothing differs", photos_of_one_colour},
    {"photos of one pixel", "a pixel that fills all of a thumbnail", photos_of_one_pixel},
    {"units that are never above 0", "0/0 in Adam; a code that cannot move", dead_units},
    {"codes beyond the floats", "a step that no flag tells", infinite_codes},
};
HARD_CASES("encoder", hard)
