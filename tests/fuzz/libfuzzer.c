// The functions that libFuzzer calls: they call the target FUZZ_TARGET.
#include "fuzz/fuzz.h"

int LLVMFuzzerInitialize(int *argument_count, char ***arguments);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes);

// Tries no bytes before inputs are timed: what a target prepares once, such as a decoder, may take longer than one.
int LLVMFuzzerInitialize(int *argument_count, char ***arguments) {
    static const uint8_t none[1];
    (void)argument_count, (void)arguments;
    FUZZ_TARGET(none, 0);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size_bytes) {
    FUZZ_TARGET(data, size_bytes);
    return 0;
}
