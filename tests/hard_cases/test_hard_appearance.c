// Hard photos for gains, biases and codes: black, masked, saturated and of one, two or three columns; halves of
// validation photos that are flat or hold a single usable pixel; and gains by which pixels cannot be divided.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/gpu_fixture.h"
#include "support/synthetic_scene.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"
#include "train/validation/validation.h"

enum {
    WIDTH_PX = 12,
    HEIGHT_PX = 8,
    PIXELS = WIDTH_PX * HEIGHT_PX,
    TRAIN_VIEWS = 5,
    VAL_VIEWS = 3,
    VIEWS = TRAIN_VIEWS + VAL_VIEWS
};

static const double FIT_TOLERANCE =
    2e-5; // for gains, biases and colours of order 1: float sums of up to 3,000 products

static const double TARGET_TOLERANCE = 1e-6; // a division and a difference of floats
static const double PHOTO_TOLERANCE = 1e-4;  // rendered colours are good to 1e-5, and the fit magnifies by up to 10
static const double CENTRE_TOLERANCE = 2e-5; // a quotient of floats, of which a least gain makes 10 at most
static const float LEAST_GAIN = -0.9f;

static const struct step_case setup = {
    .name = "photos of their own", .seed = 371, HARD_STEP, .effects = "appearance,appearance_code"};

static struct vw_scene *scene;

static void open_scene(uint32_t width_px) {
    scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = TRAIN_VIEWS, .val_views = VAL_VIEWS, .width_px = width_px, .height_px = HEIGHT_PX});
}

static struct vw_config config_with(const char *effects) {
    struct vw_config config = hard_run_config();
    strcpy(config.effects, effects);
    return config;
}

// Trains with each form, and with both.
static void train_well(struct hard_finding *finding) {
    static const char *const forms[] = {"appearance", "appearance_code", "appearance,appearance_code"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(forms); i++) {
        struct vw_config config = config_with(forms[i]);
        hard_train_well(finding, scene, &config);
    }
}

// ---- Fits -----------------------------------------------------------------------------------------------------------

// Checks that the device fits hand-made rays of one view (index REDUCED_VIEWS - 1) as the reference does.
static void check_fit(struct hard_finding *finding, struct view_reduction *r, struct step_bench *bench,
                      struct vw_appearance *fit) {
    static double rendered[REDUCED_RAYS], target[REDUCED_RAYS];
    const struct vw_ray_range *range = &reduced_ranges[REDUCED_VIEWS - 1];
    struct vw_push_reduce push = {.count = REDUCED_VIEWS};
    struct vw_appearance fits[REDUCED_VIEWS];
    step_bench_write(bench, r->rays, r->ray_data);
    step_bench_write(bench, r->colours, r->colour_data);
    step_bench_dispatch(bench, r->fit_pass, &push, sizeof push, 64 * REDUCED_VIEWS);
    assert_int_equal(vw_buffer_read(r->fits, 0, fits, sizeof fits), VW_OK);
    *fit = fits[REDUCED_VIEWS - 1];
    for (int c = 0; c < 3; c++) {
        double gain, bias;
        uint32_t count = 0;
        for (uint32_t i = range->first; i < range->first + range->count; i++) {
            if (r->ray_data[i].target_weight.w == 0.0f) continue;
            rendered[count] = (&r->colour_data[i].x)[c];
            target[count++] = (&r->ray_data[i].target_weight.x)[c];
        }
        reference_fit_channel(rendered, target, count, &gain, &bias);
        hard_compare(finding, "fitted gain", (uint64_t)c, (&fit->gain.x)[c], gain, 1.0 + fabs(gain), FIT_TOLERANCE);
        hard_compare(finding, "fitted bias", (uint64_t)c, (&fit->bias.x)[c], bias, 1.0 + fabs(bias), FIT_TOLERANCE);
    }
}

static void fill(struct view_reduction *r, vw_float4 colour, vw_float4 target) {
    for (uint32_t i = 0; i < REDUCED_RAYS; i++) {
        r->colour_data[i] = colour;
        r->ray_data[i].target_weight = target;
    }
}

static void flat_halves(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    struct view_reduction *r = reduction_open(bench->gpu, true);
    struct vw_appearance fit;
    fill(r, (vw_float4){0.5f, 0.0f, 1.0f, 0.0f},
         (vw_float4){0.3f, 0.4f, 1.0f, 1.0f}); // red differs, green is rendered black, blue fits
    check_fit(finding, r, bench, &fit);
    hard_require(finding, fabsf(fit.gain.x) < 0.2f && fabsf((1.0f + fit.gain.x) * 0.5f + fit.bias.x - 0.3f) < 1e-3f,
                 "a flat half is met, with a gain near 1");
    hard_require(finding, fit.gain.y == 0.0f && fabsf(fit.bias.y - 0.4f) < 1e-3f,
                 "where black is rendered, only a bias can help");
    hard_require(finding, fit.gain.z == 0.0f && fit.bias.z == 0.0f, "what fits is left as it is");
    fill(r, (vw_float4){0.5f, 0.5f, 0.5f, 0.0f}, (vw_float4){0.3f, 0.4f, 0.6f, 0.0f}); // no ray counts
    check_fit(finding, r, bench, &fit);
    hard_require(finding, fit.gain.x == 0.0f && fit.bias.x == 0.0f, "without a ray nothing is fitted");
    r->ray_data[2000].target_weight.w = 1.0f;
    check_fit(finding, r, bench, &fit);
    fill(r, (vw_float4){1.0f, 1.0f, 1.0f, 0.0f},
         (vw_float4){1.0f, 0.0f, 1.0f, 1.0f}); // saturated, but for half of the rays
    for (uint32_t i = 0; i < REDUCED_RAYS; i += 2) r->colour_data[i] = (vw_float4){1e-7f, 0.999999f, 1e3f, 0.0f};
    check_fit(finding, r, bench, &fit);

    open_scene(WIDTH_PX);
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++)
        for (uint32_t i = 0; i < PIXELS; i++)
            if (i % WIDTH_PX < WIDTH_PX / 2)
                memcpy((uint8_t *)scene->views[view].image.pixels + 4 * i, (uint8_t[]){90, 0, 255, 255}, 4);
    train_well(finding);
}

// Masks all but one pixel of the left half, in one view even that; the right halves stay.
static void one_usable_pixel(struct hard_finding *finding) {
    open_scene(WIDTH_PX);
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++) {
        scene->views[view].image.unusable = vw_allocate(PIXELS, 1);
        for (uint32_t i = 0; i < PIXELS; i++) scene->views[view].image.unusable[i] = i % WIDTH_PX < WIDTH_PX / 2;
        if (view > TRAIN_VIEWS) scene->views[view].image.unusable[2 * WIDTH_PX + view - TRAIN_VIEWS] = 0;
    }
    train_well(finding);
}

// ---- Widths ---------------------------------------------------------------------------------------------------------

// Checks narrow photos: one column has no halves and is refused by name; two and three are a left and a right column,
// the third is in neither.
static void few_columns(struct hard_finding *finding) {
    for (uint32_t width_px = 1; width_px <= 9; width_px++) {
        open_scene(width_px);
        struct vw_pixel_columns left = vw_view_fit_left_half(scene, 0), right = vw_view_fit_right_half(scene, 0);
        hard_equal(finding, "columns left and right", width_px, left.end - left.begin, right.end - right.begin);
        hard_equal(finding, "columns in both halves or none", width_px, right.begin - left.end, width_px % 2);
        hard_equal(finding, "columns in all", width_px, left.begin == 0 && right.end == width_px, 1.0);
        if (width_px == 2 || width_px == 3) train_well(finding);
    }
    open_scene(1);
    struct vw_config config = config_with("appearance");
    struct vw_trainer *trainer = NULL;
    enum vw_status status = test_trainer_try(
        (struct vw_trainer_params){.gpu = test_gpu(), .scene = scene, .config = &config, .validate = true}, &trainer);
    hard_require(finding,
                 status == VW_ERROR_INPUT && strstr(vw_error_message(), "view_005") &&
                     strstr(vw_error_message(), "right half"),
                 "a photo of one column is refused by name");
}

// ---- Photos ---------------------------------------------------------------------------------------------------------

static struct reference_photo fit_of(const struct vw_photo_sums *sums) {
    struct reference_photo fit = {0};
    for (int c = 0; c < 3; c++) {
        fit.gain[c] = (&sums->gain.x)[c];
        fit.bias[c] = (&sums->bias.x)[c];
    }
    return fit;
}

// Checks what a step makes of the photo against a fit to what the reference renders, with the sums that the device had
// before.
static void check_photo(struct hard_finding *finding, const struct step_bench *bench,
                        const struct reference_step *reference, const struct vw_photo_sums *before,
                        const struct vw_photo_sums *after) {
    struct reference_photo device = fit_of(after), expected = {0};
    struct reference_photo_sums sums = {.rays = before->rendered.w};
    for (int c = 0; c < 3; c++) {
        sums.rendered[c] = (&before->rendered.x)[c];
        sums.squares[c] = (&before->squares.x)[c];
        sums.missing[c] = (&before->missing.x)[c];
        sums.products[c] = (&before->products.x)[c];
    }
    reference_photo_sums_fade(&sums);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++) {
        const vw_float4 rgba = bench->pixels[ray < bench->config.rays ? ray : bench->config.rays - 1].rgba;
        const double shown[3] = {rgba.x, rgba.y, rgba.z};
        reference_photo_sums_add(&sums, reference->rays[ray].weight, reference->colours[ray], shown,
                                 reference->rays[ray].target);
    }
    reference_fit_photo(&sums, &expected);
    for (uint64_t c = 0; c < 3; c++) {
        hard_compare(finding, "gain after the step", c, device.gain[c], expected.gain[c], 1.0, PHOTO_TOLERANCE);
        hard_compare(finding, "bias after the step", c, device.bias[c], expected.bias[c], 1.0, PHOTO_TOLERANCE);
    }
}

// Checks gain and bias by which the photo is corrected against the device's own fits of all photos.
static void check_centred(struct hard_finding *finding, const struct step_bench *bench,
                          const struct vw_photo_sums *sums, const float *params) {
    const struct reference_photo device = reference_photo_of(&bench->model, params, bench->view),
                                 expected = reference_photo_of_fits(sums, bench->scene->view_count, bench->view);
    for (uint64_t c = 0; c < 3; c++) {
        hard_compare(finding, "centred gain", c, device.gain[c], expected.gain[c], 1.0, CENTRE_TOLERANCE);
        hard_compare(finding, "centred bias", c, device.bias[c], expected.bias[c], 1.0, CENTRE_TOLERANCE);
    }
}

// Checks that rays are to show what the photo's pixels show, corrected by numbers as they were before the step.
static void check_targets(struct hard_finding *finding, const struct step_bench *bench,
                          const struct reference_step *reference, const float *params) {
    const struct reference_photo photo = reference_photo_of(&bench->model, params, bench->view);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        double target[3];
        reference_target(&bench->model.specialization, &photo, &bench->pixels[ray], ray, (vw_uint4){0}, target);
        for (int c = 0; c < 3; c++)
            hard_compare(finding, "target", ray, reference->rays[ray].target[c], target[c], 1.0 + fabs(target[c]),
                         TARGET_TOLERANCE);
    }
}

static void write_photos(struct step_bench *bench, float gain, float bias) {
    float *photos = bench->params + bench->model.ranges[VW_SLOT_APPEARANCE].offset_bytes / sizeof(float);
    for (uint32_t i = 0; i < 8 * bench->scene->view_count; i++) photos[i] = i % 4 == 3 ? 0.0f : i % 8 < 4 ? gain : bias;
    step_bench_write_params(bench);
}

static void write_colour(struct step_bench *bench, float colour, float weight) {
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        bench->pixels[i].view = bench->view;
        bench->pixels[i].rgba = (vw_float4){colour, colour, colour, 1.0f};
        bench->pixels[i].weight = weight;
    }
    hard_write_pixels(bench);
}

// Checks steps from photos whose gains and biases are these, on pixels of this colour and weight, beside a photo that
// was visited before; returns the photo's fit after them.
static struct reference_photo step_from(struct hard_finding *finding, float gain, float bias, float colour,
                                        float weight) {
    struct step_bench *bench = step_bench_open(&setup);
    struct vw_buffer *sum_buffer = bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS];
    struct vw_photo_sums *sums_after = step_bench_read(bench, sum_buffer);
    sums_after[1 - bench->view] =
        (struct vw_photo_sums){.gain = {0.5f, 0.25f, -0.25f, 7.0f}, .bias = {0.1f, 0, -0.1f, 0}};
    step_bench_write(bench, sum_buffer, sums_after);
    write_photos(bench, gain, bias);
    write_colour(bench, colour, weight);
    for (uint64_t number = 1; number <= 5; number++) { // from the fourth on, fits are taken
        float *before = step_bench_read(bench, bench->field.params);
        struct vw_photo_sums *sums = step_bench_read(bench, sum_buffer);
        struct reference_step *reference = hard_check_step(finding, bench, number);
        sums_after = step_bench_read(bench, sum_buffer);
        hard_same_bits(finding, "sums of another photo", &sums_after[1 - bench->view], &sums[1 - bench->view],
                       sizeof *sums);
        check_targets(finding, bench, reference, before);
        check_photo(finding, bench, reference, &sums[bench->view], &sums_after[bench->view]);
        check_centred(finding, bench, sums_after, step_bench_read(bench, bench->field.params));
    }
    return fit_of(&sums_after[bench->view]);
}

static void paint(uint32_t view, uint8_t value) {
    for (uint32_t i = 0; i < 4 * PIXELS; i++)
        ((uint8_t *)scene->views[view].image.pixels)[i] = i % 4 == 3 ? 255 : value;
}

// Checks that a nearly black photo comes to the least gain, by which pixels can still be divided, and back from it; and
// that a black one, which may be clipped, tells nothing.
static void gain_of_zero(struct hard_finding *finding) {
    struct reference_photo photo = step_from(finding, 0.0f, 0.0f, 0.015f, 1.0f);
    hard_require(finding, photo.gain[0] < -0.5 && photo.gain[0] >= LEAST_GAIN, "a dark photo's gain stops near 0");
    photo = step_from(finding, 0.0f, 0.0f, 0.0f, 1.0f);
    hard_require(finding, photo.gain[0] == 0.0 && photo.bias[0] == 0.0, "a black photo is as it is");
    step_from(finding, LEAST_GAIN, 0.25f, 0.0f, 1.0f);
    photo = step_from(finding, LEAST_GAIN, 0.0f, 0.5f, 1.0f);
    hard_require(finding, photo.gain[0] > -0.5, "a gain comes back");
    open_scene(WIDTH_PX);
    paint(0, 0);
    paint(TRAIN_VIEWS, 0);
    train_well(finding);
}

static void masked_photo(struct hard_finding *finding) {
    const struct reference_photo photo = step_from(finding, 0.25f, 0.125f, 0.5f, 0.0f);
    hard_require(finding, photo.gain[0] == 0.0 && photo.bias[0] == 0.0, "a photo of which nothing is seen is as it is");
    open_scene(WIDTH_PX);
    scene->views[1].image.unusable = vw_allocate(PIXELS, 1);
    memset(scene->views[1].image.unusable, 1, PIXELS);
    train_well(finding);
}

static void saturated_photos(struct hard_finding *finding) {
    step_from(finding, 1.0f, 0.3f, 1.0f, 1.0f);
    open_scene(WIDTH_PX);
    for (uint32_t view = 0; view < VIEWS; view++) paint(view, 255);
    train_well(finding);
}

// Checks a step from photos whose gains and biases are these; a photo for which it is taken is as others after it.
static void one_step_from(struct hard_finding *finding, float gain, float bias) {
    struct step_bench *bench = step_bench_open(&setup);
    write_photos(bench, gain, bias);
    write_colour(bench, 0.5f, 1.0f);
    const struct hard_gradients gradients = hard_take_gradients(bench, 1);
    const struct hard_state before = hard_state_read(bench);
    step_bench_step(bench, 1);
    const struct hard_state after = hard_state_read(bench);
    const struct reference_photo photo = reference_photo_of(&bench->model, after.grid.grid, bench->view);
    hard_require(finding, !after.skipped, "a corrected colour stays between black and white, and the loss finite");
    hard_check_update(finding, bench, 1, &gradients, &before, &after);
    for (int c = 0; c < 3; c++)
        hard_require(finding, fabs(photo.gain[c]) < 1.0 && fabs(photo.bias[c]) < 1.0, "a huge gain comes back at once");
    test_release(bench);
}

// Checks gains by which pixels become next to 0, and biases far beyond white.
static void huge_gains(struct hard_finding *finding) {
    const float gains[] = {1e8f, -1e8f, 1e30f, 3e38f};
    const float biases[] = {1e8f, 1e30f, -3e38f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(gains); i++) one_step_from(finding, gains[i], 0.0f);
    for (size_t i = 0; i < VW_ARRAY_COUNT(biases); i++) one_step_from(finding, 0.0f, biases[i]);
}

static const struct hard_case cases[] = {
    {"flat left half, or no ray in it", "0/0 in the fit; gains of anything", flat_halves},
    {"one usable pixel in the left half", "a fit of two numbers to one", one_usable_pixel},
    {"validation photos of 1, 2 and 3 columns", "columns in both halves, or halves of none", few_columns},
    {"gain of zero: a black photo", "pixels divided by 0; a gain that never comes back", gain_of_zero},
    {"all pixels of a photo masked", "0/0 in the fit of the photo", masked_photo},
    {"saturated colours", "gains that grow without end", saturated_photos},
    {"gains and biases of 10^8 to 10^38", "targets and losses that are not finite", huge_gains},
};

int main(void) { return hard_cases_run("appearance", cases, VW_ARRAY_COUNT(cases)); }
