#include "base/memory.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *vw_allocate(size_t count, size_t item_bytes) {
    void *memory = calloc(count ? count : 1, item_bytes);
    if (!memory)
        vw_fail(VW_ERROR_MEMORY, "out of memory: %zu items of %zu bytes; close other programs or use --downscale",
                count, item_bytes);
    return memory;
}

enum vw_status vw_grow(void **array, size_t *capacity, size_t needed, size_t item_bytes) {
    if (needed <= *capacity) return VW_OK;
    size_t larger = *capacity ? *capacity : 16;
    while (larger < needed && larger <= SIZE_MAX / 2) larger *= 2;
    void *memory = larger < needed ? NULL : reallocarray(*array, larger, item_bytes);
    if (!memory) return vw_fail(VW_ERROR_MEMORY, "out of memory: %zu items of %zu bytes", needed, item_bytes);
    memset((char *)memory + *capacity * item_bytes, 0, (larger - *capacity) * item_bytes);
    *array = memory;
    *capacity = larger;
    return VW_OK;
}

char *vw_copy_text(const char *text) { return vw_format_text("%s", text); }

char *vw_format_text(const char *format, ...) {
    char *text = NULL;
    va_list arguments;
    va_start(arguments, format);
    int length = vasprintf(&text, format, arguments);
    va_end(arguments);
    if (length >= 0) return text;
    vw_fail(VW_ERROR_MEMORY, "out of memory for a string");
    return NULL;
}
