#include "base/json.h"

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"

// ---- Reading -------------------------------------------------------------------------------------------------------

// The most memory that jansson and malloc take, with a place in the container that contains the value. Containers grow
// by doubling, and keep the smaller one until the larger one is filled.
enum { ARRAY_BYTES = 152, OBJECT_BYTES = 248, NUMBER_BYTES = 56, TEXT_BYTES = 104 };

// A text while its values are counted.
struct scan {
    const char *next, *end;
    size_t cost_bytes;
};

static void skip_text(struct scan *scan) {
    const char *begin = scan->next++;
    while (scan->next < scan->end && *scan->next != '"') scan->next += *scan->next == '\\' ? 2 : 1;
    if (scan->next > scan->end) scan->next = scan->end;
    scan->cost_bytes += TEXT_BYTES + (size_t)(scan->next - begin);
    if (scan->next < scan->end) scan->next++;
}

static void skip_number(struct scan *scan) {
    scan->cost_bytes += NUMBER_BYTES;
    while (scan->next < scan->end && *scan->next && !strchr(" \t\r\n,:[]{}\"", *scan->next)) scan->next++;
}

static void skip_value(struct scan *scan) {
    switch (*scan->next) {
    case '[': scan->cost_bytes += ARRAY_BYTES, scan->next++; break;
    case '{': scan->cost_bytes += OBJECT_BYTES, scan->next++; break;
    case '"': skip_text(scan); break;
    case ' ':
    case '\t':
    case '\r':
    case '\n':
    case ',':
    case ':':
    case ']':
    case '}':
    case 0: scan->next++; break;
    default: skip_number(scan);
    }
}

static void fail_at(const char *text, const char *place, json_error_t *error) {
    if (!error) return;
    *error = (json_error_t){.line = 1};
    for (; text < place; text++) {
        error->column = *text == '\n' ? 0 : error->column + 1;
        error->line += *text == '\n';
    }
    strcpy(error->text, "so many small values would take too much memory for the size of the text");
}

json_t *vw_json_load(const char *text, size_t size_bytes, size_t flags, json_error_t *error) {
    size_t limit_bytes = VW_JSON_MEMORY_BASE_BYTES + VW_JSON_MEMORY_RATIO * size_bytes;
    struct scan scan = {.next = text, .end = text + size_bytes};
    while (scan.next < scan.end && scan.cost_bytes <= limit_bytes) skip_value(&scan);
    if (scan.cost_bytes <= limit_bytes) return json_loadb(text, size_bytes, flags, error);
    fail_at(text, scan.next, error);
    return NULL;
}

enum vw_status vw_json_parse(const char *path, const char *text, size_t size_bytes, json_t **value) {
    json_error_t error;
    *value = vw_json_load(text, size_bytes, JSON_REJECT_DUPLICATES, &error);
    if (*value) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s:%d:%d: not valid JSON: %s; correct this line", path, error.line, error.column,
                   error.text);
}

enum vw_status vw_json_read_file(const char *path, size_t limit_bytes, json_t **value) {
    void *text = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read(path, limit_bytes, &text, &size_bytes);
    if (!status) status = vw_json_parse(path, text, size_bytes, value);
    free(text);
    return status;
}

// ---- Values --------------------------------------------------------------------------------------------------------

// Returns 0 for -0, which a ledger does not keep.
json_t *vw_json_real(double value) { return isfinite(value) ? json_real(value == 0 ? 0 : value) : json_null(); }

json_t *vw_json_rounded(double value, int digits) {
    char text[64];
    snprintf(text, sizeof text, "%.*g", digits, value);
    return vw_json_real(strtod(text, NULL));
}

// Returns the number of bytes of the UTF-8 character at `text`; 0 if it is invalid, as jansson decides.
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

// Relies on jansson, which drops a value that it cannot add, and refuses a NULL container.
void vw_json_append(json_t **array, json_t *value) {
    if (json_array_append_new(*array, value)) drop(array);
}

void vw_json_set(json_t **object, const char *key, json_t *value) {
    if (json_object_set_new(*object, key, value)) drop(object);
}

char *vw_json_to_text(const json_t *value, size_t flags) {
    struct vw_text_stream text;
    char *printed = NULL;
    size_t size_bytes = 0;
    if (!value) return NULL;
    bool failed = vw_text_stream_open(&text) && json_dumpf(value, text.stream, flags);
    if (vw_text_stream_close(&text, "JSON", &printed, &size_bytes) || !failed) return printed;
    free(printed);
    return NULL;
}

enum vw_status vw_json_write_file(const char *path, json_t *object) {
    char *text = vw_json_to_text(object, JSON_INDENT(2) | JSON_ENSURE_ASCII);
    enum vw_status status =
        path && text ? vw_file_write(path, text, strlen(text)) : vw_fail(VW_ERROR_MEMORY, "out of memory for JSON");
    json_decref(object);
    free(text);
    return status;
}

// ---- Strict reading of objects -------------------------------------------------------------------------------------

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
