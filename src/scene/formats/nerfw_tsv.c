#include "scene/formats/nerfw_tsv.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 24; // a row takes about 60 bytes
enum { HEADER_LIMIT_BYTES = 1024 };

// ---- Lines ----

static char *next_line(char **rest) {
    char *line = strsep(rest, "\n");
    size_t length = strlen(line);
    if (length && line[length - 1] == '\r') line[length - 1] = 0;
    return line;
}

static int count_fields(const char *line) {
    int count = 1;
    for (; *line; line++) count += *line == '\t';
    return count;
}

// Finds the columns in a header without changing it.
static struct vw_tsv_columns find_columns(const char *line) {
    struct vw_tsv_columns columns = {-1, -1, -1, 0};
    for (const char *name = line; name; columns.count++) {
        size_t length = strcspn(name, "\t");
        if (length == 8 && !strncmp(name, "filename", length)) columns.filename = columns.count;
        if (length == 5 && !strncmp(name, "split", length)) columns.split = columns.count;
        if (length == 2 && !strncmp(name, "id", length)) columns.id = columns.count;
        name = name[length] ? name + length + 1 : NULL;
    }
    return columns;
}

static bool is_header(const struct vw_tsv_columns *columns) { return columns->filename >= 0 && columns->split >= 0; }

// Reads the row of the fields that were split last.
static enum vw_status take_row(const char *path, int line, const struct vw_tsv *tsv, struct vw_tsv_row *row) {
    char *const *fields = vw_tsv_fields(tsv, tsv->row_count);
    const char *filename = fields[tsv->columns.filename], *split = fields[tsv->columns.split];
    if (!*filename || !vw_text_is_clean(filename) || vw_path_leaves_folder(filename))
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%d: field filename: \"%s\" is not the name of a photo in dense/images; correct it", path,
                       line, filename);
    bool test = !strcmp(split, "test");
    if (!test && strcmp(split, "train") != 0)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: field split: \"%s\" is neither train nor test; correct it", path, line,
                       split);
    bool has_id = tsv->columns.id >= 0 && *fields[tsv->columns.id];
    *row = (struct vw_tsv_row){.name = filename, .test = test, .has_id = has_id, .line = line};
    return VW_OK;
}

// ---- Files ----

static const char *name_of_row(const void *rows, size_t place) { return ((const struct vw_tsv_row *)rows)[place].name; }

static enum vw_status check_unique(const char *path, const struct vw_tsv *tsv) {
    struct vw_name_index names;
    enum vw_status status = vw_name_index_make(name_of_row, tsv->rows, tsv->row_count, &names);
    for (size_t i = 0, place = 0; !status && i < tsv->row_count; i++) {
        const struct vw_tsv_row *row = &tsv->rows[i];
        if (!vw_name_index_find(&names, row->name, &place) || place == i) continue;
        const char *what = tsv->rows[place].test == row->test ? "appears twice" : "is in two splits, train and test";
        status = vw_fail(VW_ERROR_INPUT, "%s:%d: %s %s (first in line %d); keep one row", path, row->line, row->name,
                         what, tsv->rows[place].line);
    }
    vw_name_index_clear(&names);
    return status;
}

// Splits a line into fields, as many as the header has.
static enum vw_status take_fields(char *line, struct vw_tsv *tsv, size_t *capacity) {
    size_t count = (size_t)tsv->columns.count, used = count * (tsv->row_count + (tsv->fields != NULL));
    enum vw_status status = vw_grow((void **)&tsv->fields, capacity, used + count, sizeof *tsv->fields);
    char **next = tsv->fields + used;
    for (char *field; !status && (field = strsep(&line, "\t"));) *next++ = field;
    return status;
}

static enum vw_status read_row(const char *path, int line, char *text, struct vw_tsv *tsv, size_t *row_capacity,
                               size_t *field_capacity) {
    if (count_fields(text) != tsv->columns.count)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: %d fields, but the header has %d columns; separate fields by tabs", path,
                       line, count_fields(text), tsv->columns.count);
    enum vw_status status = take_fields(text, tsv, field_capacity);
    if (!status) status = vw_grow((void **)&tsv->rows, row_capacity, tsv->row_count + 1, sizeof *tsv->rows);
    if (!status) status = take_row(path, line, tsv, &tsv->rows[tsv->row_count]);
    if (!status) tsv->test_count += tsv->rows[tsv->row_count++].test;
    return status;
}

static enum vw_status read_rows(const char *path, struct vw_tsv *tsv) {
    char *rest = tsv->text, *header = next_line(&rest);
    size_t row_capacity = 0, field_capacity = 0;
    tsv->columns = find_columns(header);
    if (!is_header(&tsv->columns))
        return vw_fail(VW_ERROR_INPUT, "%s:1: the header lacks filename or split; give a NeRF-W TSV with both columns",
                       path);
    enum vw_status status = take_fields(header, tsv, &field_capacity);
    for (int line = 2; !status && rest; line++) {
        char *text = next_line(&rest);
        if (*text) status = read_row(path, line, text, tsv, &row_capacity, &field_capacity);
    }
    if (status) return status;
    if (!tsv->row_count) return vw_fail(VW_ERROR_INPUT, "%s: has no rows after the header; add rows", path);
    return check_unique(path, tsv);
}

enum vw_status vw_tsv_read(const char *folder, const char *path, struct vw_tsv *tsv) {
    struct vw_tsv read = {0};
    void *text;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(folder, path, FILE_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    read.text = text;
    if (memchr(text, 0, size_bytes)) status = vw_fail(VW_ERROR_INPUT, "%s: has a zero byte; give a text file", path);
    if (!status) status = read_rows(path, &read);
    if (status) vw_tsv_clear(&read);
    else *tsv = read;
    return status;
}

char *const *vw_tsv_fields(const struct vw_tsv *tsv, size_t row) {
    return tsv->fields + (row + 1) * (size_t)tsv->columns.count;
}

void vw_tsv_clear(struct vw_tsv *tsv) {
    free(tsv->rows);
    free(tsv->fields);
    free(tsv->text);
    *tsv = (struct vw_tsv){0};
}

bool vw_tsv_has_header(const char *folder, const char *path) {
    char text[HEADER_LIMIT_BYTES] = "", *rest = text;
    int descriptor = -1;
    if (vw_scene_file_open(folder, path, &descriptor)) return false;
    ssize_t got = read(descriptor, text, sizeof text - 1);
    close(descriptor);
    struct vw_tsv_columns columns = find_columns(next_line(&rest));
    return got > 0 && is_header(&columns);
}
