// Values for jansson that JSON itself cannot hold, and objects and arrays whose errors are checked once, at the end.
#ifndef VIEWWORTH_JSON_H
#define VIEWWORTH_JSON_H

#include <jansson.h>

// A number, or null for NaN and infinity. NULL if memory is short.
json_t *vw_json_real(double value);
// A text, or null for NULL. Invalid UTF-8 becomes U+FFFD, the replacement character. NULL if memory is short.
json_t *vw_json_string(const char *text);

// Append `value` to an array, or set it in an object; the container owns it then. When memory is short, or `value` is
// NULL (what jansson returns when memory is short), the container is dropped and becomes NULL. A NULL container drops
// the value. So only the finished document must be checked.
void vw_json_append(json_t **array, json_t *value);
void vw_json_set(json_t **object, const char *key, json_t *value);

#endif
