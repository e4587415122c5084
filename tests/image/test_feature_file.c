// Files of features: what numpy.save writes is read; anything else is refused in one line.
#include "support/cmocka_test.h"

#include <math.h>

#include "image/feature_file.h"
#include "support/feature_file.h"
#include "support/temporary_folder.h"

static const float some[] = {0, 1, -2, 3.5f, 1e-3f, -7, 100, 1e29f, 9, 10, 11, 12};

static enum vw_status read(const char *path, void **data, struct vw_feature_file *file) {
    size_t size_bytes;
    *data = temporary_read(path, &size_bytes);
    return vw_feature_file_read(path, *data, size_bytes, file);
}

FOLDER_TEST(floats_are_read_in_their_order) {
    AUTO_FREE void *data = NULL;
    struct vw_feature_file file;
    const char *path = temporary_path(*state, "a.npy");
    test_write_features(path, 3, 2, 2, some);
    ASSERT_OK(read(path, &data, &file));
    assert_int_equal(file.width, 3);
    assert_int_equal(file.height, 2);
    assert_int_equal(file.channels, 2);
    for (size_t i = 0; i < 12; i++) assert_near(vw_feature_file_number(&file, i), some[i], 0.0);
}

FOLDER_TEST(halves_are_read) {
    static const uint16_t halves[] = {0, 0x8000, 0x3C00, 0xC000, 0x0001, 0x03FF, 0x0400, 0x7BFF, 0xFBFF, 0x3555};
    static const double values[] = {0, 0, 1, -2, 0x1p-24, 0x3FFp-24, 0x1p-14, 65504, -65504, 0x555p-12};
    AUTO_FREE void *data = NULL;
    struct vw_feature_file file;
    const char *path = temporary_path(*state, "a.npy");
    test_write_npy(path, "{'descr': '<f2', 'fortran_order': False, 'shape': (1, 5, 2), }", halves, sizeof halves);
    ASSERT_OK(read(path, &data, &file));
    for (size_t i = 0; i < 10; i++) assert_near(vw_feature_file_number(&file, i), values[i], 0.0);
}

static void refused(const char *path, const char *message) {
    AUTO_FREE void *data = NULL;
    struct vw_feature_file file;
    ASSERT_FAILS(read(path, &data, &file), VW_ERROR_INPUT, path, message);
}

FOLDER_TEST(other_arrays_are_refused) {
    static const char *const headers[] = {
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2, 3), }",
        "{'descr': '>f4', 'fortran_order': False, 'shape': (1, 2, 3), }",
        "{'descr': '<i4', 'fortran_order': False, 'shape': (1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': True, 'shape': (1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), } and more",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3",
        "{'descr': '<f 4', 'fortran_order': False, 'shape': (1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (+1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 2, 3), }",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3),),, }}",
        "{'descr': '<f4', 'fortran_order': False, 'shape': (123456, 2, 3), }",
        "",
    };
    const char *path = temporary_path(*state, "a.npy");
    for (size_t i = 0; i < VW_ARRAY_COUNT(headers); i++) {
        test_write_npy(path, headers[i], some, 24);
        refused(path, "height x width x channels");
    }
}

FOLDER_TEST(a_header_ends_with_spaces) {
    AUTO_FREE uint8_t *data = NULL;
    size_t size_bytes;
    const char *path = temporary_path(*state, "a.npy");
    test_write_features(path, 3, 1, 2, some);
    data = temporary_read(path, &size_bytes);
    data[100] = 0;
    temporary_write(path, data, size_bytes);
    refused(path, "height x width x channels");
}

FOLDER_TEST(sizes_that_do_not_fit_are_refused) {
    const char *path = temporary_path(*state, "a.npy"),
               *header = "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 2, 3), }";
    test_write_npy(path, header, some, 23);
    refused(path, "has 23 bytes of numbers, not the 24");
    test_write_npy(path, header, some, 25);
    refused(path, "has 25 bytes of numbers, not the 24");
    test_write_npy(path, "{'descr': '<f4', 'fortran_order': False, 'shape': (0, 2, 3), }", some, 0);
    refused(path, "from 1 to 16384 a side");
    test_write_npy(path, "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 1, 4097), }", some, 24);
    refused(path, "4097 numbers");
    refused(temporary_file(*state, "b.npy", "\x93NUMPY\x01"), "no .npy file");
    refused(temporary_file(*state, "c.npy", "PK\x03\x04 an archive of arrays"), "no .npy file");
    temporary_write(path, "\x93NUMPY\x01\0\x20\0{", 11);
    refused(path, "no .npy file");
    temporary_write(path, "\x93NUMPY\x02\0\0\0\0\0", 12);
    refused(path, "no .npy file");
}

FOLDER_TEST(numbers_that_are_none_are_refused) {
    const float bad[] = {NAN, INFINITY, -INFINITY, 2e30f};
    const char *path = temporary_path(*state, "a.npy");
    for (size_t i = 0; i < VW_ARRAY_COUNT(bad); i++) {
        const float numbers[] = {1, 2, bad[i], 3};
        test_write_features(path, 2, 1, 2, numbers);
        refused(path, "number 2 is not finite");
    }
}

TEST_GROUP(NULL, NULL)
