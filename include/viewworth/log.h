// Messages of the library during its work. The library does not print: every message goes to the sink of its thread.
#ifndef VIEWWORTH_LOG_H
#define VIEWWORTH_LOG_H

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

enum vw_log_level { VW_LOG_INFO, VW_LOG_WARNING, VW_LOG_DETAIL };

// Takes one message without a line end; `line` is valid for the call only.
typedef void vw_log_sink(void *context, enum vw_log_level level, const char *line);
// Sets the sink of this thread, and the context that it is called with. NULL, the default: silent.
void vw_log_set_sink(vw_log_sink *sink, void *context);

void vw_log_info(const char *format, ...) __attribute__((format(printf, 1, 2)));
void vw_log_warning(const char *format, ...) __attribute__((format(printf, 1, 2)));
void vw_log_detail(const char *format, ...) __attribute__((format(printf, 1, 2))); // evidence that few users want

VW_PUBLIC_END

#endif
