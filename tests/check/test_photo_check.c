// Defects of photos: sound photos have none, and each damage is found as what it is. Photos are of textured surfaces,
// rendered here by ray casting, so that the truth is known; there are no points but those that src/check makes.
// wrap: sysconf
#include "support/cmocka_test.h"

#include <stdatomic.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "check/beside.h"
#include "check/defects.h"
#include "check/table.h"
#include "image/pixel.h"
#include "support/synthetic_scene.h"

enum { VIEWS = 9, WIDTH_PX = 160, HEIGHT_PX = 120, PIXELS = WIDTH_PX * HEIGHT_PX, DAMAGED = 4 };

static long processors; // 0: those of the machine
WRAPS(sysconf);
long __wrap_sysconf(int name) { return name == _SC_NPROCESSORS_ONLN && processors ? processors : __real_sysconf(name); }

// ---- Photos of textured surfaces, and damage -----------------------------------------------------------------------

// Places at `along` of the normal; the last one, in front of the others, has an end.
static const struct surface {
    double normal[3], along, reach;
    int down; // the axis of the texture's rows; its columns are along x
} surfaces[] = {{{0.3, 0, 1}, -1.2, 100, 1}, {{0, 1, 0}, -0.75, 100, 2}, {{-0.3, 0, 1}, 0.43, 0.4, 1}};

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Draws the value of a place of a lattice, [-1,1], by a hash of few steps.
static double draw(int x, int y, uint32_t seed) {
    uint32_t hash = (uint32_t)x * 0x9e3779b1U ^ (uint32_t)y * 0x85ebca77U ^ seed * 0xc2b2ae3dU;
    hash = (hash ^ hash >> 15) * 0x2c1b3c6dU;
    hash = (hash ^ hash >> 12) * 0x297a2d39U;
    return (hash ^ hash >> 15) / 2147483648.0 - 1;
}

// Returns value noise, [-1,1], with cells of side 1.
static double draw_smoothly(double x, double y, uint32_t seed) {
    int column = (int)floor(x), row = (int)floor(y);
    double u = x - column, v = y - row;
    u *= u * (3 - 2 * u), v *= v * (3 - 2 * v);
    double above = (1 - u) * draw(column, row, seed) + u * draw(column + 1, row, seed);
    double below = (1 - u) * draw(column, row + 1, seed) + u * draw(column + 1, row + 1, seed);
    return (1 - v) * above + v * below;
}

// Returns the brightness of a texture as stored: light that can double. Details are of about 30 to 2 pixels.
static double texture(double x, double y, uint32_t seed) {
    double sum = 0;
    for (uint32_t i = 0, side = 1; i < 5; i++, side *= 2)
        sum += (i < 4 ? 0.2 : 0.1) * draw_smoothly(x * side / 0.64, y * side / 0.64, seed + 16 * i);
    return fmin(fmax(0.41 + 0.6 * sum, 0.12), 0.70);
}

// Returns the brightness of the nearest surface along a ray.
static double look(const double eye[3], const double direction[3]) {
    double nearest = INFINITY, brightness = 0;
    for (uint32_t s = 0; s < VW_ARRAY_COUNT(surfaces); s++) {
        const struct surface *surface = &surfaces[s];
        double depth = (surface->along - dot(eye, surface->normal)) / dot(direction, surface->normal), place[3];
        for (int i = 0; i < 3; i++) place[i] = eye[i] + depth * direction[i];
        bool within = fabs(place[0] + 0.45) <= surface->reach && fabs(place[1] + 0.2) <= surface->reach;
        if (!(depth > 0 && depth < nearest && within)) continue;
        nearest = depth;
        brightness = texture(place[0], place[surface->down], s + 1);
    }
    return brightness;
}

static void set_pixel(uint8_t pixel[4], double brightness) {
    memset(pixel, (int)lrint(255 * brightness), 3);
    pixel[3] = 255;
}

// Renders a view with four rays per pixel.
static void render(const struct vw_view *view, uint8_t *pixels) {
    double eye[3], camera[3], world[3];
    for (int i = 0; i < 3; i++) eye[i] = view->camera_to_world[i][VW_POSE_POSITION];
    for (uint32_t p = 0; p < PIXELS; p++) {
        double sum = 0;
        for (uint32_t ray = 0; ray < 4; ray++) {
            double x_px = p % WIDTH_PX + 0.25 + ray % 2 * 0.5, y_px = p / WIDTH_PX + 0.25 + ray / 2 * 0.5;
            assert_true(vw_camera_unproject(&view->camera, x_px, y_px, camera));
            for (int i = 0; i < 3; i++) world[i] = dot(view->camera_to_world[i], camera);
            sum += look(eye, world);
        }
        set_pixel(pixels + 4 * p, sum / 4);
    }
}

// Places a camera on an arc, 4.5 degrees from the next and 2 to 6 degrees up, that looks at the origin.
static void place_camera(struct vw_view *view, uint32_t index) {
    double angle = (index - (VIEWS - 1) / 2.0) * 4.5 * M_PI / 180, up = (4 + 2 * sin(2.0 * index)) * M_PI / 180;
    double c = cos(angle), s = sin(angle), p = cos(up), q = sin(up), far = 3.5;
    const double pose[3][4] = {{c, -s * q, s * p, far * s * p}, {0, p, q, far * q}, {-s, -c * q, c * p, far * c * p}};
    memcpy(view->camera_to_world, pose, sizeof pose);
}

// Makes the scene, owned by the test, with sound photos. A large box has few depths to try, none far before surfaces.
static struct vw_scene *make_scene(void) {
    static uint8_t rendered[VIEWS][4 * PIXELS];
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = VIEWS, .width_px = WIDTH_PX, .height_px = HEIGHT_PX});
    scene->box.half_extent_world = 24;
    for (uint32_t v = 0; v < VIEWS; v++) {
        place_camera(&scene->views[v], v);
        if (!rendered[v][3]) render(&scene->views[v], rendered[v]);
        memcpy(scene->views[v].image.pixels, rendered[v], sizeof rendered[v]);
    }
    return scene;
}

static void turn_over(uint8_t *pixels) {
    for (int i = 0; i < 2 * PIXELS; i++) { // bytes of the upper half
        uint8_t *there = &pixels[4 * (PIXELS - 1 - i / 4) + i % 4], value = pixels[i];
        pixels[i] = *there;
        *there = value;
    }
}

static void double_light(uint8_t *pixels) {
    for (int i = 0; i < 4 * PIXELS; i++)
        if (i % 4 < 3) pixels[i] = (uint8_t)lrintf(255 * vw_srgb_encode(2 * vw_srgb_decode((float)pixels[i] / 255)));
}

// Averages over pixels on both sides along an axis, except at the edges.
static void average(uint8_t *pixels, int reach_px, bool down) {
    static uint8_t before[4 * PIXELS];
    int step = down ? 4 * WIDTH_PX : 4;
    memcpy(before, pixels, sizeof before);
    for (int i = 0; i < 4 * PIXELS; i++) {
        int at = down ? i / 4 / WIDTH_PX : i / 4 % WIDTH_PX, sum = 0;
        if (at < reach_px || at + reach_px >= (down ? HEIGHT_PX : WIDTH_PX)) continue;
        for (int k = -reach_px; k <= reach_px; k++) sum += before[i + k * step];
        pixels[i] = (uint8_t)lrint(sum / (2.0 * reach_px + 1));
    }
}

// Blurs by a Gaussian of 2 pixels, whose variance 4 is that of six means of three pixels.
static void blur(uint8_t *pixels) {
    for (int i = 0; i < 12; i++) average(pixels, 1, i % 2);
}

static void move_across(uint8_t *pixels) { average(pixels, 4, false); }

// Paints a texture of its own on a fifth of the photo.
static void cover(uint8_t *pixels) {
    for (int x = 50; x < 122; x++)
        for (int y = 30; y < 84; y++) set_pixel(pixels + 4 * (y * WIDTH_PX + x), texture(0.02 * x, 0.02 * y, 16));
}

static void add_noise(uint8_t *pixels) {
    for (int i = 0; i < 4 * PIXELS; i++)
        if (i % 4 < 3) pixels[i] = (uint8_t)lrint(fmin(fmax(pixels[i] + 30 * draw(i, 0, 77), 0), 255));
}

// Turns a pose about an axis of length 1 in its own axes.
static void turn(double pose[3][4], const double axis[3], double degrees) {
    double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
    for (int row = 0; row < 3; row++) {
        double of[3] = {pose[row][0], pose[row][1], pose[row][2]}, along = dot(of, axis);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3; // Rodrigues
            pose[row][i] = c * of[i] + s * (of[j] * axis[k] - of[k] * axis[j]) + (1 - c) * along * axis[i];
        }
    }
}

// ---- Findings ------------------------------------------------------------------------------------------------------

// Fails the test, with all defects, unless there are as many and the first of the photo is of the kind; returns that.
static const struct vw_defect *expect(const struct vw_check *check, uint32_t view, enum vw_defect_kind kind,
                                      uint32_t count) {
    const struct vw_defect *found = NULL;
    for (uint32_t i = check->defect_count; i-- > 0;)
        if (check->defects[i].view == view) found = &check->defects[i];
    if (found && found->kind == kind && check->defect_count == count) return found;
    for (uint32_t i = 0; i < check->defect_count; i++)
        print_error("photo %u: %s\n", check->defects[i].view, vw_defect_words[check->defects[i].kind]);
    fail_msg("expected: %u defects, and photo %u: %s", count, view, vw_defect_words[kind]);
    return NULL;
}

// Surfaces look alike from all sides: stops and sharpness differ by how near they are, and at edges.
TEST(sound_photos_have_no_defect) {
    AUTO(vw_check_free) struct vw_check check;
    ASSERT_OK(vw_check_scene(make_scene(), &check));
    assert_true(check.view_count == VIEWS && check.point_count == 0 && check.made_count > 24 * VIEWS);
    assert_int_equal(check.defect_count, 0);
    for (uint32_t v = 0; v < VIEWS; v++) {
        assert_true(check.evidence[v].in_place > 0.5);
        assert_near(check.evidence[v].stops, 0, 0.1);
        assert_near(check.evidence[v].sharpness, 1, 0.1);
    }
}

TEST(a_turned_pose_is_found_by_any_number_of_threads) {
    AUTO(vw_check_free) struct vw_check check, again = {0};
    struct vw_scene *scene = make_scene();
    const double axis[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3};
    double truth[3][4], trace = 0;
    memcpy(truth, scene->views[DAMAGED].camera_to_world, sizeof truth);
    turn(scene->views[DAMAGED].camera_to_world, axis, 3);
    processors = 1;
    enum vw_status status = vw_check_scene(scene, &check);
    processors = 4;
    if (!status) status = vw_check_scene(scene, &again);
    processors = 0;
    ASSERT_OK(status);
    (void)expect(&check, DAMAGED, VW_DEFECT_POSE, 1);
    for (int i = 0; i < 3; i++) trace += dot(truth[i], check.evidence[DAMAGED].pose_found[i]);
    assert_near(check.evidence[DAMAGED].turned_deg, 3, 0.3); // a pixel, and many points tell less
    assert_near(acos(fmin((trace - 1) / 2, 1)) * 180 / M_PI, 0, 0.3);
    assert_memory_equal(check.evidence, again.evidence, VIEWS * sizeof *check.evidence); // padding, too
}

// A pixel in 80, at the edge, is 0.0125.
TEST_CASES(a_zoom_is_found, i, 2) {
    AUTO(vw_check_free) struct vw_check check;
    struct vw_scene *scene = make_scene();
    double zoom = i ? 1.15 : 0.9;
    scene->views[DAMAGED].camera.focal_x_px /= zoom;
    scene->views[DAMAGED].camera.focal_y_px /= zoom;
    ASSERT_OK(vw_check_scene(scene, &check));
    assert_near(expect(&check, DAMAGED, VW_DEFECT_ZOOM, 1)->amount, zoom, 0.0125);
}

// Adds points of the wall at the back; each is tracked by all photos, but the damaged one tracks only the first two.
static void add_points(struct vw_scene *scene) {
    enum { COUNT = 60 };
    uint32_t tracks = 0;
    scene->points = vw_allocate(COUNT, sizeof *scene->points);
    scene->tracks = vw_allocate(COUNT * VIEWS, sizeof *scene->tracks);
    assert_true(scene->points && scene->tracks);
    for (uint32_t p = 0; p < COUNT; p++) {
        const double place[3] = {0.1 * (p % 10) - 0.45, 0.1 * (p / 10) - 0.25, -1.2 - 0.3 * (0.1 * (p % 10) - 0.45)};
        scene->points[p] = (struct vw_point){.first_track = tracks};
        memcpy(scene->points[p].position_world, place, sizeof place);
        for (uint32_t v = 0; v < VIEWS; v++) {
            const struct vw_check_photo photo = {.view = &scene->views[v], .small_per_px = 1};
            double at_px[2], depth;
            if (v == DAMAGED && p >= 2) continue;
            assert_true(vw_check_project(&photo, place, at_px, &depth));
            scene->tracks[tracks++] = (struct vw_track){v, (float)at_px[0], (float)at_px[1]};
        }
        scene->points[p].track_count = tracks - scene->points[p].first_track;
    }
    scene->point_count = COUNT, scene->track_count = tracks;
}

// A photo off its pose tracks little, which needs no word.
TEST_CASES(few_tracks_are_found, turned, 2) {
    AUTO(vw_check_free) struct vw_check check;
    struct vw_scene *scene = make_scene();
    const double axis[3] = {0, 1, 0};
    add_points(scene);
    if (turned) turn(scene->views[DAMAGED].camera_to_world, axis, 3);
    ASSERT_OK(vw_check_scene(scene, &check));
    const struct vw_defect *found = expect(&check, DAMAGED, turned ? VW_DEFECT_POSE : VW_DEFECT_FEW_TRACKS, 1);
    assert_true(turned || found->amount == 2);
    assert_near(check.evidence[0].track_px, 0, 1e-3);
}

// Strong blur leaves little that the pose sees; a sharp photo that shows as little is taken for another one.
TEST_CASES(strong_blur_is_no_mismatch, sharp, 2) {
    AUTO(vw_check_free) struct vw_check check;
    ASSERT_OK(vw_check_scene(make_scene(), &check));
    check.evidence[DAMAGED].in_place = 0.02;
    check.evidence[DAMAGED].sharpness = check.evidence[DAMAGED].sharpness_high = sharp ? 1 : 0.2;
    ASSERT_OK(vw_check_find_defects(&check));
    (void)expect(&check, DAMAGED, sharp ? VW_DEFECT_MISMATCH : VW_DEFECT_BLUR, 1);
}

// Photos 0 and 1 are compared only with each other, and 2 and 3: each of these has more than the other, since the
// points differ.
TEST(levels_of_few_photos_do_not_run_away) {
    enum { PHOTOS = 4, POINTS = 10 };
    static const float more[PHOTOS] = {1, -1, 0.2F, 0.2F};
    struct vw_beside made[PHOTOS][POINTS], *lists[PHOTOS];
    uint32_t counts[PHOTOS];
    struct vw_beside_level levels[PHOTOS][VW_BESIDE_COUNT] = {0};
    for (uint32_t v = 0; v < PHOTOS; v++) {
        lists[v] = made[v], counts[v] = POINTS;
        for (uint32_t i = 0; i < POINTS; i++) {
            made[v][i] = (struct vw_beside){.other = v ^ 1, .shown = true};
            for (int m = 0; m < VW_BESIDE_COUNT; m++) made[v][i].differences[m] = more[v];
        }
    }
    ASSERT_OK(vw_beside_solve(lists, counts, PHOTOS, levels));
    assert_near(levels[0][VW_BESIDE_STOPS].median - levels[1][VW_BESIDE_STOPS].median, 1, 1e-6);
    for (uint32_t v = 2; v < PHOTOS; v++) assert_in_range(100 + 10 * levels[v][VW_BESIDE_NOISE].median, 98, 102);
}

// Photos that lie 4.5 and 13.5 degrees apart.
TEST_CASES(exchanged_photos_are_found, i, 2) {
    AUTO(vw_check_free) struct vw_check check;
    struct vw_scene *scene = make_scene();
    uint32_t other = i ? 7 : DAMAGED + 1;
    struct vw_image image = scene->views[DAMAGED].image;
    scene->views[DAMAGED].image = scene->views[other].image;
    scene->views[other].image = image;
    ASSERT_OK(vw_check_scene(scene, &check));
    assert_int_equal(expect(&check, DAMAGED, VW_DEFECT_SWAPPED, 2)->other, other);
    assert_int_equal(expect(&check, other, VW_DEFECT_SWAPPED, 2)->other, DAMAGED);
}

static const struct {
    void (*damage)(uint8_t *pixels);
    enum vw_defect_kind kind;
    size_t measure; // place in the evidence
    double least, most;
} damages[] = {
    {turn_over, VW_DEFECT_ORIENTATION, offsetof(struct vw_photo_evidence, turned_over_deg), 180, 180},
    // Each point tells it to some hundredths, and rounding to 8 bits changes less.
    {double_light, VW_DEFECT_EXPOSURE, offsetof(struct vw_photo_evidence, stops), 0.85, 1.15},
    // Waves of 8 pixels keep exp(-2 (2 pi / 8)^2) = 0.29 of their amplitude, those of 16 pixels 0.73.
    {blur, VW_DEFECT_BLUR, offsetof(struct vw_photo_evidence, sharpness), 0.29, 0.73},
    // Directions are 22.5 degrees apart.
    {move_across, VW_DEFECT_MOTION_BLUR, offsetof(struct vw_photo_evidence, motion_deg), 0, 22.5},
    // Patches reach 5 pixels: a region that is smaller by so much on each side has 0.14, a larger one 0.27.
    {cover, VW_DEFECT_OCCLUDER, offsetof(struct vw_photo_evidence, hidden), 0.1, 0.3},
    // Independent pixels have several times what is left of details of two pixels between four rays.
    {add_noise, VW_DEFECT_NOISE, offsetof(struct vw_photo_evidence, noise), 2.4, 20},
};

TEST_CASES(damage_is_found, i, VW_ARRAY_COUNT(damages)) {
    AUTO(vw_check_free) struct vw_check check;
    struct vw_scene *scene = make_scene();
    double measured;
    damages[i].damage(scene->views[DAMAGED].image.pixels);
    ASSERT_OK(vw_check_scene(scene, &check));
    (void)expect(&check, DAMAGED, damages[i].kind, 1);
    memcpy(&measured, (char *)&check.evidence[DAMAGED] + damages[i].measure, sizeof measured);
    if (!(measured >= damages[i].least && measured <= damages[i].most))
        fail_msg("%s: %g", vw_defect_words[damages[i].kind], measured);
}

TEST(a_mask_mends_a_covered_photo) {
    AUTO(vw_check_free) struct vw_check check;
    static uint8_t mask[PIXELS];
    struct vw_scene *scene = make_scene();
    cover(scene->views[DAMAGED].image.pixels);
    for (int i = 0; i < PIXELS; i++) // and some pixels more
        mask[i] = i % WIDTH_PX >= 48 && i % WIDTH_PX < 124 && i / WIDTH_PX >= 28 && i / WIDTH_PX < 86 ? VW_MASK_HIDE
                                                                                                      : VW_MASK_KEEP;
    scene->views[DAMAGED].mask = mask;
    enum vw_status status = vw_check_scene(scene, &check);
    scene->views[DAMAGED].mask = NULL; // it is not the scene's
    ASSERT_OK(status);
    assert_int_equal(check.defect_count, 0);
    assert_true(check.evidence[DAMAGED].in_place > 0.5);
}

// Both fit their pose: the first is kept.
TEST(a_copy_is_found) {
    AUTO(vw_check_free) struct vw_check check;
    struct vw_scene *scene = make_scene();
    struct vw_view *copy = &scene->views[DAMAGED];
    memcpy(copy->image.pixels, copy[-1].image.pixels, (size_t)4 * PIXELS);
    memcpy(copy->camera_to_world, copy[-1].camera_to_world, sizeof copy->camera_to_world);
    ASSERT_OK(vw_check_scene(scene, &check));
    assert_int_equal(expect(&check, DAMAGED, VW_DEFECT_COPY, 1)->other, DAMAGED - 1);
    assert_near(check.evidence[DAMAGED].similarity, 1, 1e-6);
}

TEST(an_empty_photo_has_a_row_and_an_excluded_one_has_none) {
    AUTO(vw_check_free) struct vw_check check;
    AUTO_FREE struct vw_check_row *rows = NULL;
    struct vw_csv_text table;
    uint32_t count;
    struct vw_scene *scene = make_scene();
    memset(scene->views[DAMAGED].image.pixels, 100, (size_t)4 * PIXELS);
    scene->views[2].split = VW_SPLIT_EXCLUDED;
    scene->split_count[VW_SPLIT_TRAIN]--, scene->split_count[VW_SPLIT_EXCLUDED]++;
    ASSERT_OK(vw_check_scene(scene, &check));
    (void)expect(&check, DAMAGED, VW_DEFECT_EMPTY, 1);
    ASSERT_OK(vw_check_make_rows(scene, &check, &rows, &count));
    assert_int_equal(count, VIEWS - 1);
    for (uint32_t i = 0; i < count; i++) assert_ptr_equal(rows[i].name, scene->views[i < 2 ? i : i + 1].name);
    const struct vw_rows columns = vw_check_rows(rows, count);
    ASSERT_OK(vw_rows_make_csv("defects.csv", &columns, &table));
    test_own(table.text, free);
    assert_ptr_equal(strstr(table.text, "name,split,defects,description,remedy,"), table.text);
    assert_non_null(strstr(table.text, "\nview_004,train,empty,shows nothing,leave it out,"));
    assert_non_null(strstr(table.text, "\nview_005,train,,,,"));
}

// ---- Words and threads ---------------------------------------------------------------------------------------------

TEST(words_find_their_kind) {
    static const char *const others[] = {"", "Pose", "pose ", "motion", "clean", NULL};
    for (int kind = 0; kind < VW_DEFECT_COUNT; kind++) {
        AUTO_FREE char *word = vw_copy_text(vw_defect_words[kind]);
        char text[VW_DEFECT_TEXT_BYTES] = "";
        const struct vw_defect defect = {.kind = (enum vw_defect_kind)kind, .amount = 0.5};
        assert_ptr_equal(vw_defect_find_word(word), vw_defect_words[kind]);
        assert_true(strlen(vw_defect_remedy(&defect)) > 0 && strlen(vw_defect_describe(&defect, "b.png", text)) > 0);
        assert_int_equal(strstr(text, "b.png") != NULL, kind == VW_DEFECT_SWAPPED || kind == VW_DEFECT_COPY);
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(others); i++) assert_null(vw_defect_find_word(others[i]));
}

TEST(a_turn_that_exif_tells_has_a_command) {
    char text[VW_DEFECT_TEXT_BYTES];
    struct vw_defect defect = {.kind = VW_DEFECT_ORIENTATION, .amount = 90};
    assert_null(strstr(vw_defect_describe(&defect, NULL, text), "EXIF"));
    assert_non_null(strstr(vw_defect_remedy(&defect), "mogrify -rotate"));
    defect.detail = 1;
    assert_non_null(
        strstr(vw_defect_describe(&defect, NULL, text), "turned by 90 degrees clockwise, as its EXIF data says"));
    assert_non_null(strstr(vw_defect_remedy(&defect), "mogrify -auto-orient"));
}

// Orientation 6 is shown upright by a quarter clockwise.
TEST_CASES(exif_tells_the_turn_that_it_names, orientation, 9) {
    AUTO(vw_check_free) struct vw_check check;
    ASSERT_OK(vw_check_scene(make_scene(), &check));
    check.evidence[DAMAGED].orientation = (uint32_t)orientation;
    check.evidence[DAMAGED].turned_over_deg = 90;
    ASSERT_OK(vw_check_find_defects(&check));
    assert_true(expect(&check, DAMAGED, VW_DEFECT_ORIENTATION, 1)->detail == (orientation == 6));
}

enum { PIECES = 300, FAILING = 31 };
static atomic_uint calls[PIECES];

// Counts a call. `fails`: the piece FAILING fails, later than those after it, which fail as well.
static enum vw_status call_piece(void *fails, uint32_t piece) {
    calls[piece]++;
    if (!fails || piece < FAILING) return VW_OK;
    if (piece == FAILING) usleep(2000);
    return vw_fail(piece == FAILING ? VW_ERROR_INPUT : VW_ERROR_IO, "piece %u", piece);
}

TEST_CASES(pieces_are_called_once_and_the_first_failure_counts, threads, 5) {
    memset(calls, 0, sizeof calls);
    processors = (long)threads; // 0: those of the machine
    enum vw_status sound = vw_parallel_for(PIECES, call_piece, NULL), none = vw_parallel_for(0, call_piece, calls),
                   failed = vw_parallel_for(PIECES, call_piece, calls);
    processors = 0;
    assert_true(!sound && !none && failed == VW_ERROR_INPUT);
    assert_string_equal(vw_error_message(), "piece 31");
    for (uint32_t i = 0; i < PIECES; i++) assert_in_range(calls[i], i <= FAILING ? 2 : 1, i <= FAILING + 16 ? 2 : 1);
}
