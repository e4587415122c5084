#include "base/memory.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

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

enum vw_status vw_check_address_space(uint64_t base_mib, const char *what) {
    enum { THREAD_MIB = 16, THREADS_MAX = 32 };
    struct rlimit limit;
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    long threads = processors < 1 ? 1 : processors > THREADS_MAX ? THREADS_MAX : processors;
    uint64_t needed_mib = base_mib + THREAD_MIB * (uint64_t)threads;
    if (getrlimit(RLIMIT_AS, &limit) || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >> 20 >= needed_mib)
        return VW_OK;
    return vw_fail(VW_ERROR_MEMORY,
                   "the address space is limited to %" PRIu64 " MiB, too little for %s; allow %" PRIu64
                   " MiB (ulimit -v)",
                   (uint64_t)limit.rlim_cur >> 20, what, needed_mib);
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
