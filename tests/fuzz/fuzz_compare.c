#include "fuzz/fuzz.h"

void fuzz_compare(const uint8_t *data, size_t size_bytes) { fuzz_check_report("compare.json", data, size_bytes); }
