// WebP files as texts (base64), as JSON files for pages have them.
#ifndef VIEWWORTH_IMAGE_WEBP_TEXT_H
#define VIEWWORTH_IMAGE_WEBP_TEXT_H

#include <stdbool.h>
#include <stddef.h>

enum { VW_WEBP_TEXT_LIMIT_BYTES = 1 << 18 };

// Makes the text of a WebP file, owned by the caller. NULL: memory is short.
char *vw_webp_to_text(const void *data, size_t size_bytes);
// Returns whether a text of a stranger begins as a WebP file in base64, is nothing but base64, and is no larger than
// the limit. NULL is none.
bool vw_is_webp_text(const char *text);

#endif
