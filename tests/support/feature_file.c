#include "support/cmocka_test.h"

#include "support/feature_file.h"
#include "support/temporary_folder.h"

enum { PREFIX_BYTES = 10, HEADER_BYTES = 118 }; // together a multiple of 64, as numpy has it

void test_write_npy(const char *path, const char *header, const void *bytes, size_t size_bytes) {
    AUTO_FREE char *file = vw_allocate(PREFIX_BYTES + HEADER_BYTES + size_bytes, 1);
    const char prefix[PREFIX_BYTES] = {'\x93', 'N', 'U', 'M', 'P', 'Y', 1, 0, HEADER_BYTES, 0};
    memcpy(file, prefix, PREFIX_BYTES);
    snprintf(file + PREFIX_BYTES, HEADER_BYTES, "%-*s", HEADER_BYTES - 1, header);
    file[PREFIX_BYTES + HEADER_BYTES - 1] = '\n';
    memcpy(file + PREFIX_BYTES + HEADER_BYTES, bytes, size_bytes);
    temporary_write(path, file, PREFIX_BYTES + HEADER_BYTES + size_bytes);
}

void test_write_features(const char *path, uint32_t width, uint32_t height, uint32_t channels, const float *numbers) {
    char header[HEADER_BYTES];
    snprintf(header, sizeof header, "{'descr': '<f4', 'fortran_order': False, 'shape': (%u, %u, %u), }", height, width,
             channels);
    test_write_npy(path, header, numbers, sizeof *numbers * width * height * channels);
}
