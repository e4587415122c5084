// Files of splats: what is written is read again, files of other programs are read, and what is wrong in a stranger's
// file is refused in one line.
#include "support/cmocka_test.h"

#include <math.h>

#include "base/file.h"
#include "support/draws.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/renderers/splats/splat_file.h"

enum { COUNT = 37, MOST = 1000 };

static const struct vw_box box = {.centre_world = {3.0, -40.0, 0.25}, .half_extent_world = 2.5};

static float *draw_params(uint32_t degree) {
    size_t numbers = (size_t)4 * VW_SPLAT_COLUMNS(degree) * COUNT;
    float *params = test_allocate(numbers, sizeof *params);
    for (size_t i = 0; i < numbers; i++)
        if (i / (4 * COUNT) < 1 || i / (4 * COUNT) == SPLAT_TURN || i % 4 < 3)
            params[i] = (float)test_draw(degree, (uint32_t)i, 1);
    return params;
}

// Writes a file and returns its path.
static const char *write(const char *folder, const float *params, uint32_t degree, uint32_t least) {
    AUTO_FREE void *data = NULL;
    size_t size_bytes = 0;
    const char *path = temporary_path(folder, "splats.ply");
    ASSERT_OK(vw_splat_file_make(params, COUNT, degree, least, &box, &data, &size_bytes));
    ASSERT_OK(vw_file_write(path, data, size_bytes));
    return path;
}

FOLDER_TEST(what_is_written_is_read) {
    for (uint32_t degree = 0; degree <= VW_SPLAT_DEGREE_MAX; degree++) {
        const float *params = draw_params(degree);
        const char *path = write(*state, params, degree, degree % 2 ? VW_SPLAT_DEGREE_MAX : 0);
        AUTO(vw_splat_file_free) struct vw_splat_file file = {0};
        ASSERT_OK(vw_splat_file_read(path, MOST, &file));
        assert_int_equal(file.count, COUNT);
        assert_int_equal(file.degree, degree);
        assert_false(file.antialiased);
        size_t numbers = (size_t)4 * VW_SPLAT_COLUMNS(VW_SPLAT_DEGREE_MAX) * COUNT;
        float *again = test_allocate(numbers, sizeof *again);
        ASSERT_OK(vw_splat_file_place(&file, path, VW_SPLAT_DEGREE_MAX, &box, again));
        for (size_t i = 0; i < numbers; i++) {
            size_t column = i / (4 * COUNT);
            float expected = column < VW_SPLAT_COLUMNS(degree) ? params[i] : 0.0f;
            // Floats of world coordinates up to 45 carry 4e-6, of an edge of 5; those of all others are kept.
            double slack = column == SPLAT_MEAN && i % 4 < 3 ? 1e-6 : column == SPLAT_SCALE ? 1e-6 : 0.0;
            assert_near(again[i], expected, slack);
        }
    }
}

// A splat whose numbers are known, as the first programs wrote it: order, normals, channels.
FOLDER_TEST(the_layout_is_the_usual_one) {
    float *params = test_allocate((size_t)4 * VW_SPLAT_COLUMNS(1) * COUNT, sizeof *params);
    for (uint32_t column = 0; column < VW_SPLAT_COLUMNS(1); column++)
        for (uint32_t lane = 0; lane < 4; lane++) params[4 * column * COUNT + lane] = (float)(10 * column + lane);
    size_t size_bytes = 0;
    AUTO_FREE char *data = temporary_read(write(*state, params, 1, 0), &size_bytes);
    const char *rows = strstr(data, "end_header\n") + strlen("end_header\n");
    const double edge = 5.0, expected[] = {-0.5 * edge + 3.0,
                                           0.5 * edge - 40.0,
                                           1.5 * edge + 0.25,
                                           0,
                                           0,
                                           0,
                                           30,
                                           31,
                                           32, // x y z, normals, f_dc
                                           40,
                                           50,
                                           60,
                                           41,
                                           51,
                                           61,
                                           42,
                                           52,
                                           62,
                                           3, // f_rest by channel, opacity
                                           10 + log(edge),
                                           11 + log(edge),
                                           12 + log(edge),
                                           20,
                                           21,
                                           22,
                                           23};
    assert_int_equal(size_bytes - (size_t)(rows - data), COUNT * sizeof(float) * VW_ARRAY_COUNT(expected));
    for (size_t i = 0; i < VW_ARRAY_COUNT(expected); i++) {
        float number;
        memcpy(&number, rows + 4 * i, sizeof number);
        assert_near(number, expected[i], 1e-5);
    }
}

static const char smallest[] = "ply\nformat binary_little_endian 1.0\ncomment antialiased 1\nelement vertex 1\n"
                               "property uchar red\nproperty double x\nproperty float y\nproperty float z\n"
                               "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\n"
                               "property float opacity\nproperty float scale_0\nproperty float scale_1\n"
                               "property float scale_2\nproperty float rot_0\nproperty float rot_1\n"
                               "property float rot_2\nproperty float rot_3\nelement camera 1\n"
                               "property list uchar float more\nend_header\n";
enum { SMALLEST_ROW_BYTES = 1 + 8 + 13 * 4 };

// Writes the header above, with one part of it replaced, and a row of ones.
static const char *write_smallest(const char *folder, const char *old, const char *new, size_t row_bytes) {
    char bytes[2048];
    const char *at = old ? strstr(smallest, old) : smallest, *path = temporary_path(folder, "smallest.ply");
    size_t before = (size_t)(at - smallest);
    int header =
        snprintf(bytes, sizeof bytes, "%.*s%s%s", (int)before, smallest, old ? new : "", at + (old ? strlen(old) : 0));
    const double one = 1.0;
    const float ones[13] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    bytes[header] = 7;
    memcpy(bytes + header + 1, &one, sizeof one);
    memcpy(bytes + header + 9, ones, sizeof ones);
    ASSERT_OK(vw_file_write(path, bytes, (size_t)header + row_bytes));
    return path;
}

FOLDER_TEST(other_properties_elements_and_doubles_are_read) {
    AUTO(vw_splat_file_free) struct vw_splat_file file = {0};
    ASSERT_OK(vw_splat_file_read(write_smallest(*state, NULL, NULL, SMALLEST_ROW_BYTES), MOST, &file));
    assert_int_equal(file.count, 1);
    assert_true(file.antialiased);
    for (int i = 0; i < 16; i++) assert_true(file.params[i] == (i == 7 || i == 15 ? 0.0f : 1.0f));
}

static void assert_refused(const char *path, const char *word) {
    struct vw_splat_file file = {0};
    enum vw_status status = vw_splat_file_read(path, MOST, &file);
    vw_splat_file_free(&file);
    ASSERT_FAILS(status, VW_ERROR_INPUT, word);
    assert_non_null(strstr(vw_error_message(), ".ply"));
}

FOLDER_TEST(wrong_headers_are_refused_by_line) {
    static const struct {
        const char *old, *new, *word;
    } cases[] = {
        {"ply\n", "plx\n", "begin with the line ply"},
        {"binary_little_endian", "ascii", ":2: \"format ascii 1.0\""},
        {"element vertex 1", "element vertex -1", ":4: \"element vertex -1\" is not an element"},
        {"element vertex 1", "element face 1", "comes before element vertex"},
        {"element vertex 1", "element chunk 1", "decompress it"},
        {"element vertex 1", "element vertex 1001", "has 1001 splats"},
        {"element vertex 1", "element vertex 0", "has 0 splats"},
        {"element vertex 1", "element vertex 99999999999999999999", "splats"},
        {"element vertex 1", "element vertex 2", "only 1 of 2 splats"},
        {"property float f_dc_1\n", "", "lacks property f_dc_1"},
        {"property float f_dc_1", "property float f_dc_0", "is there twice"},
        {"property float f_dc_1", "property int f_dc_1", "is not a property of floats"},
        {"property uchar red", "property list uchar int red", "is not a property of one number"},
        {"property uchar red", "property uchar", "is not a property of one number"},
        {"property uchar red", "property float f_rest_0", "has no property f_rest_1"},
        {"property uchar red", "property float f_rest_45", "above degree 3"},
        {"element vertex 1\n", "", "comes before element vertex"},
        {"element vertex 1", "element ", "is not an element with its number of rows"},
        {"comment antialiased 1", "remark", "is not a line of a header"},
        {"end_header\n", "", "header"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++)
        assert_refused(write_smallest(*state, cases[i].old, cases[i].new, SMALLEST_ROW_BYTES), cases[i].word);
    assert_refused(write_smallest(*state, NULL, NULL, SMALLEST_ROW_BYTES - 1), "only 0 of 1 splats");
    assert_refused(temporary_path(*state, "none.ply"), "none.ply");
}

FOLDER_TEST(wrong_numbers_are_refused_by_splat_and_property) {
    static const struct {
        uint32_t column, lane;
        float value;
        const char *word;
    } cases[] = {{SPLAT_MEAN, 1, NAN, "splat 5: y is not finite"},
                 {SPLAT_MEAN, 3, INFINITY, "splat 5: opacity is not finite"},
                 {SPLAT_SCALE, 2, -INFINITY, "splat 5: scale_2 is not finite"},
                 {SPLAT_HARMONICS + 1, 2, NAN, "splat 5: f_rest_6 is not finite"},
                 {SPLAT_HARMONICS, 0, -3e38f, "splat 5: f_dc_0 is -3e+38"},
                 {SPLAT_TURN, 0, 0.0f, "splat 5: rot_* is a quaternion of length 0"},
                 {SPLAT_TURN, 0, 1e20f, "splat 5: rot_* is a quaternion of length 1e+20"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        float *params = draw_params(1);
        if (cases[i].column == SPLAT_TURN)
            for (uint32_t lane = 0; lane < 4; lane++) params[4 * (SPLAT_TURN * COUNT + 5) + lane] = 0.0f;
        params[4 * (cases[i].column * COUNT + 5) + cases[i].lane] = cases[i].value;
        assert_refused(write(*state, params, 1, 0), cases[i].word);
    }
}

// ---- Training from a file -------------------------------------------------------------------------------------------

static struct vw_config splats_config(void) {
    struct vw_config config = vw_config_of_field(VW_FIELD_SPLATS);
    config.epochs = 2;
    config.rays = 2 * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
    config.val_rays = 512;
    config.splats = 200;
    return config;
}

// Gives the sky, if there is one, colours that differ by direction.
static void paint_sky(struct vw_trainer *trainer) {
    const struct vw_param_range *range = &trainer->model.ranges[VW_SLOT_SKY];
    float numbers[4 * VW_SKY_COLUMNS];
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) numbers[i] = (float)test_draw(5, i, 0);
    if (range->size_bytes)
        ASSERT_OK(vw_buffer_write(trainer->field.params, range->offset_bytes, numbers, sizeof numbers));
}

// Saves the splats of a trained run, and renders its first view.
static float *train_and_render(const char *path, const struct vw_config *config, float **params, uint64_t *numbers) {
    AUTO_FREE void *data = NULL;
    size_t size_bytes = 0;
    float *rgb = NULL;
    struct vw_trainer *trainer = test_trainer_create(test_scene(), config, true, 0);
    test_run_of(trainer);
    paint_sky(trainer);
    ASSERT_OK(vw_trainer_make_splats(trainer, 0, &data, &size_bytes));
    ASSERT_OK(vw_file_write(path, data, size_bytes));
    ASSERT_OK(vw_trainer_render(trainer, 0, &rgb));
    *numbers = trainer->model.param_bytes / 4;
    *params = test_read(trainer->field.params);
    return rgb;
}

FOLDER_TEST(a_run_begins_where_the_file_ended) {
    struct vw_config config = splats_config();
    const char *path = temporary_path(*state, "field.ply");
    float *params = NULL, *rgb = NULL;
    uint64_t numbers = 0;
    struct vw_scene *scene = test_scene();
    const struct vw_image *image = &scene->views[0].image;
    AUTO_FREE float *expected = train_and_render(path, &config, &params, &numbers);
    ASSERT_FAILS(vw_splats_begin_from(path, &(struct vw_config){.field = VW_FIELD_HASH}), VW_ERROR_USAGE,
                 "--field splats");
    config.splats = 199;
    ASSERT_FAILS(vw_splats_begin_from(path, &config), VW_ERROR_USAGE, "--splats");
    config.splats = config.harmonics = 0;
    ASSERT_FAILS(vw_splats_begin_from(path, &config), VW_ERROR_USAGE, "--harmonics 1");
    config.harmonics = 1;
    ASSERT_OK(vw_splats_begin_from(path, &config));
    assert_int_equal(config.splats, 200);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    ASSERT_OK(vw_trainer_render(trainer, 0, &rgb));
    for (size_t i = 0; i < (size_t)3 * image->width_px * image->height_px; i++) assert_near(rgb[i], expected[i], 2e-4);
    free(rgb);
    test_release(trainer);
    AUTO_FREE char *json = vw_config_to_json(&config, true), *all = vw_config_to_json(&config, false);
    assert_non_null(strstr(json, config.initial_sha256));
    assert_null(strstr(json, "field.ply"));
    struct vw_config again;
    ASSERT_OK(vw_config_from_json(all, &again));
    assert_string_equal(again.initial, config.initial);
    config.initial_sha256[0] ^= 1;
    ASSERT_FAILS(vw_splats_begin_from(path, &config), VW_ERROR_INPUT, "is not the file that the run begins from");
}

// Other programs know no sky: a run without the effect, which begins at the file, shows the same to 40 dB, since splats
// of the dome overlap, but do not add up to a smooth colour. Black in place of the sky would have less than 20.
FOLDER_TEST(a_file_shows_the_sky) {
    struct vw_config config = splats_config();
    const char *path = temporary_path(*state, "field.ply");
    float *params = NULL, *rgb = NULL;
    uint64_t numbers = 0;
    double squares = 0.0, light = 0.0;
    strcpy(config.effects, "sky");
    AUTO_FREE float *expected = train_and_render(path, &config, &params, &numbers);
    strcpy(config.effects, "none");
    config.splats = 0;
    ASSERT_OK(vw_splats_begin_from(path, &config));
    assert_int_equal(config.splats, 200 + 2000);
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 0);
    ASSERT_OK(vw_trainer_render(trainer, 0, &rgb));
    const size_t count = (size_t)3 * 24 * 18;
    for (size_t i = 0; i < count; i++) {
        squares += (rgb[i] - expected[i]) * (double)(rgb[i] - expected[i]);
        light += expected[i] * (double)expected[i];
    }
    free(rgb);
    if (squares / count > 1e-4 || light / count < 0.1) fail_msg("%g of %g", squares / count, light / count);
}

TEST_GROUP(NULL, test_gpu_close)
