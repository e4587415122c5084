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

// Sends a message; one that does not fit the buffer is cut when memory is short.
static void send(enum vw_log_level level, const char *format, va_list arguments) {
    char line[LINE_BYTES], *longer = NULL;
    va_list again;
    if (!target.sink) return;
    va_copy(again, arguments);
    int length = vsnprintf(line, sizeof line, format, arguments);
    if (length >= LINE_BYTES) longer = malloc((size_t)length + 1);
    if (longer) vsnprintf(longer, (size_t)length + 1, format, again);
    va_end(again);
    vw_text_make_line(longer ? longer : line);
    target.sink(target.context, level, longer ? longer : line);
    free(longer);
}

void vw_log_info(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(VW_LOG_INFO, format, arguments);
    va_end(arguments);
}

void vw_log_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(VW_LOG_WARNING, format, arguments);
    va_end(arguments);
}

void vw_log_detail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    send(VW_LOG_DETAIL, format, arguments);
    va_end(arguments);
}
