// Reading with a bound on memory, values for jansson that JSON itself cannot express, and objects and arrays whose
// errors are checked once, at the end.
#ifndef VIEWWORTH_BASE_JSON_H
#define VIEWWORTH_BASE_JSON_H

#include <jansson.h>

// Parses bytes as jansson does, for texts from files: refuses, in `error`, a text whose values would take more memory
// than VW_JSON_MEMORY_RATIO times its size and VW_JSON_MEMORY_BASE_BYTES more, before it takes any.
enum { VW_JSON_MEMORY_RATIO = 16, VW_JSON_MEMORY_BASE_BYTES = 16 << 20 };
json_t *vw_json_load(const char *text, size_t size_bytes, size_t flags, json_error_t *error);

// Parses the bytes of the file `path`; refuses duplicate keys. VW_ERROR_INPUT names the file, the line and the column.
enum vw_status vw_json_parse(const char *path, const char *text, size_t size_bytes, json_t **value);

// Returns a number, or null for NaN and infinity. NULL if memory is short.
json_t *vw_json_real(double value);
// Returns a text, or null for NULL. Invalid UTF-8 becomes U+FFFD, the replacement character. NULL if memory is short.
json_t *vw_json_string(const char *text);

// Appends `value` to an array, or sets it in an object; the container then owns it. When memory is short, or `value` is
// NULL (which jansson returns when memory is short), the container is dropped and becomes NULL. A NULL container drops
// the value. So only the finished document must be checked.
void vw_json_append(json_t **array, json_t *value);
void vw_json_set(json_t **object, const char *key, json_t *value);

// Returns the JSON text of a value, owned by the caller; NULL if memory is short, or for NULL. Use it instead of
// json_dumps(), which silently leaves out keys when memory is short.
char *vw_json_to_text(const json_t *value, size_t flags);
// Writes an object, of which it takes the reference, to a file, whole or not at all: indented, in ASCII.
// VW_ERROR_MEMORY where path or object is NULL.
enum vw_status vw_json_write_file(const char *path, json_t *object);

#endif
