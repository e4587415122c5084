// Values for jansson that JSON itself cannot hold.
#ifndef VIEWWORTH_JSON_H
#define VIEWWORTH_JSON_H

#include <jansson.h>

// A number, or null for what JSON cannot say (NaN, infinity). NULL when memory is short.
json_t *vw_json_real(double value);
// A text, null for NULL. Bytes that are no UTF-8 become U+FFFD, the replacement character. NULL when memory is short.
json_t *vw_json_string(const char *text);

#endif
