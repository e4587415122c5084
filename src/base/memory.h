// Host memory: checked allocation. Everything allocated here is freed with free().
#ifndef VIEWWORTH_MEMORY_H
#define VIEWWORTH_MEMORY_H

#include <stddef.h>

#include "viewworth/status.h"

#define VW_ARRAY_COUNT(array) (sizeof(array) / sizeof((array)[0]))

// Zeroed memory for `count` items of `item_bytes` each, to be freed by the caller; NULL with a recorded message
// (VW_ERROR_MEMORY) when there is none or the product overflows. A count of 0 gives a valid pointer.
void *vw_allocate(size_t count, size_t item_bytes);

// Grows an array that holds `*capacity` items so that it holds at least `needed`, doubling; new items are zero.
// On failure the array and its capacity are as before.
enum vw_status vw_grow(void **array, size_t *capacity, size_t needed, size_t item_bytes);

// A copy of `text`, to be freed by the caller; NULL with a recorded message when memory is short.
char *vw_copy_text(const char *text);

// A printf-formatted string, to be freed by the caller; NULL with a recorded message when memory is short.
char *vw_format_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
