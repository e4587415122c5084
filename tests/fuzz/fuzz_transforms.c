#include "fuzz/fuzz.h"

void fuzz_transforms(const uint8_t *data, size_t size_bytes) {
    fuzz_open(fuzz_write("transforms.json", data, size_bytes), "transforms");
}
