// COLMAP models that are broken or hostile: each is refused in one line that names the file and the field.
#include "support/cmocka_test.h"

#include <unistd.h>

#include "scene/formats/colmap.h"
#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static const char *const files[] = {"sparse/0/cameras.bin", "sparse/0/images.bin", "sparse/0/points3D.bin"};

#define assert_refused(folder, ...)                                                                                    \
    tiny_scene_refused(SCENE_PARAMS(.path = folder, .format = "colmap", .headers_only = true), VW_ERROR_INPUT,         \
                       __VA_ARGS__)

FOLDER_TEST(a_cut_at_any_byte_is_refused) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    for (size_t f = 0; f < VW_ARRAY_COUNT(files); f++) {
        char path[4096];
        snprintf(path, sizeof path, "%s", temporary_path(*state, files[f]));
        size_t size_bytes;
        AUTO_FREE void *data = temporary_read(path, &size_bytes);
        assert_true(size_bytes > 100);
        for (size_t kept = 0; kept < size_bytes; kept++) {
            ASSERT_OK(vw_file_write(path, data, kept));
            assert_refused(*state, files[f], "field ");
        }
        AUTO_FREE char *longer = vw_allocate(size_bytes + 1, 1);
        memcpy(longer, data, size_bytes);
        ASSERT_OK(vw_file_write(path, longer, size_bytes + 1));
        assert_refused(*state, files[f], "1 bytes follow");
        ASSERT_OK(vw_file_write(path, data, size_bytes));
    }
    tiny_scene_open(SCENE_PARAMS(.path = *state, .format = "colmap")); // the files are whole again
}

// Every byte of every file replaced by others: whatever happens, it is a scene or one line, and no sanitizer has
// anything to say.
FOLDER_TEST(any_byte_may_change) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    char folder[4096];
    snprintf(folder, sizeof folder, "%s", temporary_path(*state, "sparse/0"));
    for (size_t f = 0; f < VW_ARRAY_COUNT(files); f++) {
        char path[4096];
        snprintf(path, sizeof path, "%s", temporary_path(*state, files[f]));
        size_t size_bytes;
        AUTO_FREE uint8_t *data = temporary_read(path, &size_bytes);
        for (size_t i = 0; i < size_bytes; i++) {
            static const uint8_t flips[] = {0x01, 0x80, 0x7f, 0xff};
            for (size_t k = 0; k < VW_ARRAY_COUNT(flips); k++) {
                data[i] ^= flips[k];
                temporary_write(path, data, size_bytes);
                data[i] ^= flips[k];
                AUTO(vw_colmap_clear) struct vw_colmap_model read = {0};
                if (vw_colmap_read(folder, *state, &read)) {
                    assert_non_null(strstr(vw_error_message(), files[f]) ? vw_error_message()
                                                                         : strstr(vw_error_message(), "sparse/0/"));
                    assert_null(strchr(vw_error_message(), '\n'));
                }
            }
        }
        ASSERT_OK(vw_file_write(path, data, size_bytes));
    }
}

FOLDER_TEST(huge_counts_are_refused) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    // The places of the counts: at the start of each file; after the first image's name; after the first point's error.
    static const struct {
        int file;
        size_t offset;
        const char *field;
    } counts[] = {
        {0, 0, "num_cameras"},
        {1, 0, "num_images"},
        {1, 8 + 4 + 56 + 4 + 6, "num_points2D"},
        {2, 0, "num_points3D"},
        {2, 8 + 8 + 24 + 3 + 8, "track_length"},
    };
    static const uint64_t lies[] = {1000000000,        (uint64_t)1 << 31, (uint64_t)1 << 32, ((uint64_t)1 << 61) + 1,
                                    (uint64_t)1 << 63, UINT64_MAX};
    for (size_t c = 0; c < VW_ARRAY_COUNT(counts); c++) {
        const char *path = temporary_path(*state, files[counts[c].file]);
        for (size_t k = 0; k < VW_ARRAY_COUNT(lies); k++) {
            FILE *file = fopen(path, "r+b");
            uint64_t ground_truth;
            assert_int_equal(fseek(file, (long)counts[c].offset, SEEK_SET), 0);
            assert_int_equal(fread(&ground_truth, sizeof ground_truth, 1, file), 1);
            assert_true(ground_truth == 2 || ground_truth == 3);
            assert_int_equal(fseek(file, (long)counts[c].offset, SEEK_SET), 0);
            assert_int_equal(fwrite(&lies[k], sizeof lies[k], 1, file), 1);
            fclose(file);
            assert_refused(*state, files[counts[c].file], counts[c].field);
            colmap_write_binary(*state, "sparse/0", &model);
            path = temporary_path(*state, files[counts[c].file]);
        }
    }
}

// Checks that a model is refused once a number is changed, whether it is written as binary or as text.
static void check_refused(const char *folder, const struct colmap_test_model *model, const char *file,
                          const char *field) {
    colmap_write_text(folder, "sparse/1", model); // never read
    for (int text = 0; text < 2; text++) {
        char scene[4096], name[64];
        snprintf(scene, sizeof scene, "%s", temporary_path(folder, text ? "text" : "binary"));
        (text ? colmap_write_text : colmap_write_binary)(scene, "sparse/0", model);
        snprintf(name, sizeof name, "sparse/0/%s.%s", file, text ? "txt" : "bin");
        assert_refused(scene, name, field);
    }
}

// Refuses the model `good` once `change` is made to it.
#define REFUSED(file, field, change)                                                                                   \
    do {                                                                                                               \
        struct colmap_test_model model = good;                                                                         \
        change;                                                                                                        \
        check_refused(*state, &model, file, field);                                                                    \
    } while (0)

FOLDER_TEST(bad_numbers_are_refused) {
    const struct colmap_test_model good = colmap_test_scene(*state);
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e300};
    for (size_t k = 0; k < VW_ARRAY_COUNT(bad); k++) {
        for (int i = 0; i < 8; i++) REFUSED("cameras", "camera 7: field ", model.cameras[0].params[i] = bad[k]);
        for (int i = 0; i < 4; i++)
            REFUSED("images", "image 4: field quaternion", model.images[1].rotation[i] = bad[k]);
        for (int i = 0; i < 3; i++) {
            REFUSED("images", "image 4: field translation", model.images[1].translation[i] = bad[k]);
            REFUSED("points3D", "point 1099511627776: field xyz", model.points[1].position[i] = bad[k]);
        }
        REFUSED("images", "image 4: field points2D", model.images[1].features[1][0] = bad[k]);
        // COLMAP writes the largest double as the error of points behind cameras.
        if (!isfinite(bad[k])) REFUSED("points3D", "point 5: field error", model.points[0].error = bad[k]);
    }
}

FOLDER_TEST(inconsistent_models_are_refused) {
    const struct colmap_test_model good = colmap_test_scene(*state);
    REFUSED("cameras", "camera 7: field focal_y_px is 0", model.cameras[0].params[1] = 0);
    REFUSED("cameras", "camera 7: field focal_y_px is 1e-300", model.cameras[0].params[1] = 1e-300);
    REFUSED("cameras", "camera 3: field focal_x_px is -20", model.cameras[1].params[0] = -20);
    REFUSED("cameras", "camera 3: fields width and height", model.cameras[1].width_px = 0);
    REFUSED("cameras", "camera 3: fields width and height", model.cameras[1].height_px = (uint64_t)1 << 33);
    REFUSED("cameras", "camera 7 appears twice", model.cameras[1].id = 7);
    REFUSED("cameras", "no cameras", model.camera_count = 0);
    REFUSED("images", "no images", model.image_count = 0);
    REFUSED("images", "image 9: field camera_id is 8", model.images[2].camera_id = 8);
    REFUSED("images", "image 12 appears twice", model.images[2].id = 12);
    REFUSED("images", "b.png", model.images[2].name = "./b.png");
    REFUSED("images", "image 12: field quaternion", model.images[0].rotation[0] *= 1.01);
    REFUSED("images", "image 12: field quaternion", memset(model.images[0].rotation, 0, sizeof(double[4])));
    REFUSED("points3D", "point 5 appears twice", model.points[1].id = 5);
    REFUSED("points3D", "point 5: field track: image 5 is not", model.points[0].tracks[1][0] = 5);
    REFUSED("points3D", "point 5: field track: image 4 has 2", model.points[0].tracks[1][1] = 2);
}

FOLDER_TEST(unsupported_camera_models_are_named) {
    static const struct {
        int32_t id;
        const char *name;
    } models[] = {{7, "FOV"}, {8, "SIMPLE_RADIAL_FISHEYE"}, {9, "RADIAL_FISHEYE"}, {10, "THIN_PRISM_FISHEYE"}};
    struct colmap_test_model model = colmap_test_scene(*state);
    for (size_t i = 0; i < VW_ARRAY_COUNT(models); i++) {
        model.cameras[1].model = models[i].id;
        model.cameras[1].model_name = models[i].name;
        char expected[64];
        snprintf(expected, sizeof expected, "camera 3: model %s is not supported", models[i].name);
        check_refused(*state, &model, "cameras", expected);
    }
    model.cameras[1].model = 4711;
    model.cameras[1].model_name = "4711";
    check_refused(*state, &model, "cameras", "4711 is not supported");
    model.cameras[1].model = -1;
    model.cameras[1].model_name = "-1";
    check_refused(*state, &model, "cameras", "-1 is not supported");
}

FOLDER_TEST(bad_names_are_refused) {
    static const struct {
        const char *name, *says;
    } names[] = {
        {"../a.png", "leaves the scene folder"},
        {"/etc/passwd", "leaves the scene folder"},
        {"sub/../../a.png", "leaves the scene folder"},
        {"sub/..", "leaves the scene folder"},
        {"..", "leaves the scene folder"},
        {"a\033[2J.png", "control characters"},
        {"a\xff.png", "not UTF-8"},
        {"a\xc0\xaf.png", "not UTF-8"},
    };
    struct colmap_test_model model = colmap_test_scene(*state);
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        model.images[1].name = names[i].name;
        check_refused(*state, &model, "images", "image 4: field name");
        check_refused(*state, &model, "images", names[i].says);
    }
    model.images[1].name = "";
    colmap_write_binary(*state, "sparse/0", &model);
    assert_refused(*state, "images.bin: image 4: field name is empty");
    model.images[1].name = "a\nb.png"; // a line break can only be in a binary file
    colmap_write_binary(*state, "sparse/0", &model);
    assert_refused(*state, "images.bin: image 4: field name", "control characters");
}

// Photos and model files that are links out of the folder.
FOLDER_TEST(links_out_of_the_scene_are_refused) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    AUTO_FOLDER char *outside = temporary_folder_create();
    colmap_write_binary(*state, "sparse/0", &model);
    tiny_photo_write(temporary_path(outside, "secret.png"), 1);
    const char *photo = temporary_path(*state, "images/b.png");
    assert_int_equal(unlink(photo), 0);
    assert_int_equal(symlink(temporary_path(outside, "secret.png"), photo), 0);
    assert_refused(*state, "images/b.png", "image 4: field name", "through a link");
    assert_int_equal(unlink(photo), 0);
    tiny_photo_write(photo, 1);
    for (size_t f = 0; f < VW_ARRAY_COUNT(files); f++) {
        const char *path = temporary_path(*state, files[f]), *moved = temporary_path(outside, "moved");
        assert_int_equal(rename(path, moved), 0);
        assert_int_equal(symlink(moved, path), 0);
        assert_refused(*state, files[f], "through a link");
        assert_int_equal(unlink(path), 0);
        assert_int_equal(rename(moved, path), 0);
    }
}

FOLDER_TEST(photos_of_another_shape_are_refused) {
    struct colmap_test_model model = colmap_test_scene(*state);
    model.cameras[1].height_px = 13; // a photo of 8 x 6 has another shape than 16 x 13
    colmap_write_binary(*state, "sparse/0", &model);
    assert_refused(*state, "images/b.png", "16 x 13", "8 x 6");
    model.images[0].name = "x.png", model.images[1].name = "y.png", model.images[2].name = "z.png";
    colmap_write_binary(*state, "sparse/0", &model);
    assert_refused(*state, "images", "none of the 3 photos", "x.png");
    assert_int_equal(unlink(temporary_path(*state, files[2])), 0);
    assert_refused(*state, "sparse/0", "points3D");
}

FOLDER_TEST(bad_text_lines_are_named) {
    static const struct {
        const char *file, *text, *says;
    } cases[] = {
        {"cameras", "1 PINHOLE 8 6 9 9 4", "cameras.txt:1: field params is missing"},
        {"cameras", "\n1 PINHOLE 8 6 9 9 4 3 2", "cameras.txt:2: \"2\" follows the last field"},
        {"cameras", "1 PINHOLE 8 6 9 9x 4 3", "cameras.txt:1: field params is \"9x\""},
        {"cameras", "-1 PINHOLE 8 6 9 9 4 3", "cameras.txt:1: field camera_id is \"-1\""},
        {"cameras", "1 PINHOLE 8.5 6 9 9 4 3", "cameras.txt:1: field width is \"8.5\""},
        {"cameras", "1 PINHOLE 8 99999999999999999999999 9 9 4 3", "cameras.txt:1: field height"},
        {"cameras", "1 PINHOLE 8 6 1e999 9 4 3", "cameras.txt:1: camera 1: field focal_x_px is inf"},
        {"images", "1 1 0 0 0 0 0 5 7", "images.txt:1: field name is missing"},
        {"images", "1 1 0 0 0 0 0 5 7 a.png", "images.txt:2: the line of the last image's points2D is missing"},
        {"images", "1 1 0 0 0 0 0 5 7 a.png\n1 2", "images.txt:2: field point3D_id is missing"},
        {"images", "4294967296 1 0 0 0 0 0 5 7 a.png\n", "images.txt:1: field image_id"},
        {"points3D", "1 0 0 0 256 0 0 1", "points3D.txt:1: field rgb is \"256\""},
        {"points3D", "1 0 0 0 255 0 0 1 12", "points3D.txt:1: field track is missing"},
    };
    const struct colmap_test_model model = colmap_test_scene(*state);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        char name[64];
        colmap_write_text(*state, "sparse/0", &model);
        snprintf(name, sizeof name, "sparse/0/%s.txt", cases[i].file);
        temporary_file(*state, name, cases[i].text);
        assert_refused(*state, cases[i].says);
    }
    colmap_write_text(*state, "sparse/0", &model);
    ASSERT_OK(vw_file_write(temporary_path(*state, "sparse/0/cameras.txt"), "1 PINHOLE 8 6 9 9 4 3\n\0\n", 24));
    assert_refused(*state, "cameras.txt: has zero bytes");
}
