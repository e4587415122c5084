// Near-duplicates: copies that were cut, masked, mirrored, brightened, made smaller or written anew are found,
// neighbours are not; what groups are worth; and how far validation views are from what is trained on.
#include "support/ledger_fixture.h"

#include "report/tables.h"
#include "scene/duplicates.h"
#include "scene/view_distance.h"
#include "support/synthetic_scene.h"
#include "value/providers.h"

enum { TRAIN = 32, VAL = 4, SIDE_PX = 64 };

// Adds details, functions of the direction as well: the photos of synthetic_scene() are so smooth that neighbours are
// alike after a shift.
static void add_details(struct vw_view *view) {
    const struct vw_camera *camera = &view->camera;
    for (uint32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        double x = (i % SIDE_PX + 0.5 - camera->centre_x_px) / camera->focal_x_px, along[3];
        double y = (i / SIDE_PX + 0.5 - camera->centre_y_px) / camera->focal_y_px;
        for (int row = 0; row < 3; row++) {
            const double *axes = view->camera_to_world[row];
            along[row] = axes[0] * x - axes[1] * y - axes[2];
        }
        double detail = sin(19 * along[0] + 13 * along[1]) + sin(23 * along[1] - 17 * along[2] + 1) +
                        sin(29 * along[2] + 11 * along[0] + 2);
        uint8_t *pixel = (uint8_t *)view->image.pixels + 4 * i;
        for (int c = 0; c < 3; c++) pixel[c] = (uint8_t)lrint(fmin(fmax(pixel[c] * 0.3 + 90 + 25 * detail, 0), 255));
    }
}

static struct vw_scene *make_orbit(uint32_t train, uint32_t val) {
    struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
        .train_views = train, .val_views = val, .width_px = SIDE_PX, .height_px = SIDE_PX});
    for (uint32_t v = 0; v < scene->view_count; v++) add_details(&scene->views[v]);
    return scene;
}

// Makes 36 views on an orbit, 10 degrees apart; the last four validate.
static struct vw_scene *make_scene(void) { return make_orbit(TRAIN, VAL); }

// Makes view `to` the photo of view `from`: same pose, same pixels, other bytes.
static struct vw_view *copy_photo(struct vw_scene *scene, uint32_t from, uint32_t to) {
    struct vw_view *original = &scene->views[from], *copy = &scene->views[to];
    memcpy(copy->camera_to_world, original->camera_to_world, sizeof copy->camera_to_world);
    memcpy(copy->image.pixels, original->image.pixels, (size_t)4 * SIDE_PX * SIDE_PX);
    return copy;
}

static void change_pixels(struct vw_view *view, double gain, double bias, double noise) {
    uint8_t *values = view->image.pixels;
    for (uint32_t i = 0; i < 4 * view->image.width_px * view->image.height_px; i++) {
        uint32_t words[4];
        vw_random_words(5, VW_RANDOM_JITTER, i, 0, 0, words);
        double value = gain * values[i] + bias + noise * (2 * vw_random_unit(words[0]) - 1);
        if (i % 4 != 3) values[i] = (uint8_t)lrint(fmin(fmax(value, 0), 255));
    }
}

static void halve(struct vw_view *view) {
    uint8_t *values = view->image.pixels;
    uint32_t small_px = SIDE_PX / 2;
    for (uint32_t y = 0; y < small_px; y++)
        for (uint32_t x = 0; x < small_px; x++)
            for (uint32_t c = 0; c < 4; c++) {
                uint32_t sum = 2;
                for (uint32_t i = 0; i < 4; i++) sum += values[4 * ((2 * y + i / 2) * SIDE_PX + 2 * x + i % 2) + c];
                values[4 * (y * small_px + x) + c] = (uint8_t)(sum / 4);
            }
    view->image.width_px = view->image.height_px = small_px;
}

// Cuts off parts of the sides: whole pixels on the left, right, top and bottom; below 0: adds black ones.
static void cut(struct vw_view *view, const int32_t sides_px[4]) {
    struct vw_image *image = &view->image;
    int32_t width_px = SIDE_PX - sides_px[0] - sides_px[1], height_px = SIDE_PX - sides_px[2] - sides_px[3];
    uint8_t *cut = vw_allocate((size_t)width_px * (size_t)height_px, 4);
    for (int32_t y = 0; y < height_px; y++)
        for (int32_t x = 0; x < width_px; x++) {
            int32_t from_x = x + sides_px[0], from_y = y + sides_px[2];
            bool inside = from_x >= 0 && from_y >= 0 && from_x < SIDE_PX && from_y < SIDE_PX;
            static const uint8_t black[4] = {0, 0, 0, 255};
            const uint8_t *from = (uint8_t *)image->pixels + 4 * (size_t)(from_y * SIDE_PX + from_x);
            memcpy(cut + 4 * (size_t)(y * width_px + x), inside ? from : black, 4);
        }
    free(image->pixels);
    image->pixels = cut;
    image->width_px = (uint32_t)width_px;
    image->height_px = (uint32_t)height_px;
}

static void mirror(struct vw_view *view) {
    uint32_t *pixels = view->image.pixels;
    for (uint32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        uint32_t x = i % SIDE_PX, other = i - x + SIDE_PX - 1 - x, pixel = pixels[i];
        if (x >= SIDE_PX / 2) continue;
        pixels[i] = pixels[other];
        pixels[other] = pixel;
    }
}

// Hides a part of the width, from the left, and paints it over: by a mask, or by transparency.
static void hide(struct vw_view *view, double part, bool transparent) {
    uint8_t *pixels = view->image.pixels;
    if (!transparent) view->mask = vw_allocate(SIDE_PX, SIDE_PX);
    for (uint32_t i = 0; i < SIDE_PX * SIDE_PX; i++) {
        bool hidden = i % SIDE_PX < part * SIDE_PX;
        if (!transparent) view->mask[i] = hidden ? VW_MASK_HIDE : VW_MASK_KEEP;
        if (hidden) memcpy(&pixels[4 * i], (uint8_t[4]){(uint8_t)(i * 7), 200, 0, transparent ? 0 : 255}, 4);
    }
    view->image.has_alpha = transparent;
}

// Turns the camera about its own up axis.
static void turn(struct vw_view *view, double degrees) {
    double c = cos(degrees * M_PI / 180), s = sin(degrees * M_PI / 180);
    for (int i = 0; i < 3; i++) {
        double right = view->camera_to_world[i][0], back = view->camera_to_world[i][2];
        view->camera_to_world[i][0] = c * right - s * back;
        view->camera_to_world[i][2] = s * right + c * back;
    }
}

static struct vw_duplicate *find(const struct vw_scene *scene, uint32_t *count) {
    struct vw_duplicate *duplicates = NULL;
    ASSERT_OK(vw_scene_find_duplicates(scene, &duplicates, count));
    return duplicates;
}

TEST(neighbours_are_no_duplicates) {
    struct vw_scene *scene = make_scene();
    uint32_t count = 1;
    free(find(scene, &count));
    assert_int_equal(count, 0);
}

TEST(copies_are_found) {
    static const struct {
        const char *what;
        double gain, bias, noise;
        bool halved, mirrored, transparent;
        int32_t cut_px[4];
        double hidden;
        enum vw_split split;
        double angle_deg, shift_world;
        uint32_t expected;
    } cases[] = {
        {.what = "the same pixels", .gain = 1, .expected = 2},
        {.what = "brighter, and clipped", .gain = 1.3, .expected = 2},
        {.what = "darker", .gain = 0.6, .bias = 5, .expected = 2},
        {.what = "written anew with losses", .gain = 1, .noise = 12, .expected = 2},
        {.what = "half the size", .gain = 1, .halved = true, .expected = 2},
        {.what = "half the size, darker and noisy", .gain = 0.8, .noise = 8, .halved = true, .expected = 2},
        {.what = "a little beside it", .gain = 1, .angle_deg = 1, .shift_world = 0.05, .expected = 2},
        {.what = "cut off by 3 pixels at each side", .gain = 1, .cut_px = {3, 3, 3, 3}, .expected = 2},
        {.what = "cut off by 6 pixels at a corner", .gain = 1, .cut_px = {0, 6, 0, 6}, .expected = 2},
        {.what = "cut off above, black below", .gain = 1, .cut_px = {0, 0, 3, -3}, .expected = 2},
        {.what = "in a black border", .gain = 1, .cut_px = {-3, -3, -3, -3}, .expected = 2},
        {.what = "mirrored", .gain = 1, .mirrored = true, .expected = 2},
        {.what = "mirrored, cut off and darker", .gain = 0.7, .mirrored = true, .cut_px = {3, 2, 2, 3}, .expected = 2},
        {.what = "masked on 40 %", .gain = 1, .hidden = 0.4, .expected = 2},
        {.what = "masked on 70 %", .gain = 1, .hidden = 0.7, .expected = 2},
        {.what = "transparent on 40 %", .gain = 1, .hidden = 0.4, .transparent = true, .expected = 2},
        {.what = "masked on 95 %", .gain = 1, .hidden = 0.95, .expected = 0},
        {.what = "for validation", .gain = 1, .split = VW_SPLIT_VAL, .expected = 2},
        {.what = "for tests", .gain = 1, .split = VW_SPLIT_TEST, .expected = 2},
        {.what = "with another pose", .gain = 1, .angle_deg = 90, .expected = 2},
        {.what = "with another pose, cut off", .gain = 1, .angle_deg = 90, .cut_px = {1, 1, 1, 1}, .expected = 2},
        {.what = "with another pose, mirrored", .gain = 1, .angle_deg = 90, .mirrored = true, .expected = 2},
        {.what = "from 0.2 aside, of 3 away", .gain = 1, .shift_world = 0.2, .expected = 2},
        {.what = "as a negative", .gain = -1, .bias = 255, .expected = 0},
        {.what = "with nothing on it", .gain = 0, .bias = 128, .expected = 0},
        {.what = "from 4 degrees aside and very noisy", .gain = 1, .noise = 60, .angle_deg = 4, .expected = 0},
        {.what = "excluded", .gain = 1, .split = VW_SPLIT_EXCLUDED, .expected = 0},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = make_scene();
        struct vw_view *copy = copy_photo(scene, 3, 17);
        change_pixels(copy, cases[i].gain, cases[i].bias, cases[i].noise);
        if (cases[i].halved) halve(copy);
        if (cases[i].mirrored) mirror(copy);
        if (cases[i].hidden > 0) hide(copy, cases[i].hidden, cases[i].transparent);
        if (memcmp(cases[i].cut_px, (int32_t[4]){0}, sizeof cases[i].cut_px)) cut(copy, cases[i].cut_px);
        copy->split = cases[i].split;
        turn(copy, cases[i].angle_deg);
        copy->camera_to_world[2][3] += cases[i].shift_world;
        uint32_t count = 0;
        AUTO_FREE struct vw_duplicate *duplicates = find(scene, &count);
        if (count != cases[i].expected)
            fail_msg("%s: %u photos in groups, not %u", cases[i].what, count, cases[i].expected);
        if (count == 2) {
            assert_true(duplicates[0].group == 0 && duplicates[1].group == 0);
            assert_true(duplicates[0].view == 3 && duplicates[1].view == 17);
            assert_true(duplicates[0].similarity == 1);
            assert_in_range((uint32_t)(1e6 * duplicates[1].similarity), 950000, 1000000);
            print_message("%s: similarity %.4f\n", cases[i].what, duplicates[1].similarity);
        }
    }
}

// An added photo is like the more similar one of two others, by pixels or bytes, whatever its split.
TEST(added_photos_are_matched) {
    struct vw_scene *scene = make_scene();
    change_pixels(copy_photo(scene, TRAIN, 9), 1, 0, 40);
    change_pixels(copy_photo(scene, TRAIN, 17), 0.8, 5, 8);
    memcpy(scene->views[20].sha256, scene->views[TRAIN + 1].sha256, sizeof scene->views[20].sha256);
    const uint32_t added[] = {17, 18, 20}, others[] = {TRAIN, 9, TRAIN + 1};
    uint32_t matches[3];
    ASSERT_OK(vw_scene_match_duplicates(scene, added, 3, others, 3, matches));
    assert_int_equal(matches[0], TRAIN);
    assert_int_equal(matches[1], UINT32_MAX);
    assert_int_equal(matches[2], TRAIN + 1);
}

// Somebody's photo may itself be a near-duplicate of another. Its copy is more like it than that other one is, and both
// are a group.
TEST(copies_of_near_duplicates_are_found) {
    struct vw_scene *scene = make_scene();
    change_pixels(copy_photo(scene, 3, 9), 1, 0, 60);
    struct vw_view *copy = copy_photo(scene, 9, 17);
    uint32_t count = 0;
    AUTO_FREE struct vw_duplicate *all = find(scene, &count);
    assert_int_equal(count, 2);
    assert_true(all[0].view == 9 && all[1].view == 17 && all[1].similarity == 1);
    copy->split = VW_SPLIT_EXCLUDED;
    AUTO_FREE struct vw_duplicate *without = find(scene, &count);
    assert_int_equal(count, 2);
    assert_true(without[0].view == 3 && without[1].view == 9);
    assert_true(without[1].similarity > 0.95 && without[1].similarity < 0.995);
    copy->split = VW_SPLIT_TRAIN;
    turn(copy, 90);
    AUTO_FREE struct vw_duplicate *posed_anew = find(scene, &count);
    assert_int_equal(count, 2);
    assert_true(posed_anew[0].view == 9 && posed_anew[1].view == 17);
}

// Equal bytes are a copy wherever the camera is said to have stood, also where there is nothing to see.
TEST(equal_files_are_copies) {
    struct vw_scene *scene = make_scene();
    memcpy(scene->views[20].sha256, scene->views[4].sha256, VW_HASH_BYTES);
    memcpy(scene->views[34].sha256, scene->views[4].sha256, VW_HASH_BYTES);
    memcpy(scene->views[9].sha256, scene->views[8].sha256, VW_HASH_BYTES);
    uint32_t count = 0;
    AUTO_FREE struct vw_duplicate *duplicates = find(scene, &count);
    static const struct vw_duplicate expected[] = {{0, 4, 1}, {0, 20, 1}, {0, 34, 1}, {1, 8, 1}, {1, 9, 1}};
    assert_int_equal(count, 5);
    for (uint32_t i = 0; i < count; i++)
        assert_true(duplicates[i].group == expected[i].group && duplicates[i].view == expected[i].view &&
                    duplicates[i].similarity == 1);

    // The scores of the copies: view 34 validates and has no score.
    const struct vw_ledger_score scores[] = {
        {.image_id = 4, .method = "dv_loss", .value = 9, .unit = "m"},
        {.image_id = 4, .method = "dv_psnr", .value = 1.5, .unit = "dB"},
        {.image_id = 20, .method = "dv_psnr", .value = -4, .unit = "dB", .standard_error = 0.5},
    };
    struct vw_ledger_image images[TRAIN + VAL];
    for (uint32_t i = 0; i < TRAIN + VAL; i++)
        images[i] = (struct vw_ledger_image){
            i, scene->views[i].name, i < TRAIN ? "train" : "val", i % 8 ? "" : "bob", HEX_A, NULL};
    images[4].provider = "alice";
    images[20].provider = "eve, inc.";
    AUTO_FREE struct vw_duplicate_score *rows = NULL;
    uint32_t row_count = 0;
    ASSERT_OK(vw_duplicates_score(duplicates, count, "dv_psnr", scores, VW_ARRAY_COUNT(scores), images, TRAIN + VAL,
                                  &rows, &row_count));
    assert_int_equal(row_count, 3); // nothing is known of views 8 and 9
    for (uint32_t i = 0; i < row_count; i++) {
        assert_true(rows[i].group_value == -2.5);
        assert_int_equal(rows[i].provider_count, 2);
        assert_int_equal(rows[i].validation_count, 1);
    }
    assert_true(rows[0].score == &scores[1] && rows[1].score == &scores[2] && !rows[2].score);
    struct vw_csv_text table;
    const struct vw_rows of_table = vw_duplicate_rows(rows, row_count);
    ASSERT_OK(vw_rows_make_csv("duplicates.csv", &of_table, &table));
    assert_string_equal(table.text, "group,name,split,provider,similarity,method,value,unit,stderr,group_value\n"
                                    "0,view_004,train,alice,1,dv_psnr,1.5,dB,0,-2.5\n"
                                    "0,view_020,train,\"eve, inc.\",1,dv_psnr,-4,dB,0.5,-2.5\n"
                                    "0,view_034,val,,1,,,,,-2.5\n");
    free(table.text);
}

// A film of a turn by a degree per picture falls into groups that each lie within 2 degrees of their first, and not
// into a single one.
TEST(groups_do_not_grow_along_a_film) {
    struct vw_scene *scene = make_orbit(358, 2);
    uint32_t count = 0, longest = 0;
    AUTO_FREE struct vw_duplicate *duplicates = find(scene, &count);
    assert_true(count > 0);
    for (uint32_t i = 0, length = 0; i < count; i++) {
        length = i > 0 && duplicates[i].group == duplicates[i - 1].group ? length + 1 : 1;
        if (length > longest) longest = length;
    }
    assert_in_range(longest, 2, 3);
}

// ---- Validation views -----------------------------------------------------------------------------------------------

static struct vw_view_distance *measure(const struct vw_scene *scene, uint32_t *count) {
    struct vw_view_distance *distances = NULL;
    ASSERT_OK(vw_scene_view_distances(scene, VW_SPLIT_VAL, &distances, count));
    return test_own(distances, free);
}

TEST(far_validation_views_are_told) {
    struct vw_scene *scene = make_scene();
    uint32_t count = 0;
    struct vw_view_distance *distances = measure(scene, &count);
    assert_int_equal(count, VAL);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(distances[i].view, TRAIN + i);
        assert_int_equal(distances[i].nearest,
                         i < 2 ? TRAIN - 1 : 0); // the four last of the orbit: the training views end on either side
        assert_true(distances[i].angle_deg > 5 && distances[i].angle_deg < 25);
        assert_false(distances[i].far); // one and two steps of the orbit
    }
    scene->views[TRAIN].camera_to_world[2][3] += 3; // 45 degrees up, as seen from the middle
    turn(&scene->views[TRAIN + 1], 180);            // the same place, but looking outward
    scene->views[TRAIN + 2].camera_to_world[2][3] += 0.2;
    distances = measure(scene, &count);
    assert_true(distances[0].far && distances[1].far && !distances[2].far && !distances[3].far);
    assert_true(distances[0].between_world > 2.5 &&
                distances[0].angle_deg > 40); // from the training view that is nearest in both

    for (uint32_t i = 0; i < TRAIN; i += 2) copy_photo(scene, i, i + 1); // copies make the others no farther
    distances = measure(scene, &count);
    assert_false(distances[2].far || distances[3].far);
    for (uint32_t i = 0; i < TRAIN; i++) copy_photo(scene, 0, i); // all in one place: the scales have a floor
    distances = measure(scene, &count);
    for (uint32_t i = 0; i < count; i++) assert_true(isfinite(distances[i].ratio));
    scene->split_count[VW_SPLIT_TRAIN] = 1;
    distances = measure(scene, &count);
    assert_int_equal(count, 0);
}
