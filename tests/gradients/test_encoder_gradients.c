// The effect appearance_encoder: thumbnails against the reference, its passes, with both fields, and the reference's
// gradient against finite differences. What its code does to a field is held against the same weights without it.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/text.h"
#include "support/encoder_check.h"
#include "support/gpu_fixture.h"
#include "train/effects/appearance_encoder.h"

static const struct step_case cases[] = {
    {.name = "hash", .seed = 501, .rays = 16, .samples = 16},
    {.name = "hash, 7 samples, as on GPUs",
     .seed = 502,
     .rays = 30,
     .samples = 7,
     .width = 64,
     .levels = 2,
     .loss = VW_LOSS_L2,

     .as_on_gpus = true,
     .effects = "background"},
    {.name = "hash, other effects",
     .seed = 503,
     .rays = 16,
     .samples = 16,
     .width = 16,

     .loss = VW_LOSS_HUBER,
     .effects = "sky,visibility"},
    {.name = "mlp", .seed = 504, .field = VW_FIELD_MLP, .mlp_depth = 2, .width = 40, .rays = 16, .samples = 16},
    {.name = "mlp, transients",
     .seed = 505,
     .field = VW_FIELD_MLP,
     .mlp_depth = 2,
     .width = 24,
     .rays = 16,
     .samples = 16,
     .loss = VW_LOSS_L2,
     .effects = "transient"},
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

// Returns a loss whose gradient by the shift is d_shift, or NaN where a ReLU switches.
static double moved_loss(double *network, uint32_t width, uint64_t at, double by, const double *d_shift,
                         const struct reference_photo_encoding *here, struct reference_photo_encoding *moved) {
    double kept = network[at], loss = 0.0;
    network[at] += by;
    reference_encode_photo(network, width, moved);
    network[at] = kept;
    for (uint32_t layer = 0; layer < ENCODER_LAYERS; layer++)
        for (uint32_t i = 0; i < (uint32_t)REFERENCE_ENCODER_OUTPUTS >> 2 * layer; i++)
            if ((moved->outputs[layer][i] > 0.0) != (here->outputs[layer][i] > 0.0)) return NAN;
    for (uint32_t unit = 0; unit < width; unit++) loss += d_shift[unit] * moved->shift[unit];
    return loss;
}

// Checks every 13th number, with --full all of them. At most one in ten may stand at a kink.
TEST(the_references_gradient_is_the_slope) {
    const double STEP = 1e-6, TOLERANCE = 1e-6;
    struct step_bench *bench = open_case(0, true);
    struct test_random random = {.seed = 77};
    uint32_t width = 4 * bench->model.specialization.width4, step = test_is_full() ? 1 : 13, skipped = 0, taken = 0;
    size_t count = 4 * (size_t)VW_ENCODER_COLUMNS(width / 4);
    double *network = encoder_network(bench, bench->params), *gradient = test_allocate(count, sizeof *gradient),
           d_shift[REFERENCE_WIDTH_MAX];
    struct reference_photo_encoding *here = encoder_reference(bench, network, 1),
                                    *moved = test_allocate(1, sizeof *moved);
    *moved = *here;
    for (uint32_t i = 0; i < width; i++) d_shift[i] = test_random_next(&random);
    reference_encode_photo_gradient(network, width, here, d_shift, gradient);
    double scale = largest(gradient, count);
    for (uint64_t i = 0; i < count; i += step, taken++) {
        double ahead = moved_loss(network, width, i, STEP, d_shift, here, moved),
               behind = moved_loss(network, width, i, -STEP, d_shift, here, moved);
        skipped += isnan(ahead - behind);
        if (!isnan(ahead - behind))
            check_value("difference", "number", i, gradient[i], (ahead - behind) / (2.0 * STEP), TOLERANCE * scale);
    }
    print_message("%u of %u numbers at kinks\n", skipped, taken);
    assert_true(10 * skipped <= taken);
}

// ---- What the code does to a field ----------------------------------------------------------------------------------

// Sets the params of `without` to those of `with`, whose code is added to the weights that it shifts.
static void fold_code(struct step_bench *with, struct step_bench *without) {
    const struct vw_specialization *s = &with->model.specialization;
    float *shift = step_bench_read(with, with->field.effect_buffers[VW_SLOT_CODE_SHIFT]), *params = without->params;
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
    float *losses = step_bench_read(with, with->step.ray_loss),
          *losses_without = step_bench_read(without, without->step.ray_loss);
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

TEST_GROUP(NULL, test_gpu_close)
