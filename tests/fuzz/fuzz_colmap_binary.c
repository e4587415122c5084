#include "fuzz/fuzz.h"

void fuzz_colmap_binary(const uint8_t *data, size_t size_bytes) {
    fuzz_write_model("sparse/0", "bin", data, size_bytes);
    fuzz_open(fuzz_folder(), "colmap");
}
