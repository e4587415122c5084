// Messages of the library during its work. The library does not print: every message goes to the sink of its thread.
#ifndef VIEWWORTH_LOG_H
#define VIEWWORTH_LOG_H

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_log_level { VW_LOG_INFO, VW_LOG_WARNING };

// Takes one message without a line end; `line` is valid for the call only.
typedef void vw_log_sink(void *context, enum vw_log_level level, const char *line);
// Sets the sink of this thread, and the context that it is called with. NULL, the default: silent.
void vw_log_set_sink(vw_log_sink *sink, void *context);

void vw_log(enum vw_log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));
#define vw_log_info(...) vw_log(VW_LOG_INFO, __VA_ARGS__)
#define vw_log_warning(...) vw_log(VW_LOG_WARNING, __VA_ARGS__)

VW_PUBLIC_END

#endif
