// The rule by which files are photos: their first bytes decide, never their names; and how large the photos of a scene
// may be.
#include "support/cmocka_test.h"

#include <unistd.h>

#include "image/image.h"
#include "image/photo_formats.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

// ---- Signatures -----------------------------------------------------------------------------------------------------

// Small files of each format, with red 0, green 0.25 and blue 0.5.
static const struct {
    const char *file;
    uint32_t format;
} samples[] = {{"png.png", 0},
               {"jpeg.jpg", 1},
               {"tiff.tif", 2},
               {"openexr.exr", 3},
               {"webp.webp", 4},
               {"jpeg2000.jp2", 5},
               {"jpeg2000_codestream.j2k", 5},
               {"hdr.hdr", 6},
               {"pnm.ppm", 7}};

FOLDER_TEST(every_format_is_read_under_any_name) {
    static const char *const names[] = {"b.gif", "c.fits", "d.null?RES=16000x16000", "e.dpx", "no_extension"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(samples); i++) {
        char path[4096];
        size_t size_bytes;
        uint32_t format;
        snprintf(path, sizeof path, "%s/tests/fuzz/corpus/photo/%s", VW_SOURCE_FOLDER, samples[i].file);
        AUTO_FREE void *bytes = temporary_read(path, &size_bytes);
        assert_true(vw_photo_format_of_bytes(bytes, size_bytes, &format));
        assert_int_equal(format, samples[i].format);
        for (size_t j = 0; j < VW_ARRAY_COUNT(names); j++) {
            AUTO(vw_image_clear) struct vw_image image;
            const char *renamed = temporary_path(*state, names[j]);
            ASSERT_OK(vw_file_write(renamed, bytes, size_bytes));
            if (vw_image_load(renamed, 1, &image)) fail_msg("%s: %s", samples[i].file, vw_error_message());
            float rgba[4];
            vw_image_pixel(&image, 3, 3, rgba);
            assert_near(rgba[0], 0, 0.02);
            assert_true(rgba[1] > 0.2 && rgba[2] > rgba[1] + 0.1 && rgba[2] < 0.8); // linear formats are brighter
        }
    }
}

// A sound file of each would be read by OpenImageIO if it were asked to find a reader: some of these readers crash.
FOLDER_TEST(other_formats_are_refused) {
    static const struct {
        const char *what, *bytes;
        size_t count;
    } files[] = {
        {"IFF",
         "FOR4\0\0\0\x40"
         "CIMGTBHD",
         16},
        {"FITS", "SIMPLE  =                    T", 30},
        {"DPX", "SDPX\0\0\x08\0V1.0", 12},
        {"Cineon", "\x80\x2a\x5f\xd7\0\0\x04\0", 8},
        {"GIF", "GIF89a\x01\0\x01\0", 10},
        {"PSD", "8BPS\0\1\0\0\0\0\0\0", 12},
        {"BMP", "BM\x3a\0\0\0\0\0\0\0", 10},
        {"DICOM", "\0\0\0\0\0\0\0\0\0\0\0\0DICM", 16},
        {"MP4",
         "\0\0\0\x18"
         "ftypmp42",
         12},
        {"HEIF",
         "\0\0\0\x18"
         "ftypheic",
         12},
        {"DDS", "DDS |\0\0\0", 8},
        {"SGI", "\x01\xda\1\1\0\3", 6},
        {"Matroska", "\x1a\x45\xdf\xa3", 4},
        {"RIFF that is not WebP", "RIFF\0\0\0\0AVI LIST", 16},
        {"half a WebP signature", "RIFF\0\0\0\0WEB", 11},
        {"half a PNG signature", "\x89PNG\r\n\x1a", 7},
        {"text", "not an image", 12},
        {"nothing", "", 0},
    };
    static const char *const names[] = {"a.png", "b.jpg", "c.null?RES=16000x16000", "d.fits", "e.iff"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(files); i++) {
        for (size_t j = 0; j < VW_ARRAY_COUNT(names); j++) {
            struct vw_image image = {0};
            const char *path = temporary_path(*state, names[j]);
            temporary_write(path, files[i].bytes, files[i].count);
            ASSERT_CASE_FAILS(files[i].what, vw_image_load(path, 1, &image), VW_ERROR_INPUT, path,
                              VW_PHOTO_FORMAT_NAMES);
            assert_null(image.pixels);
        }
    }
}

// ---- Limits ---------------------------------------------------------------------------------------------------------

// The headers of 1,025 photos of 1 GiB each.
FOLDER_TEST(the_photos_of_a_scene_have_a_limit) {
    static const uint8_t png[] = {0x89, 'P',  'N',  'G', '\r', '\n', 0x1a, '\n', 0,   0,   0,   13,   'I',  'H', 'D',
                                  'R',  0,    0,    64,  0,    0,    0,    64,   0,   8,   6,   0,    0,    0,   0xa9,
                                  0xc8, 0x10, 0x84, 0,   0,    0,    0,    'I',  'D', 'A', 'T', 0x35, 0xaf, 6,   0x1e};
    const struct vw_scene_params params = {.path = *state, .headers_only = true};
    AUTO_FREE char *first = vw_path_join(*state, "0.png");
    ASSERT_OK(vw_file_write(first, png, sizeof png));
    FILE *json = fopen(temporary_path(*state, "transforms.json"), "w");
    assert_non_null(json);
    fprintf(json, "{\"camera_angle_x\": 0.7, \"frames\": [");
    for (int i = 0; i < 1025; i++) {
        char name[32];
        snprintf(name, sizeof name, "%d.png", i);
        if (i > 0) assert_int_equal(link(first, temporary_path(*state, name)), 0);
        fprintf(json, "%s{\"file_path\": \"%s\", \"transform_matrix\": [[1,0,0,%d],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}",
                i > 0 ? ", " : "", name, i);
    }
    fprintf(json, "]}");
    assert_int_equal(fclose(json), 0);
    tiny_scene_refused(&params, VW_ERROR_INPUT, "/1024.png", "limit of 1024 GiB", "--downscale");
    struct vw_scene_params smaller = params;
    smaller.downscale = 2; // 16 bits of a quarter of the pixels
    struct vw_scene *scene = tiny_scene_open(&smaller);
    assert_int_equal(scene->views[1024].camera.width_px, 8192);
}

FOLDER_TEST(a_file_too_large_to_exist_is_refused) {
    struct vw_image_header header;
    const char *path = temporary_file(*state, "sparse.ppm", "P6\n1 1\n255\nabc");
    assert_int_equal(truncate(path, ((off_t)1 << 32) + 1), 0);
    ASSERT_FAILS(vw_image_probe(path, VW_IMAGE_OF_PATH, &header), VW_ERROR_INPUT,
                 "larger than the limit of 4294967296 bytes");
}

TEST_GROUP(tiny_decoder_hold, NULL)
