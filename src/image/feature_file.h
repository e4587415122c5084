// Maps of features as numpy.save writes them: .npy files of height x width x channels numbers, float16 or float32, in C
// order, rows from the top.
#ifndef VIEWWORTH_IMAGE_FEATURE_FILE_H
#define VIEWWORTH_IMAGE_FEATURE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

struct vw_feature_file {
    uint32_t width, height, channels; // each at least 1
    bool half;
    const uint8_t *numbers; // borrowed from the file's bytes, of any alignment
};

// Takes the bytes of a file, which must outlive the result; `path` is for messages. VW_ERROR_INPUT for anything else
// than such a file, and for a number that is not finite or beyond 1e30.
enum vw_status vw_feature_file_read(const char *path, const void *data, size_t size_bytes,
                                    struct vw_feature_file *file);
// Returns a number; channels of a cell follow one another, then cells of a row.
float vw_feature_file_number(const struct vw_feature_file *file, size_t index);

#endif
