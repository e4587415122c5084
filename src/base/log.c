#include "viewworth/log.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "viewworth/status.h"

enum { LINE_BYTES = 1024 };

static _Thread_local struct {
    vw_log_sink *sink;
    void *context;
} target;

void vw_log_set_sink(vw_log_sink *sink, void *context) {
    target.sink = sink;
    target.context = context;
}

// Cuts a message that does not fit the buffer when memory is short.
void vw_log(enum vw_log_level level, const char *format, ...) {
    char line[LINE_BYTES], *longer = NULL;
    va_list arguments, again;
    if (!target.sink) return;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(line, sizeof line, format, arguments);
    if (length >= LINE_BYTES) longer = malloc((size_t)length + 1);
    if (longer) vsnprintf(longer, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    vw_text_make_line(longer ? longer : line);
    target.sink(target.context, level, longer ? longer : line);
    free(longer);
}
