// Files of features, as numpy.save writes them.
#ifndef VIEWWORTH_TESTS_SUPPORT_FEATURE_FILE_H
#define VIEWWORTH_TESTS_SUPPORT_FEATURE_FILE_H

#include <stdint.h>

// Writes float32 numbers of height x width x channels to `path`.
void test_write_features(const char *path, uint32_t width, uint32_t height, uint32_t channels, const float *numbers);
// Writes a file with this text of its header, and these bytes after it.
void test_write_npy(const char *path, const char *header, const void *bytes, size_t size_bytes);

#endif
