#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewworth/log.h"
#include "viewworth/status.h"

static _Thread_local char message[VW_ERROR_MESSAGE_BYTES];

#undef vw_fail // the header's macro, which serves the analyzer
#undef vw_fail_context

// Adds the remedy, which is the same in most of the many places where memory runs out or a file was edited.
static void add_remedy(enum vw_status status, char text[VW_ERROR_MESSAGE_BYTES]) {
    const char *remedy = status == VW_ERROR_MEMORY     ? "; close other programs or use --downscale"
                         : status == VW_ERROR_MISMATCH ? "; get the folder again from a copy or from where it was made"
                                                       : "";
    size_t used = strlen(text);
    if (!strchr(text, ';')) snprintf(text + used, VW_ERROR_MESSAGE_BYTES - used, "%s", remedy);
}

enum vw_status vw_fail(enum vw_status status, const char *format, ...) {
    char text[VW_ERROR_MESSAGE_BYTES]; // the arguments may point into `message`
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    add_remedy(status, text);
    vw_text_make_line(text);
    memcpy(message, text, sizeof message);
    return status;
}

enum vw_status vw_fail_context(enum vw_status status, const char *format, ...) {
    char context[VW_ERROR_MESSAGE_BYTES];
    char text[VW_ERROR_MESSAGE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(context, sizeof context, format, arguments);
    va_end(arguments);
    vw_text_make_line(context);
    int used = snprintf(text, sizeof text, "%.*s: ", VW_ERROR_MESSAGE_BYTES / 2, context);
    snprintf(text + used, sizeof text - (size_t)used, "%.*s", VW_ERROR_MESSAGE_BYTES - used - 1, message);
    memcpy(message, text, sizeof message);
    return status;
}

const char *vw_error_message(void) { return message; }

struct vw_saved_error vw_error_save(void) {
    struct vw_saved_error kept;
    memcpy(kept.message, message, sizeof message);
    return kept;
}

void vw_error_restore(const struct vw_saved_error *kept) { memcpy(message, kept->message, sizeof message); }

void vw_first_failure_note(struct vw_first_failure *failure, enum vw_status status) {
    if (failure->status || !status) return;
    failure->status = status;
    failure->why = vw_error_save();
}

enum vw_status vw_first_failure_report(const struct vw_first_failure *failure) {
    if (failure->status) vw_error_restore(&failure->why);
    return failure->status;
}

int vw_exit_code(enum vw_status status) {
    switch (status) {
    case VW_OK: return 0;
    case VW_ERROR_USAGE:
    case VW_ERROR_INPUT:
    case VW_ERROR_NO_DEVICE: return 2;
    default: return 1;
    }
}

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
