#include "image/feature_file.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const float NUMBER_MOST = 1e30f; // sums of all channels stay finite

enum { PREFIX_BYTES = 10, HEADER_BYTES_MOST = 4096, SIDE_MOST = 16384, CHANNELS_MOST = 4096 };

static const char magic[] = "\x93NUMPY\x01"; // and a 0: version 1.0, which numpy takes for every array of numbers

static float half_number(uint16_t bits) {
    int exponent = bits >> 10 & 31, fraction = bits & 1023;
    float size = exponent == 31
                     ? (fraction ? NAN : INFINITY)
                     : ldexpf((float)(exponent ? fraction + 1024 : fraction), exponent ? exponent - 25 : -24);
    return bits >> 15 ? -size : size;
}

float vw_feature_file_number(const struct vw_feature_file *file, size_t index) {
    float number;
    uint16_t bits;
    if (!file->half) {
        memcpy(&number, file->numbers + 4 * index, sizeof number);
        return number;
    }
    memcpy(&bits, file->numbers + 2 * index, sizeof bits);
    return half_number(bits);
}

// Reads the text of the header. Returns whether it is what numpy writes of such an array, to the letter, with any
// number of spaces and the line end after it: what the numbers read would print is compared with the text.
static bool read_shape(const char *text, size_t length, struct vw_feature_file *file) {
    uint32_t item = 0;
    char expected[128];
    sscanf(text, "{'descr': '<f%1" SCNu32 "', 'fortran_order': False, 'shape': (%5" SCNu32 ", %5" SCNu32 ", %5" SCNu32,
           &item, &file->height, &file->width, &file->channels);
    size_t end = (size_t)snprintf(expected, sizeof expected,
                                  "{'descr': '<f%" PRIu32 "', 'fortran_order': False, 'shape': (%" PRIu32 ", %" PRIu32
                                  ", %" PRIu32 "), }",
                                  item, file->height, file->width, file->channels);
    file->half = item == 2;
    return (item == 2 || item == 4) && !strncmp(text, expected, end) && end + strspn(text + end, " \n") == length;
}

static enum vw_status read_header(const char *path, const uint8_t *data, size_t size_bytes,
                                  struct vw_feature_file *file) {
    char text[HEADER_BYTES_MOST + 1] = "";
    size_t length = size_bytes < PREFIX_BYTES || memcmp(data, magic, sizeof magic) != 0
                        ? SIZE_MAX
                        : data[8] + 256 * (size_t)data[9];
    if (length > HEADER_BYTES_MOST || length > size_bytes - PREFIX_BYTES)
        return vw_fail(VW_ERROR_INPUT, "%s: is no .npy file of version 1.0; write it by numpy.save", path);
    memcpy(text, data + PREFIX_BYTES, length);
    if (!read_shape(text, length, file))
        return vw_fail(VW_ERROR_INPUT,
                       "%s: holds \"%.100s\", not numbers of height x width x channels; write it by numpy.save(FILE, "
                       "numpy.ascontiguousarray(features, \"float32\"))",
                       path, text);
    file->numbers = data + PREFIX_BYTES + length;
    return VW_OK;
}

enum vw_status vw_feature_file_read(const char *path, const void *data, size_t size_bytes,
                                    struct vw_feature_file *file) {
    *file = (struct vw_feature_file){0};
    enum vw_status status = read_header(path, data, size_bytes, file);
    if (status) return status;
    if (!file->width || !file->height || !file->channels || file->width > SIDE_MOST || file->height > SIDE_MOST ||
        file->channels > CHANNELS_MOST)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: has %" PRIu32 " x %" PRIu32 " cells of %" PRIu32 " numbers; from 1 to %d a side and %d "
                       "numbers can be read",
                       path, file->width, file->height, file->channels, SIDE_MOST, CHANNELS_MOST);
    uint64_t count = (uint64_t)file->width * file->height * file->channels,
             there = size_bytes - (size_t)(file->numbers - (const uint8_t *)data);
    if (there != count * (file->half ? 2 : 4))
        return vw_fail(VW_ERROR_INPUT,
                       "%s: has %" PRIu64 " bytes of numbers, not the %" PRIu64 " that its header "
                       "promises; copy it again",
                       path, there, count * (file->half ? 2 : 4));
    for (uint64_t i = 0; i < count; i++)
        if (!(fabsf(vw_feature_file_number(file, i)) <= NUMBER_MOST))
            return vw_fail(VW_ERROR_INPUT,
                           "%s: number %" PRIu64 " is not finite, or beyond 1e30; compute the features again", path, i);
    return VW_OK;
}
