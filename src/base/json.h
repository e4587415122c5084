// Reading with a bound on memory, values for jansson that JSON itself cannot express, and objects and arrays whose
// errors are checked once, at the end.
#ifndef VIEWWORTH_BASE_JSON_H
#define VIEWWORTH_BASE_JSON_H

#include <jansson.h>
#include <stdint.h>

#include "viewworth/status.h"

// Parses bytes as jansson does, for texts from files: refuses, in `error`, a text whose values would take more memory
// than VW_JSON_MEMORY_RATIO times its size and VW_JSON_MEMORY_BASE_BYTES more, before it takes any.
enum { VW_JSON_MEMORY_RATIO = 16, VW_JSON_MEMORY_BASE_BYTES = 16 << 20 };
json_t *vw_json_load(const char *text, size_t size_bytes, size_t flags, json_error_t *error);

// Parses the bytes of the file `path`; refuses duplicate keys. VW_ERROR_INPUT names the file, the line and the column.
enum vw_status vw_json_parse(const char *path, const char *text, size_t size_bytes, json_t **value);

// Reads and parses a file of at most `limit_bytes`.
enum vw_status vw_json_read_file(const char *path, size_t limit_bytes, json_t **value);
// Returns a number, or null for NaN and infinity. NULL if memory is short.
json_t *vw_json_real(double value);
// Returns the number that the value is with so many digits, as a text with JSON_REAL_PRECISION() reads back.
json_t *vw_json_rounded(double value, int digits);
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

// ---- Strict reading of objects -------------------------------------------------------------------------------------

// Unknown keys are refused and all ranges are checked. After the first failure, which
// the reader keeps, all calls do nothing: the caller checks once, after reading a list of fields.

enum { VW_JSON_PLACE_BYTES = 200 };

struct vw_json_reader {
    const char *path;                // path of the file, for messages
    char place[VW_JSON_PLACE_BYTES]; // the object being read: "shapes[2].texture"; "" at the top
    enum vw_status status;           // status of the first failure
};

// Fails with "path: place.key: message".
void vw_json_refuse(struct vw_json_reader *reader, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// Refuses what is not an object and keys that are not among `keys`, a list separated by spaces.
void vw_json_check_keys(struct vw_json_reader *reader, const json_t *object, const char *keys);

// Reads a number into `*value`, which contains the default. A default outside [least, most] (NaN, say) makes the key
// required.
void vw_json_number(struct vw_json_reader *reader, const json_t *object, const char *key, double least, double most,
                    double *value);
void vw_json_integer(struct vw_json_reader *reader, const json_t *object, const char *key, int64_t least, int64_t most,
                     int64_t *value);
void vw_json_numbers(struct vw_json_reader *reader, const json_t *object, const char *key, double least, double most,
                     double *values, size_t count);
// Reads one of `words`, a list separated by spaces; `*word` is its index. A default of -1 makes the key required.
void vw_json_word(struct vw_json_reader *reader, const json_t *object, const char *key, const char *words, int *word);
// Reads a text into `*text`, which contains the default; the text is borrowed from `object`.
void vw_json_text(struct vw_json_reader *reader, const json_t *object, const char *key, const char **text);
// A required array of at most `most` objects, read one by one with the place set to "key[i]".
typedef void vw_json_read_item(struct vw_json_reader *reader, const json_t *item, void *context);
void vw_json_each(struct vw_json_reader *reader, const json_t *object, const char *key, size_t most,
                  vw_json_read_item *read_item, void *context);
// Reads a member object with the place set to "key". A missing one is refused when `required`, else left out.
void vw_json_member(struct vw_json_reader *reader, const json_t *object, const char *key, int required,
                    vw_json_read_item *read_item, void *context);

#endif
