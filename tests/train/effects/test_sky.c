// The learned sky and the random form of the background: what they change in whole trainings, and what they must not.
// Hard cases: rays that see none of it or nothing else, colours at the ends of their range, rays that do not count, the
// axes, and as many rays as a step may have; whole steps held against the reference.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "hard_cases/hard_step.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

static const double UNSEEN =
    1e-30; // a gradient that Adam's epsilon turns into no move: light beyond tau = 87 is cut to 1e-38

static const struct step_case setup = {"sky", .seed = 331, HARD_STEP, .effects = "sky"};

static float *sky_of(struct step_bench *bench) {
    return bench->params + bench->model.ranges[VW_SLOT_SKY].offset_bytes / sizeof(float);
}

static const float *d_sky_of(const struct step_bench *bench, const struct hard_gradients *gradients) {
    return gradients->weights + 4 * (size_t)bench->model.weight_columns;
}

// Aims all rays near the photo's middle, where every ray meets the box.
static void aim_at_the_box(struct step_bench *bench) {
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        bench->pixels[i].x_px = 10.5f + (float)(i % 4);
        bench->pixels[i].y_px = 8.5f + (float)(i / 4 % 4);
    }
    hard_write_pixels(bench);
}

static void opaque_rays(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    aim_at_the_box(bench);
    hard_set_density(bench, 1e6f);
    struct hard_gradients gradients = hard_take_gradients(bench, 1);
    for (uint32_t i = 0; i < 4 * VW_SKY_COLUMNS; i++)
        hard_compare(finding, "gradient of an unseen sky", i, d_sky_of(bench, &gradients)[i], 0.0, 1.0, UNSEEN);
    hard_check_step(finding, bench, 2);
    float *params = test_read(bench->field.params);
    hard_same_bits(finding, "a sky that no ray saw", params + (sky_of(bench) - bench->params), sky_of(bench),
                   bench->model.ranges[VW_SLOT_SKY].size_bytes);
}

static void empty_rays(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    hard_set_density(bench, -1e6f);
    hard_check_step(finding, bench, 1);
    hard_check_rendering(finding, bench);
    float *params = test_read(bench->field.params);
    hard_same_bits(finding, "a field that no light met", params, bench->params,
                   bench->model.ranges[VW_SLOT_SKY].offset_bytes);
    hard_require(finding,
                 memcmp(params + (sky_of(bench) - bench->params), sky_of(bench),
                        bench->model.ranges[VW_SLOT_SKY].size_bytes) != 0,
                 "the sky is learned through empty space");
}

// Checks two channels that are 0 and 1 in every direction, since band 0 alone is large; the third gives the gradient a
// size to be compared with.
static void saturated_colours(struct hard_finding *finding) {
    static const float logits[][3] = {
        {150.0f, -150.0f, 0.0f}, {300.0f, -300.0f, 2.0f}, {1e30f, -1e30f, -2.0f}, {1e36f, -1e36f, 0.0f}};
    struct step_bench *bench = step_bench_open(&setup);
    for (size_t i = 0; i < VW_ARRAY_COUNT(logits); i++) {
        memcpy(sky_of(bench), logits[i], sizeof logits[i]);
        step_bench_write_params(bench);
        hard_check_step(finding, bench, 1);
        hard_check_rendering(finding, bench);
    }
}

// Returns the gradient of a step some of whose pixels are excluded and show `value`.
static struct hard_gradients excluded_gradients(struct step_bench *bench, uint32_t every, float value) {
    for (uint32_t i = 0; i < bench->config.rays; i += every) {
        bench->pixels[i].weight = 0.0f;
        bench->pixels[i].rgba = (vw_float4){value, 1.0f - value, value, 1.0f};
    }
    hard_write_pixels(bench);
    return hard_take_gradients(bench, 1);
}

static void excluded_pixels(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    struct hard_gradients dark = excluded_gradients(bench, 2, 0.0f), bright = excluded_gradients(bench, 2, 1.0f),
                          none = excluded_gradients(bench, 1, 0.5f);
    hard_same_bits(finding, "gradient beside excluded pixels", d_sky_of(bench, &bright), d_sky_of(bench, &dark),
                   bench->model.ranges[VW_SLOT_SKY].size_bytes);
    hard_require(finding, d_sky_of(bench, &dark)[0] != 0.0f, "the other pixels count");
    for (uint32_t i = 0; i < 4 * VW_SKY_COLUMNS; i++)
        hard_equal(finding, "gradient of excluded pixels alone", i, d_sky_of(bench, &none)[i], 0.0);
}

// Rays along +x, -x, +y, ... at which most of the basis is exactly 0.
static void along_the_axes(struct hard_finding *finding) {
    static const double middle[3] = {0.5, 0.5, 0.5};
    struct step_bench *bench = step_bench_open(&setup);
    for (uint32_t i = 0; i < bench->config.rays; i++) {
        bench->pixels[i].view = 0;
        if (i % 2) bench->pixels[i].x_px = 12.0f, bench->pixels[i].y_px = 10.0f; // the middle of the photo
    }
    for (int way = 0; way < 6; way++) {
        double position[3] = {0.5, 0.5, 0.5};
        position[way / 2] += way % 2 ? 3.0 : -3.0;
        rays_look(&bench->scene->views[0], &bench->scene->box, position, middle);
        struct vw_ray *rays = rays_make(bench); // also moves the camera
        const float direction[3] = {rays[1].direction_stride.x, rays[1].direction_stride.y, rays[1].direction_stride.z};
        for (int i = 0; i < 3; i++)
            hard_equal(finding, "direction", 1, direction[i], i == way / 2 ? (way % 2 ? -1.0 : 1.0) : 0.0);
        step_bench_write_params(bench);
        hard_check_step(finding, bench, 1);
        hard_check_rendering(finding, bench);
    }
}

static void most_rays(struct hard_finding *finding) {
    struct step_case many = setup;
    many.rays = 65536;
    many.samples = 1;
    struct step_bench *bench = step_bench_open(&many);
    hard_check_step(finding, bench, 1);
}

// ---- Random backgrounds ---------------------------------------------------------------------------------------------

static void set_alpha(struct step_bench *bench, float alpha) {
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].rgba.w = alpha;
    hard_write_pixels(bench);
}

// Checks that a ray is compared, to the bit, with its own background: seen through an empty field there is no error at
// all.
static void transparent_before_random_colours(struct hard_finding *finding) {
    struct step_case random = setup;
    random.effects = "background";
    random.random_background = true;
    struct step_bench *bench = step_bench_open(&random);
    hard_set_density(bench, -1e6f);
    set_alpha(bench, 0.0f);
    vw_float4 last = {0};
    for (uint64_t number = 1; number <= 3; number++) {
        hard_check_step(finding, bench, number);
        struct vw_ray *rays = test_read(bench->step.ray_buffer);
        float *losses = test_read(bench->step.ray_loss);
        for (uint32_t i = 0; i < bench->config.rays; i++)
            hard_equal(finding, "loss of a ray through nothing", i, losses[i], 0.0);
        hard_require(finding, rays[0].target_weight.x != rays[1].target_weight.x, "every ray has a colour of its own");
        hard_require(finding, rays[0].target_weight.x != rays[0].target_weight.y, "every channel is drawn");
        hard_require(finding, rays[0].target_weight.x != last.x, "every step draws anew");
        last = rays[0].target_weight;
    }
    hard_check_rendering(finding, bench); // before the scene's colour
}

static void opaque_before_random_colours(struct hard_finding *finding) {
    struct step_case random = setup;
    random.effects = "background";
    random.random_background = true;
    struct step_bench *bench = step_bench_open(&random);
    set_alpha(bench, 1.0f);
    hard_check_step(finding, bench, 1);
    struct vw_ray *rays = test_read(bench->step.ray_buffer);
    for (uint32_t i = 0; i < bench->config.rays; i++)
        hard_same_bits(finding, "target of an opaque pixel", &rays[i].target_weight, &bench->pixels[i].rgba,
                       3 * sizeof(float));
}

static const struct hard_case hard[] = {
    {"a sky that no ray reaches", "it moves all the same", opaque_rays},
    {"a sky and nothing before it", "light is lost on the way; the field gets its gradient", empty_rays},
    {"a sky of logits up to 10^35", "exp overflows; inf * 0 in the backward pass", saturated_colours},
    {"a sky in excluded pixels", "what was masked out paints the sky", excluded_pixels},
    {"a sky seen along the axes", "signs and order of the basis, where most of it is 0", along_the_axes},
    {"a sky seen by 65,536 rays", "the sum over rays is cut short or loses the small", most_rays},
    {"transparent pixels before random colours", "target and background are not the same colour",
     transparent_before_random_colours},
    {"opaque pixels before random colours", "the random colour shines through", opaque_before_random_colours},
};

HARD_CASES("sky and background", hard)

// ---- Whole trainings -----------------------------------------------------------------------------------------------

static struct vw_scene *transparent_scene(void) {
    return synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 5, .val_views = TEST_VALS, .width_px = 24, .height_px = 18, .alpha = true});
}

static struct vw_config config_with(const char *effects, enum vw_background_form form) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    config.background = form;
    return config;
}

// A sky takes the background's place, and the targets stay on the scene's colour.
TEST(a_sky_leaves_nothing_to_the_form_of_the_background) {
    struct vw_scene *scene = transparent_scene();
    struct vw_config config = config_with("background,sky", VW_BACKGROUND_FIXED);
    struct test_run *fixed = test_run(scene, &config, true, 0);
    config.background = VW_BACKGROUND_RANDOM;
    struct test_run *random = test_run(scene, &config, true, 0);
    test_run_assert_same(fixed, random);
}

// Renders a view by a trainer with these params.
static float *render_field(const struct vw_scene *scene, const struct vw_config *config, const void *params,
                           uint32_t view) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 0);
    float *rgb = NULL;
    ASSERT_OK(vw_buffer_write(trainer->field.params, 0, params, trainer->model.param_bytes));
    ASSERT_OK(vw_trainer_render(trainer, view, &rgb));
    test_release(trainer);
    return rgb;
}

// Decision 1: the form is training's alone. Submissions change no bit.
TEST(validation_knows_no_form_of_the_background) {
    struct vw_scene *scene = transparent_scene();
    struct vw_config forms[] = {config_with("background", VW_BACKGROUND_FIXED),
                                config_with("background", VW_BACKGROUND_RANDOM)};
    struct test_run *runs[2];
    float *rendered[2];
    for (int i = 0; i < 2; i++) runs[i] = test_run(scene, &forms[i], true, 0);
    for (int i = 0; i < 2; i++) rendered[i] = render_field(scene, &forms[i], runs[1]->params, 5);
    assert_memory_equal(rendered[0], rendered[1], 3 * 24 * 18 * sizeof(float));
    assert_memory_equal(runs[0]->views[0], runs[1]->views[0], sizeof runs[0]->views[0]); // both untrained
    assert_false(test_same_bits(runs[0]->records[1].train_loss, runs[1]->records[1].train_loss));
    test_run_assert_same(runs[1], test_run(scene, &forms[1], true, 7));
}
