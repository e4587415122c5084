// A stream into memory that knows whether all that was printed is there. The one of the C library (glibc's
// open_memstream) drops what finds no memory and reports nothing: half a table would pass as a whole one.
#ifndef VIEWWORTH_BASE_TEXT_STREAM_H
#define VIEWWORTH_BASE_TEXT_STREAM_H

#include <stddef.h>
#include <stdio.h>

#include "viewworth/status.h"

struct vw_text_stream {
    FILE *stream; // NULL if memory is short
    char *text;
    size_t size_bytes, capacity_bytes;
};

// Returns the stream to print to, which is text->stream; `text` must not move until it is closed.
FILE *vw_text_stream_open(struct vw_text_stream *text);
// Returns the printed text with a zero byte after it; `*printed` is owned by the caller. VW_ERROR_MEMORY, which names
// `what`, if anything is missing.
enum vw_status vw_text_stream_close(struct vw_text_stream *text, const char *what, char **printed, size_t *size_bytes);

#endif
