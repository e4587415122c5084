// Strict reading of JSON objects: unknown keys are refused and all ranges are checked. After the first failure, which
// the reader keeps, all calls do nothing: the caller checks once, after reading a list of fields.
#ifndef VIEWWORTH_BASE_JSON_READER_H
#define VIEWWORTH_BASE_JSON_READER_H

#include <jansson.h>
#include <stdint.h>

#include "viewworth/status.h"

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
