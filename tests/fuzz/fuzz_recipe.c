#include "fuzz/fuzz.h"

void fuzz_recipe(const uint8_t *data, size_t size_bytes) {
    fuzz_open(fuzz_write("recipe.json", data, size_bytes), "recipe");
}
