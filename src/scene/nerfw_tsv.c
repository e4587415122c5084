#include "scene/nerfw_tsv.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/safe_path.h"
#include "viewworth/file.h"
#include "viewworth/memory.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 26;
enum { HEADER_LIMIT_BYTES = 1024 };

// Which column holds what; -1: none.
struct columns {
    int filename, split, id, count;
};

struct fields {
    char *filename, *split, *id;
    int count;
};

// ---- Lines -----------------------------------------------------------------------------------------------------------------

static char *next_line(char **rest) {
    char *line = strsep(rest, "\n");
    size_t length = strlen(line);
    if (length && line[length - 1] == '\r') line[length - 1] = 0;
    return line;
}

static struct columns read_header(char *line) {
    struct columns columns = {-1, -1, -1, 0};
    for (char *name; (name = strsep(&line, "\t")); columns.count++) {
        if (!strcmp(name, "filename")) columns.filename = columns.count;
        if (!strcmp(name, "split")) columns.split = columns.count;
        if (!strcmp(name, "id")) columns.id = columns.count;
    }
    return columns;
}

static bool is_header(const struct columns *columns) { return columns->filename >= 0 && columns->split >= 0; }

static struct fields cut_row(const struct columns *columns, char *line) {
    struct fields fields = {0};
    for (char *field; (field = strsep(&line, "\t")); fields.count++) {
        if (fields.count == columns->filename) fields.filename = field;
        if (fields.count == columns->split) fields.split = field;
        if (fields.count == columns->id) fields.id = field;
    }
    return fields;
}

static enum vw_status take_row(const char *path, int line, const struct columns *columns, const struct fields *fields,
                               struct vw_tsv_row *row) {
    if (fields->count != columns->count)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: %d fields under a header of %d columns; separate them by tabs", path, line, fields->count,
                       columns->count);
    if (!*fields->filename || !vw_name_is_clean(fields->filename) || vw_path_leaves_folder(fields->filename))
        return vw_fail(VW_ERROR_INPUT, "%s:%d: field filename: \"%s\" is not the name of a photo in dense/images; correct it", path, line,
                       fields->filename);
    bool test = !strcmp(fields->split, "test");
    if (!test && strcmp(fields->split, "train") != 0)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: field split: \"%s\" is neither train nor test; correct it", path, line, fields->split);
    *row = (struct vw_tsv_row){.name = fields->filename, .test = test, .has_id = fields->id && *fields->id, .line = line};
    return VW_OK;
}

// ---- Files -----------------------------------------------------------------------------------------------------------------

static int compare_names(const void *a, const void *b) {
    const struct vw_tsv_row *left = *(const struct vw_tsv_row *const *)a, *right = *(const struct vw_tsv_row *const *)b;
    int order = strcmp(left->name, right->name);
    return order ? order : (left->line > right->line) - (left->line < right->line);
}

static enum vw_status check_unique(const char *path, const struct vw_tsv *tsv) {
    const struct vw_tsv_row **sorted = vw_allocate(tsv->row_count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < tsv->row_count; i++) sorted[i] = &tsv->rows[i];
    qsort(sorted, tsv->row_count, sizeof *sorted, compare_names);
    enum vw_status status = VW_OK;
    for (size_t i = 1; !status && i < tsv->row_count; i++) {
        const struct vw_tsv_row *first = sorted[i - 1], *second = sorted[i];
        if (strcmp(first->name, second->name) != 0) continue;
        const char *what = first->test == second->test ? "appears twice" : "is in two splits, train and test";
        status =
            vw_fail(VW_ERROR_INPUT, "%s:%d: %s %s (first in line %d); keep one row", path, second->line, second->name, what, first->line);
    }
    free(sorted);
    return status;
}

static enum vw_status read_rows(const char *path, struct vw_tsv *tsv) {
    char *rest = tsv->text;
    struct columns columns = read_header(next_line(&rest));
    if (!is_header(&columns))
        return vw_fail(VW_ERROR_INPUT, "%s:1: the header lacks filename or split; give a NeRF-W TSV with both columns", path);
    size_t capacity = 0;
    for (int line = 2; rest; line++) {
        char *text = next_line(&rest);
        if (!*text) continue;
        enum vw_status status = vw_grow((void **)&tsv->rows, &capacity, tsv->row_count + 1, sizeof *tsv->rows);
        struct fields fields = cut_row(&columns, text);
        if (!status) status = take_row(path, line, &columns, &fields, &tsv->rows[tsv->row_count]);
        if (status) return status;
        tsv->test_count += tsv->rows[tsv->row_count++].test;
    }
    if (!tsv->row_count) return vw_fail(VW_ERROR_INPUT, "%s: lists no photo below its header; add rows", path);
    return check_unique(path, tsv);
}

enum vw_status vw_tsv_read(const char *path, struct vw_tsv *tsv) {
    struct vw_tsv read = {0};
    void *text;
    size_t size_bytes;
    enum vw_status status = vw_file_read(path, FILE_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    read.text = text;
    if (memchr(text, 0, size_bytes)) status = vw_fail(VW_ERROR_INPUT, "%s: holds a zero byte; give a text file", path);
    if (!status) status = read_rows(path, &read);
    if (status) vw_tsv_clear(&read);
    else *tsv = read;
    return status;
}

void vw_tsv_clear(struct vw_tsv *tsv) {
    free(tsv->rows);
    free(tsv->text);
    *tsv = (struct vw_tsv){0};
}

bool vw_tsv_has_header(const char *path) {
    char text[HEADER_LIMIT_BYTES] = "";
    FILE *file = vw_file_exists(path) ? fopen(path, "r") : NULL;
    if (!file) return false;
    char *read = fgets(text, sizeof text, file), *rest = text;
    fclose(file);
    struct columns columns = read_header(next_line(&rest));
    return read && is_header(&columns);
}
