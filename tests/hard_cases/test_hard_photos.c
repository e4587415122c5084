// Hard photos: of one colour, of one pixel, of values that are not colours, all the same, or matched perfectly. Steps
// are held against the reference pass by pass; whole runs through the trainer's public functions, by the errors of
// their last validation.
#include "support/cmocka_test.h"

#include "base/file.h"
#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "image/image.h"
#include "support/synthetic_scene.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum {
    WIDTH_PX = 12,
    HEIGHT_PX = 8,
    PIXELS = WIDTH_PX * HEIGHT_PX,
    TRAIN_VIEWS = 5,
    VAL_VIEWS = 3,
    VIEWS = TRAIN_VIEWS + VAL_VIEWS
};

static struct vw_scene *scene; // scene of the case that runs
static char *folder;

static void remove_folder(void *it) { temporary_folder_remove(it); }

static void open_scene(bool alpha) {
    scene = synthetic_scene(&(struct synthetic_scene_params){.train_views = TRAIN_VIEWS,
                                                             .val_views = VAL_VIEWS,
                                                             .width_px = WIDTH_PX,
                                                             .height_px = HEIGHT_PX,
                                                             .alpha = alpha});
}

static void paint(uint32_t view, const uint8_t rgba[4]) {
    for (uint32_t i = 0; i < PIXELS; i++) memcpy((uint8_t *)scene->views[view].image.pixels + 4 * i, rgba, 4);
}

// Validates on every pixel.
static struct vw_config whole_photos(void) {
    struct vw_config config = hard_run_config();
    config.val_rays = VAL_VIEWS * PIXELS;
    return config;
}

// ---- One colour -----------------------------------------------------------------------------------------------------

// Checks three steps on pixels of one colour, and a run on photos painted in it.
static void train_on_colour(struct hard_finding *finding, const uint8_t rgba[4], enum vw_loss loss) {
    struct step_case setup = {.name = "photos", .seed = 321, HARD_SIZES};
    setup.loss = loss;
    struct step_bench *bench = step_bench_open(&setup);
    for (uint32_t i = 0; i < bench->config.rays; i++)
        bench->pixels[i].rgba =
            (vw_float4){(float)rgba[0] / 255.0f, (float)rgba[1] / 255.0f, (float)rgba[2] / 255.0f, 1.0f};
    hard_write_pixels(bench);
    for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
    hard_check_rendering(finding, bench);

    struct vw_config config = hard_run_config();
    config.loss = loss;
    open_scene(false);
    for (uint32_t view = 0; view < VIEWS; view++) paint(view, rgba);
    struct hard_run run = hard_train_well(finding, scene, &config);
    hard_require(finding, run.last.train_loss < run.first.val_l1, "training comes closer to the colour");
}

static void black_photos(struct hard_finding *finding) {
    train_on_colour(finding, (const uint8_t[]){0, 0, 0, 255}, VW_LOSS_L1);
}
static void white_photos(struct hard_finding *finding) {
    train_on_colour(finding, (const uint8_t[]){255, 255, 255, 255}, VW_LOSS_L1);
}

static void single_colour_photos(struct hard_finding *finding) {
    train_on_colour(finding, (const uint8_t[]){255, 0, 0, 255}, VW_LOSS_L2);
    train_on_colour(finding, (const uint8_t[]){128, 127, 129, 255}, VW_LOSS_HUBER);
}

// ---- One pixel, and no colours --------------------------------------------------------------------------------------

static void photos_of_one_pixel(struct hard_finding *finding) {
    folder = test_own(temporary_folder_create(), remove_folder);
    tiny_scene_write(folder, &(struct tiny_scene){0});
    for (int i = 0; i < 8; i++) {
        const float rgb[3] = {(float)i / 8.0f, 0.5f, 1.0f};
        char name[32];
        snprintf(name, sizeof name, "images/%02d.png", i);
        assert_int_equal(vw_image_save(temporary_path(folder, name), 1, 1, 3, rgb), VW_OK);
    }
    struct vw_config config = hard_run_config();
    scene = test_scene_open((struct vw_scene_params){.path = folder});
    hard_equal(finding, "pixels of a photo", 0, scene->views[0].image.width_px * scene->views[0].image.height_px, 1.0);
    hard_train_well(finding, scene, &config);
}

enum { TINY_PIXELS = TINY_WIDTH_PX * TINY_HEIGHT_PX };

// Writes a portable float map, whose rows run bottom to top.
static void write_float_photo(const char *name, const float *rgb) {
    static const char header[] = "PF\n8 6\n-1.0\n";
    char file[sizeof header - 1 + TINY_PIXELS * 3 * sizeof *rgb];
    memcpy(file, header, sizeof header - 1);
    for (int row = 0; row < TINY_HEIGHT_PX; row++)
        memcpy(file + sizeof header - 1 + row * TINY_WIDTH_PX * 3 * sizeof *rgb,
               rgb + (TINY_HEIGHT_PX - 1 - row) * TINY_WIDTH_PX * 3, TINY_WIDTH_PX * 3 * sizeof *rgb);
    assert_int_equal(vw_file_write(temporary_path(folder, name), file, sizeof file), VW_OK);
}

static double srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

// Makes linear light in [0,1] but for pixel 3, which is far too bright, and `bad_pixels` bad pixels from pixel 10 on.
static void make_float_photo(uint32_t bad_pixels, float rgb[TINY_PIXELS * 3]) {
    static const float bad[] = {NAN, -1.0f, INFINITY, -1e-6f};
    for (int i = 0; i < TINY_PIXELS * 3; i++) rgb[i] = (float)i / (TINY_PIXELS * 3);
    rgb[3 * 3 + 1] = 1e5f;
    for (uint32_t i = 0; i < bad_pixels; i++) rgb[3 * (10 + i) + i % 3] = bad[i % 4];
}

static void check_float_photo(struct hard_finding *finding, const struct vw_view *view, uint32_t bad_pixels,
                              const float *rgb) {
    hard_equal(finding, "masked pixels", 0, (double)view->image.masked_count, bad_pixels);
    hard_equal(finding, "clamped values", 0, (double)view->image.clamped_count, 1.0);
    for (uint32_t i = 0; i < TINY_PIXELS; i++) {
        bool is_bad = i >= 10 && i < 10 + bad_pixels;
        float rgba[4];
        vw_image_pixel(&view->image, i % TINY_WIDTH_PX, i / TINY_WIDTH_PX, rgba);
        hard_equal(finding, "pixel is looked at", i, vw_view_keeps(view, i % TINY_WIDTH_PX, i / TINY_WIDTH_PX),
                   !is_bad);
        for (int c = 0; c < 3; c++)
            hard_compare(finding, "pixel value", i, rgba[c], is_bad ? 0.0 : srgb(fmin(rgb[3 * i + (uint32_t)c], 1.0)),
                         1.0, 1e-6);
    }
}

// Checks that up to 2 of 48 pixels may be bad, but not a third one, which makes more than 5 %.
static void floats_that_are_no_colours(struct hard_finding *finding) {
    static float rgb[TINY_PIXELS * 3];
    folder = test_own(temporary_folder_create(), remove_folder);
    tiny_scene_write(folder, &(struct tiny_scene){.name_suffix = ".pfm"});
    for (uint32_t i = 0; i < 8; i++) {
        char name[32];
        snprintf(name, sizeof name, "images/%02u.pfm", i);
        make_float_photo(i % 3, rgb);
        write_float_photo(name, rgb);
    }
    struct vw_config config = hard_run_config();
    scene = test_scene_open((struct vw_scene_params){.path = folder});
    for (uint32_t i = 0; i < scene->view_count; i++) {
        make_float_photo(i % 3, rgb);
        check_float_photo(finding, &scene->views[i], i % 3, rgb);
    }
    hard_train_well(finding, scene, &config);
    make_float_photo(3, rgb);
    write_float_photo("images/05.pfm", rgb);
    tiny_scene_refused(SCENE_PARAMS(.path = folder), VW_ERROR_INPUT, "05.pfm", "6.2 %");
}

// ---- Nothing to learn -----------------------------------------------------------------------------------------------

// Checks black photos and a box that no camera sees: what is rendered is black.
static void match_nothing(struct hard_finding *finding) {
    struct vw_config config = whole_photos();
    open_scene(false);
    for (uint32_t view = 0; view < VIEWS; view++) paint(view, (const uint8_t[]){0, 0, 0, 255});
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
    struct step_case setup = {.name = "grey wall", .seed = 323, HARD_SIZES};
    setup.loss = loss;
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_specialization *s = &bench->model.specialization;
    float *weights = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t k = 0; k < bench->config.width; k++) {
        weights[reference_block_index(s, 1, 0, k)] = 1e3f;
        for (uint32_t c = 0; c < 3; c++) weights[reference_block_index(s, 3, c, k)] = 0.0f;
    }
    step_bench_write_params(bench);
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

// Trains on the same photo from the same place eight times, and takes a step whose rays all go through one pixel.
static void identical_photos(struct hard_finding *finding) {
    struct vw_config config = whole_photos();
    open_scene(false);
    for (uint32_t view = 1; view < VIEWS; view++) {
        memcpy(scene->views[view].image.pixels, scene->views[0].image.pixels, 4 * PIXELS);
        memcpy(scene->views[view].camera_to_world, scene->views[0].camera_to_world,
               sizeof scene->views[0].camera_to_world);
    }
    struct hard_run run = hard_train_well(finding, scene, &config);
    for (uint32_t view = 1; view < VAL_VIEWS; view++)
        hard_same_bits(finding, "errors of the same view", &run.views[view], &run.views[0], sizeof run.views[0]);

    struct step_case setup = {.name = "one pixel", .seed = 322, HARD_SIZES};
    struct step_bench *bench = step_bench_open(&setup);
    for (uint32_t i = 1; i < bench->config.rays; i++) bench->pixels[i] = bench->pixels[0];
    hard_write_pixels(bench);
    for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
}

// ---- Next to nothing to see -----------------------------------------------------------------------------------------

// Trains with validation photos that have one opaque pixel in the middle and a box that covers little more: nearly
// every ray shows the background, whose errors are exactly 0.
static void nearly_all_background(struct hard_finding *finding) {
    struct vw_config config = whole_photos();
    open_scene(true);
    scene->box.half_extent_world = 0.2;
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++) {
        paint(view, (const uint8_t[]){10, 20, 30, 0});
        ((uint8_t *)scene->views[view].image.pixels)[4 * (HEIGHT_PX / 2 * WIDTH_PX + WIDTH_PX / 2) + 3] = 255;
    }
    struct hard_run run = hard_train_well(finding, scene, &config);
    hard_require(finding, run.last.val_l1 > 0.0 && run.last.val_l1 < 0.1, "the few pixels that show something count");
}

// Trains with validation photos of which all pixels but one are unusable.
static void nearly_all_masked(struct hard_finding *finding) {
    struct vw_config config = whole_photos();
    open_scene(false);
    for (uint32_t view = TRAIN_VIEWS; view < VIEWS; view++) {
        scene->views[view].image.unusable = vw_allocate(PIXELS, 1);
        memset(scene->views[view].image.unusable, 1, PIXELS);
        scene->views[view].image.unusable[7 * view] = 0;
    }
    hard_train_well(finding, scene, &config);
}

static const struct hard_case cases[] = {
    {"all-black photos", "colours at the end of the sigmoid: gradients vanish", black_photos},
    {"all-white photos", "the same at its other end", white_photos},
    {"photos of a single colour", "no texture: errors and gradients all alike", single_colour_photos},
    {"photos of 1 x 1 pixel", "strata, focal lengths and means of one pixel", photos_of_one_pixel},
    {"float input of 10^5, negative, NaN, infinite", "one pixel corrupts the loss of every step",
     floats_that_are_no_colours},
    {"a perfect match", "log of 0, 0/0 in Adam", perfect_match},
    {"identical photos", "equal photos measured differently", identical_photos},
    {"validation views that are nearly all background", "the few pixels that show something are lost",
     nearly_all_background},
    {"validation views of which one pixel is usable", "means over pixels that do not count", nearly_all_masked},
};

int main(void) { return hard_cases_run("photos", cases, VW_ARRAY_COUNT(cases)); }
