#include "base/text_stream.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// Appends to the text. A stream takes 0 bytes written as a failure, which it remembers.
static ssize_t append(void *cookie, const char *bytes, size_t size_bytes) {
    struct vw_text_stream *text = cookie;
    if (vw_grow((void **)&text->text, &text->capacity_bytes, text->size_bytes + size_bytes + 1, 1)) return 0;
    memcpy(text->text + text->size_bytes, bytes, size_bytes);
    text->size_bytes += size_bytes;
    text->text[text->size_bytes] = 0;
    return (ssize_t)size_bytes;
}

FILE *vw_text_stream_open(struct vw_text_stream *text) {
    *text = (struct vw_text_stream){0};
    if (append(text, "", 0) == 0 && text->text)
        text->stream = fopencookie(text, "w", (cookie_io_functions_t){.write = append});
    return text->stream;
}

enum vw_status vw_text_stream_close(struct vw_text_stream *text, const char *what, char **printed, size_t *size_bytes) {
    bool failed = !text->stream || ferror(text->stream);
    if (text->stream && fclose(text->stream)) failed = true;
    text->stream = NULL;
    if (failed) {
        free(text->text);
        return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for its text; close other programs", what);
    }
    *printed = text->text;
    *size_bytes = text->size_bytes;
    return VW_OK;
}
