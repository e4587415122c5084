// The function that libFuzzer calls: it calls the target FUZZ_TARGET.
#include "fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes) {
    FUZZ_TARGET(data, size_bytes);
    return 0;
}
