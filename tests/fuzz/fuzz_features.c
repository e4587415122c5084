#include "fuzz/fuzz.h"

#include <math.h>

#include "image/feature_file.h"

void fuzz_features(const uint8_t *data, size_t size_bytes) {
    struct vw_feature_file file;
    fuzz_forget_message();
    enum vw_status status = vw_feature_file_read("features.npy", data, size_bytes, &file);
    fuzz_check_message(status);
    if (status) return;
    size_t count = (size_t)file.width * file.height * file.channels;
    fuzz_check(count > 0, "sizes are sound");
    for (size_t i = 0; i < count; i++)
        fuzz_check(fabsf(vw_feature_file_number(&file, i)) <= 1e30f, "every number is finite");
}
