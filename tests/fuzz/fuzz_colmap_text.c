#include "fuzz/fuzz.h"

void fuzz_colmap_text(const uint8_t *data, size_t size_bytes) {
    fuzz_write_model("sparse/0", "txt", data, size_bytes);
    fuzz_open(fuzz_folder(), "colmap");
}
