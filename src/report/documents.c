#include "report/documents.h"

#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"

enum { TABLE_LIMIT_BYTES = 16 << 20, RENDER_LIMIT_BYTES = 32 << 20, CELLS_MOST = 1 << 20 };

// ---- Shapes -------------------------------------------------------------------------

static bool has_text(const json_t *array, const char *text) {
    for (size_t i = 0; i < json_array_size(array); i++)
        if (strcmp(json_string_value(json_array_get(array, i)), text) == 0) return true;
    return false;
}

// Checks that a table, which people may have edited, has the columns that the script needs (NULL ends them). Further
// columns are allowed.
static enum vw_status check_table(const char *path, const char *const *columns, const json_t *header) {
    for (; *columns; columns++)
        if (!has_text(header, *columns))
            return vw_fail(VW_ERROR_INPUT, "%s: lacks the column %s; make it again, or remove it", path, *columns);
    return VW_OK;
}

// Checks what the page's headings need; the script says so where an item below them is not what it should be.
static enum vw_status check_comparison(const char *path, json_t *compare) {
    json_error_t error;
    if (!json_unpack_ex(compare, &error, JSON_VALIDATE_ONLY, "{s:s, s:s, s:i, s:i, s:[], s:[], s:[], s:[], s:[]}",
                        "scene", "scene_hash", "downscale", "epochs", "seeds", "lists", "pairs", "disagreements",
                        "renders"))
        return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: %s; compare again", path, error.text);
}

// ---- Pictures ------------------------------------------------------------------------------------------------------

// Returns whether a render's name stays within the folder: "renders/" and a plain name.
static bool is_render(const char *file) {
    static const char folder[] = "renders/";
    return file && strncmp(file, folder, strlen(folder)) == 0 && file[strlen(folder)] &&
           !strchr(file + strlen(folder), '/');
}

static enum vw_status read_picture(const char *out, const char *file, struct vw_report_picture *picture) {
    static const char signature[] = "\x89PNG\r\n\x1a\n";
    enum vw_status status = vw_file_read_inside(out, file, RENDER_LIMIT_BYTES, &picture->data, &picture->size_bytes);
    if (!status &&
        (picture->size_bytes < strlen(signature) || memcmp(picture->data, signature, strlen(signature)) != 0))
        status = vw_fail(VW_ERROR_INPUT, "%s/%s: is not a PNG file; compare again", out, file);
    return status;
}

static enum vw_status add_picture(const char *out, const char *file, struct vw_report_document *document) {
    if (!is_render(file))
        return vw_fail(VW_ERROR_INPUT, "%s/compare.json: renders: a file is none of renders/; compare again", out);
    char *name = vw_copy_text(file);
    struct vw_report_picture picture = {0};
    enum vw_status status = name ? read_picture(out, file, &picture) : VW_ERROR_MEMORY;
    if (status) {
        free(picture.data);
        free(name);
        return status;
    }
    ((const char **)document->picture_files)[document->picture_count] = name;
    ((struct vw_report_picture *)document->pictures)[document->picture_count++] = picture;
    return VW_OK;
}

static enum vw_status add_pictures(const char *out, struct vw_report_document *document) {
    const json_t *renders = json_object_get(document->content, "renders");
    document->picture_files = vw_allocate(json_array_size(renders), sizeof *document->picture_files);
    document->pictures = vw_allocate(json_array_size(renders), sizeof *document->pictures);
    enum vw_status status = document->picture_files && document->pictures ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; i < json_array_size(renders) && !status; i++)
        status = add_picture(out, json_string_value(json_object_get(json_array_get(renders, i), "file")), document);
    return status;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

static enum vw_status out_of_memory(const char *path) {
    return vw_fail(VW_ERROR_MEMORY, "%s: out of memory for its JSON", path);
}

static json_t *record_to_json(const struct vw_csv *csv) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < csv->field_count; i++) vw_json_append(&array, vw_json_string(csv->fields[i]));
    return array;
}

static enum vw_status read_rows(struct vw_csv *csv, json_t **rows) {
    bool found = true;
    size_t cells = 0;
    enum vw_status status = VW_OK;
    while (!(status = vw_csv_next(csv, &found)) && found) {
        cells += csv->field_count;
        if (cells > CELLS_MOST)
            return vw_fail(VW_ERROR_INPUT, "%s: has more than %d cells; remove it", csv->path, CELLS_MOST);
        vw_json_append(rows, record_to_json(csv));
    }
    return status;
}

static enum vw_status read_table(struct vw_csv *csv, const char *const *columns, json_t **table) {
    bool found = false;
    json_t *header = NULL, *rows = json_array();
    enum vw_status status = vw_csv_next(csv, &found);
    if (!status && !found) status = vw_fail(VW_ERROR_INPUT, "%s: is empty; remove it", csv->path);
    if (!status) header = record_to_json(csv);
    if (!status) status = header ? check_table(csv->path, columns, header) : out_of_memory(csv->path);
    if (!status) status = read_rows(csv, &rows);
    *table = json_pack("{s:o*, s:o*}", "header", header, "rows", rows);
    return status || (*table && rows) ? status : out_of_memory(csv->path);
}

// Reads the content of a file; a table has the columns that the page's script needs, compare.json has none. Frees the
// text.
static enum vw_status read_content(const char *path, const char *const *columns, void *text, size_t size_bytes,
                                   json_t **content) {
    struct vw_csv csv;
    json_error_t error;
    if (columns) {
        enum vw_status status = vw_csv_take(path, text, size_bytes, &csv);
        if (!status) status = read_table(&csv, columns, content);
        vw_csv_close(&csv);
        return status;
    }
    *content = vw_json_load(text, size_bytes, 0, &error);
    free(text);
    return *content ? check_comparison(path, *content)
                    : vw_fail(VW_ERROR_INPUT, "%s: line %d: %s", path, error.line, error.text);
}

#define COLUMNS(...) ((const char *const[]){__VA_ARGS__, NULL})

static const struct {
    const char *name, *const *columns;
} known[] = {
    {"providers.csv", COLUMNS("provider", "method", "photos", "value", "stderr")},
    {"payout.csv", COLUMNS("provider", "amount", "ci_low", "ci_high")},
    {"duplicates.csv", COLUMNS("group", "name", "provider", "split", "similarity", "value", "group_value")},
    {"tradeoff.csv",
     COLUMNS("configuration", "parameter", "value", "base", "train_ms", "value_ms", "scoring_ratio", "run_seconds",
             "val_psnr", "psnr_pareto_front", "method", "seed_pearson", "agreement_pearson")},
    {"summary.csv", COLUMNS("job", "state", "seconds", "photos", "steps", "val_psnr", "report", "message")},
    {"compare.json", NULL},
};

enum vw_status vw_report_documents_take(struct vw_report_documents *documents, const char *out, const char *file,
                                        json_t *content) {
    struct vw_report_document *document = NULL;
    enum vw_status status =
        vw_grow((void **)&documents->list, &documents->capacity, documents->count + 1, sizeof *documents->list);
    if (!status) document = &documents->list[documents->count++];
    else json_decref(content);
    if (status) return status;
    bool compares = strcmp(file, "compare.json") == 0;
    *document = (struct vw_report_document){
        .kind = compares ? "compare" : "table", .label = vw_copy_text(out), .file = file, .content = content};
    if (!document->label) return VW_ERROR_MEMORY;
    if (!content) return out_of_memory(file);
    return compares ? add_pictures(out, document) : VW_OK;
}

const struct vw_report_document *vw_report_documents_find(const struct vw_report_documents *documents, const char *out,
                                                          const char *file) {
    for (size_t i = 0; i < documents->count; i++)
        if (!strcmp(documents->list[i].file, file) && !strcmp(documents->list[i].label, out))
            return &documents->list[i];
    return NULL;
}

static enum vw_status add_file(struct vw_report_documents *documents, const char *out, const char *name,
                               const char *const *columns) {
    void *text = NULL;
    size_t size_bytes = 0;
    json_t *content = NULL;
    char *path = vw_path_join(out, name);
    if (!path) return VW_ERROR_MEMORY;
    bool held = vw_file_exists(path) && !vw_report_documents_find(documents, out, name);
    enum vw_status status = held ? vw_file_read_inside(out, name, TABLE_LIMIT_BYTES, &text, &size_bytes) : VW_OK;
    if (!status && held) status = read_content(path, columns, text, size_bytes, &content);
    if (status) json_decref(content);
    else if (held) status = vw_report_documents_take(documents, out, name, content);
    free(path);
    return status;
}

enum vw_status vw_report_documents_read(struct vw_report_documents *documents, const char *out,
                                        const struct vw_report_extra *extra) {
    enum vw_status status = extra ? add_file(documents, out, extra->file, extra->columns) : VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(known) && !status; i++)
        status = add_file(documents, out, known[i].name, known[i].columns);
    return status;
}

static void free_document(struct vw_report_document *document) {
    for (uint32_t i = 0; i < document->picture_count; i++) {
        free((char *)document->picture_files[i]);
        free(document->pictures[i].data);
    }
    free((void *)document->picture_files);
    free((void *)document->pictures);
    free((void *)document->thumbnail_names);
    free((void *)document->thumbnails);
    free((char *)document->label);
    json_decref(document->content);
}

void vw_report_documents_free(struct vw_report_documents *documents) {
    for (size_t i = 0; i < documents->count; i++) free_document(&documents->list[i]);
    free(documents->list);
    *documents = (struct vw_report_documents){0};
}
