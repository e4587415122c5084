// Hard photos: whole runs of every effect of the registry on photos of one colour, of one pixel, masked, all the same
// or nearly empty, held against the reference by the errors of their last validation; and steps that match perfectly.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/synthetic_scene.h"
#include "train/effects/registry.h"

enum {
    WIDTH_PX = 12,
    HEIGHT_PX = 8,
    PIXELS = WIDTH_PX * HEIGHT_PX,
    TRAIN_VIEWS = 5,
    VAL_VIEWS = 3,
    VIEWS = TRAIN_VIEWS + VAL_VIEWS
};

static struct vw_scene *open_scene(uint32_t width_px, uint32_t height_px, bool alpha) {
    return synthetic_scene(&(struct synthetic_scene_params){.train_views = TRAIN_VIEWS,
                                                            .val_views = VAL_VIEWS,
                                                            .width_px = width_px,
                                                            .height_px = height_px,
                                                            .alpha = alpha});
}

static void paint(struct vw_scene *scene, uint32_t view, const uint8_t rgba[4]) {
    const struct vw_image *image = &scene->views[view].image;
    for (uint32_t i = 0; i < image->width_px * image->height_px; i++) memcpy((uint8_t *)image->pixels + 4 * i, rgba, 4);
}

static struct vw_scene *open_painted(uint8_t red, uint8_t green, uint8_t blue) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    for (uint32_t view = 0; view < VIEWS; view++) paint(scene, view, (const uint8_t[]){red, green, blue, 255});
    return scene;
}

// Masks all pixels of a view but one; NULL masks that, too.
static void mask(struct vw_scene *scene, uint32_t view, const uint32_t *usable) {
    scene->views[view].image.unusable = vw_allocate(PIXELS, 1);
    memset(scene->views[view].image.unusable, 1, PIXELS);
    if (usable) scene->views[view].image.unusable[*usable] = 0;
}

// Trains with each effect alone, with both of photos' appearance, and without any. The quick tests take one in four,
// other ones for each scene. An encoder's codes of photos are not the reference's.
static void train(struct hard_finding *finding, struct vw_scene *scene, uint32_t number) {
    uint32_t count;
    const struct vw_effect *effects = vw_effects_get(&count);
    bool columns = scene->views[0].image.width_px > 1;
    for (uint32_t i = 0; i < count + 2; i++) {
        const char *names = i < count ? effects[i].name : i == count ? "appearance,appearance_code" : "none";
        bool photos = !strncmp(names, "appearance", strlen("appearance"));
        if (i <= count && (i + number) % 4 && !test_is_full()) continue;
        if (photos && !columns && strcmp(names, "appearance_encoder") != 0) continue; // refused: few_columns
        struct vw_config config = hard_run_config();
        if (!strcmp(names, "transient")) config.loss = VW_LOSS_L2;
        strcpy(config.effects, names);
        finding->where = names;
        if (strcmp(names, "appearance_encoder") != 0) hard_train_well(finding, scene, &config);
        else hard_equal(finding, "flagged steps", 0, hard_train(finding, scene, &config).flagged_steps, 0.0);
    }
}

// ---- Scenes ---------------------------------------------------------------------------------------------------------

static void photos_of_one_colour(struct hard_finding *finding) {
    train(finding, open_painted(0, 0, 0), 0);
    train(finding, open_painted(255, 255, 255), 1);
    train(finding, open_painted(128, 127, 129), 2);
}

static void a_black_photo(struct hard_finding *finding) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    paint(scene, 0, (const uint8_t[]){0, 0, 0, 255});
    paint(scene, TRAIN_VIEWS, (const uint8_t[]){0, 0, 0, 255});
    train(finding, scene, 3);
}

static void small_photos(struct hard_finding *finding) {
    train(finding, open_scene(1, 1, false), 4);
    train(finding, open_scene(2, HEIGHT_PX, false), 5);
    train(finding, open_scene(3, HEIGHT_PX, false), 6);
}

static void a_masked_photo(struct hard_finding *finding) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    mask(scene, 1, NULL);
    train(finding, scene, 7);
}

// Masks all pixels but one; and all but one of the left half, in one view even that: the right halves stay.
static void nearly_all_masked(struct hard_finding *finding) {
    struct vw_scene *whole = open_scene(WIDTH_PX, HEIGHT_PX, false), *half = open_scene(WIDTH_PX, HEIGHT_PX, false);
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++) {
        const uint32_t usable = 7 * view, left = 2 * WIDTH_PX + view - TRAIN_VIEWS;
        mask(whole, view, &usable);
        mask(half, view, view > TRAIN_VIEWS ? &left : NULL);
        for (uint32_t i = 0; i < PIXELS; i++)
            if (i % WIDTH_PX >= WIDTH_PX / 2) half->views[view].image.unusable[i] = 0;
    }
    struct vw_config config = hard_run_config();
    config.val_rays = VAL_VIEWS * PIXELS;
    hard_train_well(finding, whole, &config);
    train(finding, half, 8);
}

static void flat_left_halves(struct hard_finding *finding) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++)
        for (uint32_t i = 0; i < PIXELS; i++)
            if (i % WIDTH_PX < WIDTH_PX / 2)
                memcpy((uint8_t *)scene->views[view].image.pixels + 4 * i, (const uint8_t[]){90, 0, 255, 255}, 4);
    train(finding, scene, 9);
}

// Trains with validation photos that have one opaque pixel in the middle and a box that covers little more: nearly
// every ray shows the background, whose errors are exactly 0.
static void nearly_all_background(struct hard_finding *finding) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, true);
    scene->box.half_extent_world = 0.2;
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++) {
        paint(scene, view, (const uint8_t[]){10, 20, 30, 0});
        ((uint8_t *)scene->views[view].image.pixels)[4 * (HEIGHT_PX / 2 * WIDTH_PX + WIDTH_PX / 2) + 3] = 255;
    }
    struct vw_config config = hard_run_config();
    config.val_rays = VAL_VIEWS * PIXELS;
    struct hard_run run = hard_train_well(finding, scene, &config);
    hard_require(finding, run.last.val_l1 > 0.0 && run.last.val_l1 < 0.1, "the few pixels that show something count");
    train(finding, scene, 10);
}

static void a_lost_camera(struct hard_finding *finding) {
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    scene->views[1].camera_to_world[0][3] = 1e7;
    train(finding, scene, 0);
}

// Trains on the same photo from the same place eight times, and takes a step whose rays all go through one pixel.
static void identical_photos(struct hard_finding *finding) {
    struct vw_config config = hard_run_config();
    struct vw_scene *scene = open_scene(WIDTH_PX, HEIGHT_PX, false);
    config.val_rays = VAL_VIEWS * PIXELS;
    for (uint32_t view = 1; view < VIEWS; view++) {
        memcpy(scene->views[view].image.pixels, scene->views[0].image.pixels, 4 * PIXELS);
        memcpy(scene->views[view].camera_to_world, scene->views[0].camera_to_world,
               sizeof scene->views[0].camera_to_world);
    }
    struct hard_run run = hard_train_well(finding, scene, &config);
    for (uint32_t view = 1; view < VAL_VIEWS; view++)
        hard_same_bits(finding, "errors of the same view", &run.views[view], &run.views[0], sizeof run.views[0]);

    struct step_case setup = {"one pixel", .seed = 322, HARD_SIZES};
    struct step_bench *bench = step_bench_open(&setup);
    for (uint32_t i = 1; i < bench->config.rays; i++) bench->pixels[i] = bench->pixels[0];
    hard_write_pixels(bench);
    for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
}

// ---- Steps ----------------------------------------------------------------------------------------------------------

// Checks steps on pixels at the ends of the sigmoid.
static void steps_on_one_colour(struct hard_finding *finding) {
    static const struct {
        vw_float4 rgba;
        enum vw_loss loss;
    } steps[] = {{{0, 0, 0, 1}, VW_LOSS_L1}, {{1, 1, 1, 1}, VW_LOSS_L1}, {{1, 0, 0, 1}, VW_LOSS_L2}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(steps); i++) {
        struct step_case setup = {"photos", .seed = 321, HARD_SIZES};
        setup.loss = steps[i].loss;
        struct step_bench *bench = step_bench_open(&setup);
        for (uint32_t k = 0; k < bench->config.rays; k++) bench->pixels[k].rgba = steps[i].rgba;
        hard_write_pixels(bench);
        for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
        hard_check_rendering(finding, bench);
        test_release(bench);
    }
}

// Checks black photos and a box that no camera sees: what is rendered is black.
static void match_nothing(struct hard_finding *finding) {
    struct vw_config config = hard_run_config();
    struct vw_scene *scene = open_painted(0, 0, 0);
    config.val_rays = VAL_VIEWS * PIXELS;
    scene->box.centre_world[2] = 1e3;
    struct hard_run run = hard_train_well(finding, scene, &config);
    hard_equal(finding, "PSNR of a perfect match (dB)", 0, run.last.val_psnr, 100.0);
    hard_equal(finding, "pooled PSNR (dB)", 0, run.last.val_psnr_pooled, 100.0);
    hard_equal(finding, "L1", 0, run.last.val_l1, 0.0);
    hard_equal(finding, "training loss", 0, run.last.train_loss, 0.0);
    hard_equal(finding, "floored views", 0, run.last.floored_views, VAL_VIEWS);
    hard_require(finding, run.still, "without a gradient no param moves");
}

// Checks grey photos of a box that is full of grey: colour weights of 0 make 1/2 exactly, and huge density weights let
// the first sample hide all others. At an error of 0 the loss has no slope.
static void match_a_grey_wall(struct hard_finding *finding, enum vw_loss loss) {
    struct step_case setup = {"grey wall", .seed = 323, HARD_SIZES};
    setup.loss = loss;
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_specialization *s = &bench->model.specialization;
    float *weights = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t k = 0; k < 3 * bench->config.width; k++) weights[reference_block_index(s, 3, k % 3, k / 3)] = 0.0f;
    hard_set_density(bench, 1e3f);
    for (uint32_t i = 0; i < bench->config.rays; i++) { // the middle of the photo, where no ray misses
        bench->pixels[i].x_px = (float)bench->scene->views[0].camera.centre_x_px;
        bench->pixels[i].y_px = (float)bench->scene->views[0].camera.centre_y_px;
        bench->pixels[i].rgba = (vw_float4){0.5f, 0.5f, 0.5f, 1.0f};
    }
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    struct hard_state state = hard_state_read(bench);
    hard_equal(finding, "loss", 0, state.scalars.x, 0.0);
    hard_same_bits(finding, "params that match", state.grid.grid, bench->params, bench->model.param_bytes);
}

static void perfect_match(struct hard_finding *finding) {
    match_nothing(finding);
    match_a_grey_wall(finding, VW_LOSS_L1);
    match_a_grey_wall(finding, VW_LOSS_HUBER);
}

static const struct hard_case cases[] = {
    {"photos of one colour, black and white", "gradients vanish; errors and gains all alike", photos_of_one_colour},
    {"a black photo", "pixels divided by 0; a gain that never comes back", a_black_photo},
    {"photos of 1 x 1 pixel, of 2 and 3 columns", "strata, places and means of one pixel", small_photos},
    {"a masked photo", "0/0 where nothing of a photo counts", a_masked_photo},
    {"validation views of which one pixel is usable", "means over pixels that do not count", nearly_all_masked},
    {"validation views with flat left halves", "0/0 in the fit; gains of anything", flat_left_halves},
    {"validation views that are nearly all background", "the few pixels that show something are lost",
     nearly_all_background},
    {"a camera that is lost", "one camera pulls the box away from all others", a_lost_camera},
    {"identical photos", "equal photos measured differently", identical_photos},
    {"steps on one colour", "colours at the ends of the sigmoid: gradients vanish", steps_on_one_colour},
    {"a perfect match", "log of 0, 0/0 in Adam", perfect_match},
};

HARD_CASES("photos", cases)
