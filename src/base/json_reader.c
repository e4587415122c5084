#include "base/json_reader.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

void vw_json_refuse(struct vw_json_reader *reader, const char *key, const char *format, ...) {
    if (reader->status) return;
    char message[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    const char *dot = *reader->place && *key ? "." : "";
    reader->status = vw_fail(VW_ERROR_INPUT, "%s: %s%s%s: %s", reader->path, reader->place, dot, key, message);
}

static bool list_has(const char *list, const char *word, int *index) {
    size_t length = strlen(word);
    *index = 0;
    while (*list) {
        size_t item_length = strcspn(list, " ");
        if (item_length == length && !strncmp(list, word, length)) return true;
        list += item_length + (list[item_length] == ' ');
        (*index)++;
    }
    return false;
}

void vw_json_check_keys(struct vw_json_reader *reader, const json_t *object, const char *keys) {
    if (reader->status) return;
    if (!json_is_object(object)) {
        vw_json_refuse(reader, "", "expected an object with the keys: %s", keys);
        return;
    }
    const char *key;
    json_t *value;
    int index;
    json_object_foreach((json_t *)object, key, value) {
        if (!list_has(keys, key, &index)) vw_json_refuse(reader, key, "unknown key; remove it or use one of: %s", keys);
    }
}

static void check_number(struct vw_json_reader *reader, const char *key, const json_t *item, double least, double most,
                         double *value) {
    double number = item ? json_number_value(item) : *value;
    bool inside = number >= least && number <= most;
    if (item && !json_is_number(item)) vw_json_refuse(reader, key, "expected a number from %g to %g", least, most);
    else if (!item && !inside) vw_json_refuse(reader, key, "is missing; give a number from %g to %g", least, most);
    else if (!inside)
        vw_json_refuse(reader, key, "%g is out of range; give a number from %g to %g", number, least, most);
    else *value = number;
}

void vw_json_number(struct vw_json_reader *reader, const json_t *object, const char *key, double least, double most,
                    double *value) {
    if (!reader->status) check_number(reader, key, json_object_get(object, key), least, most, value);
}

void vw_json_integer(struct vw_json_reader *reader, const json_t *object, const char *key, int64_t least, int64_t most,
                     int64_t *value) {
    if (reader->status) return;
    const json_t *item = json_object_get(object, key);
    int64_t number = item ? json_integer_value(item) : *value;
    if ((item && !json_is_integer(item)) || number < least || number > most)
        vw_json_refuse(reader, key, "%s; give a whole number from %lld to %lld", item ? "is not allowed" : "is missing",
                       (long long)least, (long long)most);
    else *value = number;
}

void vw_json_numbers(struct vw_json_reader *reader, const json_t *object, const char *key, double least, double most,
                     double *values, size_t count) {
    if (reader->status) return;
    const json_t *array = json_object_get(object, key);
    if (array && (!json_is_array(array) || json_array_size(array) != count)) {
        vw_json_refuse(reader, key, "expected an array of %zu numbers", count);
        return;
    }
    for (size_t i = 0; i < count && !reader->status; i++)
        check_number(reader, key, json_array_get(array, i), least, most, &values[i]);
}

void vw_json_word(struct vw_json_reader *reader, const json_t *object, const char *key, const char *words, int *word) {
    if (reader->status) return;
    const json_t *item = json_object_get(object, key);
    if (!item && *word >= 0) return;
    int index = 0;
    if (!json_is_string(item) || !list_has(words, json_string_value(item), &index))
        vw_json_refuse(reader, key, "%s; use one of: %s", item ? "is not allowed" : "is missing", words);
    else *word = index;
}

void vw_json_text(struct vw_json_reader *reader, const json_t *object, const char *key, const char **text) {
    const json_t *item = json_object_get(object, key);
    if (reader->status || !item) return;
    if (!json_is_string(item)) vw_json_refuse(reader, key, "expected a text");
    else *text = json_string_value(item);
}

// Reads `item` with `name` added to the place.
static void read_inside(struct vw_json_reader *reader, const char *name, const json_t *item,
                        vw_json_read_item *read_item, void *context) {
    size_t outer = strlen(reader->place);
    snprintf(reader->place + outer, sizeof reader->place - outer, "%s%s", outer ? "." : "", name);
    read_item(reader, item, context);
    reader->place[outer] = 0;
}

void vw_json_each(struct vw_json_reader *reader, const json_t *object, const char *key, size_t most,
                  vw_json_read_item *read_item, void *context) {
    if (reader->status) return;
    const json_t *array = json_object_get(object, key);
    if (!json_is_array(array) || json_array_size(array) > most) {
        vw_json_refuse(reader, key, "expected an array of at most %zu objects", most);
        return;
    }
    for (size_t i = 0; i < json_array_size(array) && !reader->status; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s[%zu]", key, i);
        read_inside(reader, name, json_array_get(array, i), read_item, context);
    }
}

void vw_json_member(struct vw_json_reader *reader, const json_t *object, const char *key, int required,
                    vw_json_read_item *read_item, void *context) {
    if (reader->status) return;
    const json_t *item = json_object_get(object, key);
    if (item) read_inside(reader, key, item, read_item, context);
    else if (required) vw_json_refuse(reader, key, "is missing; give an object");
}
