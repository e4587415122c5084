// Host memory: checked allocation. Everything allocated here is freed with free().
#ifndef VIEWWORTH_BASE_MEMORY_H
#define VIEWWORTH_BASE_MEMORY_H

#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

#define VW_ARRAY_COUNT(array) (sizeof(array) / sizeof((array)[0]))

// Allocates zeroed memory for `count` items of `item_bytes` each, owned by the caller; NULL with a recorded message
// (VW_ERROR_MEMORY) if memory is short or the product overflows. A count of 0 gives a valid pointer.
void *vw_allocate(size_t count, size_t item_bytes);

// Grows an array of `*capacity` items, by doubling, to at least `needed` items; new items are zero. After a failure the
// array and its capacity are unchanged.
enum vw_status vw_grow(void **array, size_t *capacity, size_t needed, size_t item_bytes);

// Returns VW_ERROR_MEMORY if the address space (ulimit -v) is limited to less than `base_mib` and 16 MiB for each of up
// to 32 processors: with less, the libraries of `what` crash or hang at their start.
enum vw_status vw_check_address_space(uint64_t base_mib, const char *what);

// Copies `text`; the copy is owned by the caller. NULL with a recorded message if memory is short.
char *vw_copy_text(const char *text);

// Formats a text as printf does, owned by the caller; NULL with a recorded message if memory is short.
char *vw_format_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
