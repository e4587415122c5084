#include "base/json.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

json_t *vw_json_real(double value) { return isfinite(value) ? json_real(value) : json_null(); }

// The number of bytes of the UTF-8 character at `text`; 0 if it is invalid, as jansson decides.
static size_t character_bytes(const char *text) {
    for (size_t count = 1; count <= 4 && text[count - 1]; count++) {
        json_t *character = json_stringn(text, count);
        json_decref(character);
        if (character) return count;
    }
    return 0;
}

static char *repair(const char *text) {
    static const char replacement[] = "\xef\xbf\xbd";
    char *repaired = vw_allocate(3 * strlen(text) + 1, 1), *end = repaired;
    while (repaired && *text) {
        size_t count = character_bytes(text);
        memcpy(end, count ? text : replacement, count ? count : 3);
        end += count ? count : 3;
        text += count ? count : 1;
    }
    return repaired;
}

json_t *vw_json_string(const char *text) {
    if (!text) return json_null();
    json_t *string = json_string(text);
    if (string) return string;
    char *repaired = repair(text);
    string = repaired ? json_string(repaired) : NULL;
    free(repaired);
    return string;
}

static void drop(json_t **container) {
    json_decref(*container);
    *container = NULL;
}

// jansson drops a value that it cannot add, and refuses a NULL container.
void vw_json_append(json_t **array, json_t *value) {
    if (json_array_append_new(*array, value)) drop(array);
}

void vw_json_set(json_t **object, const char *key, json_t *value) {
    if (json_object_set_new(*object, key, value)) drop(object);
}
