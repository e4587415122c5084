// PhotoTourism scenes as NeRF-W uses them: dense/images, a COLMAP model in dense/sparse, and a TSV that names the test
// photos.
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/colmap.h"
#include "scene/formats/nerfw_tsv.h"

// ---- The TSV -------------------------------------------------------------------------------------------------------

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 24; // a row takes about 60 bytes
enum { HEADER_LIMIT_BYTES = 1024 };

static enum vw_status open_table(const char *path, void *text, size_t size_bytes, struct vw_csv *csv) {
    enum vw_status status = vw_csv_take(path, text, size_bytes, csv);
    csv->separator = '\t';
    return status;
}

static struct vw_tsv_columns find_columns(const struct vw_csv *header) {
    struct vw_tsv_columns columns = {-1, -1, -1, (int)header->field_count};
    for (int i = 0; i < columns.count; i++) {
        if (!strcmp(header->fields[i], "filename")) columns.filename = i;
        if (!strcmp(header->fields[i], "split")) columns.split = i;
        if (!strcmp(header->fields[i], "id")) columns.id = i;
    }
    return columns;
}

static bool is_header(const struct vw_tsv_columns *columns) { return columns->filename >= 0 && columns->split >= 0; }

// Reads the row of the fields that were added last.
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

static enum vw_status check_unique(const char *path, const struct vw_tsv *tsv) {
    struct vw_name_index names;
    enum vw_status status =
        vw_name_index_make(tsv->rows, sizeof *tsv->rows, offsetof(struct vw_tsv_row, name), tsv->row_count, &names);
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

// Adds the fields of the current record, as many as the header has.
static enum vw_status add_fields(const struct vw_csv *csv, struct vw_tsv *tsv, size_t *capacity) {
    size_t count = (size_t)tsv->columns.count, used = count * (tsv->row_count + (tsv->fields != NULL));
    if (csv->field_count != count)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %u fields, but the header has %zu columns; separate fields by tabs",
                       csv->path, csv->line, csv->field_count, count);
    enum vw_status status = vw_grow((void **)&tsv->fields, capacity, used + count, sizeof *tsv->fields);
    if (!status) memcpy(tsv->fields + used, csv->fields, count * sizeof *tsv->fields);
    return status;
}

static enum vw_status read_rows(struct vw_csv *csv, struct vw_tsv *tsv) {
    size_t row_capacity = 0, field_capacity = 0;
    bool found = false;
    enum vw_status status = vw_csv_next(csv, &found);
    tsv->columns = find_columns(csv);
    if (!status && !is_header(&tsv->columns))
        status = vw_fail(VW_ERROR_INPUT,
                         "%s:1: the header lacks filename or split; give a NeRF-W TSV with both columns", csv->path);
    if (!status) status = add_fields(csv, tsv, &field_capacity);
    while (!status && !(status = vw_csv_next(csv, &found)) && found) {
        status = add_fields(csv, tsv, &field_capacity);
        if (!status) status = vw_grow((void **)&tsv->rows, &row_capacity, tsv->row_count + 1, sizeof *tsv->rows);
        if (!status) status = take_row(csv->path, (int)csv->line, tsv, &tsv->rows[tsv->row_count]);
        if (!status) tsv->test_count += tsv->rows[tsv->row_count++].test;
    }
    if (status) return status;
    if (!tsv->row_count) return vw_fail(VW_ERROR_INPUT, "%s: has no rows after the header; add rows", csv->path);
    return check_unique(csv->path, tsv);
}

enum vw_status vw_tsv_read(const char *folder, const char *path, struct vw_tsv *tsv) {
    struct vw_tsv read = {0};
    struct vw_csv csv;
    void *text;
    size_t size_bytes;
    enum vw_status status = vw_scene_file_read(folder, path, FILE_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    status = open_table(path, text, size_bytes, &csv);
    if (!status) status = read_rows(&csv, &read);
    read.text = csv.text;
    csv.text = NULL;
    vw_csv_close(&csv);
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
    char *text = vw_allocate(HEADER_LIMIT_BYTES, 1);
    struct vw_csv csv;
    int descriptor = -1;
    bool found = false;
    if (!text || vw_scene_file_open(folder, path, &descriptor)) {
        free(text);
        return false;
    }
    ssize_t got = read(descriptor, text, HEADER_LIMIT_BYTES - 1);
    close(descriptor);
    found = !open_table(path, text, got > 0 ? (size_t)got : 0, &csv) && !vw_csv_next(&csv, &found) && found;
    struct vw_tsv_columns columns = find_columns(&csv);
    vw_csv_close(&csv);
    return found && is_header(&columns);
}

// ---- Finding the TSV ----

// Finds *.tsv files with the header of a NeRF-W TSV; `*path` (owned by the caller) is the first by name, `*count` their
// number.
static enum vw_status find_tsv(const char *folder, char **path, int *count) {
    struct dirent **entries = NULL;
    int entry_count = scandir(folder, &entries, NULL, alphasort);
    enum vw_status status = VW_OK;
    for (int i = 0; i < entry_count; i++) {
        const char *dot = strrchr(entries[i]->d_name, '.');
        char *file = dot && !strcmp(dot, ".tsv") ? vw_path_join(folder, entries[i]->d_name) : NULL;
        if (file && vw_tsv_has_header(folder, file)) {
            (*count)++;
            if (!*path) *path = vw_copy_text(file);
            if (!*path) status = VW_ERROR_MEMORY;
        }
        free(file);
        free(entries[i]);
    }
    free(entries);
    return status;
}

bool vw_phototourism_probe(const char *path) {
    char *tsv_path = NULL, *dense = vw_path_join(path, "dense");
    int count = 0;
    bool found = dense && vw_folder_exists(dense) && !find_tsv(path, &tsv_path, &count) && count > 0;
    free(tsv_path);
    free(dense);
    return found;
}

enum vw_status vw_phototourism_read_tsv(const char *folder, struct vw_tsv *tsv) {
    char *path = NULL;
    int count = 0;
    enum vw_status status = find_tsv(folder, &path, &count);
    if (!status && !count)
        status = vw_fail(
            VW_ERROR_INPUT,
            "%s: has no TSV with the columns filename and split; add the NeRF-W TSV, or use --format colmap", folder);
    if (!status && count > 1)
        status = vw_fail(VW_ERROR_INPUT, "%s: has %d TSV files with the columns filename and split; keep one of them",
                         folder, count);
    if (!status) status = vw_tsv_read(folder, path, tsv);
    free(path);
    return status;
}

// ---- Rows to splits ----

struct assignment {
    struct vw_scene *scene;
    const struct vw_colmap_model *model;
    const uint32_t *views; // view of each of the model's images; UINT32_MAX: the photo is missing
    bool *listed;          // owned; of each view
    uint32_t *test_views;  // owned; in the order of the TSV
    uint32_t test_count;
    size_t skipped_count, skipped_test_count, no_id_count;
    const char *first_skipped;
};

static void assign_row(const struct vw_tsv_row *row, struct assignment *assignment) {
    ptrdiff_t image = vw_colmap_find_image(assignment->model, row->name);
    uint32_t view = image < 0 ? UINT32_MAX : assignment->views[image];
    if (view == UINT32_MAX) {
        if (!assignment->skipped_count++) assignment->first_skipped = row->name;
        assignment->skipped_test_count += row->test;
        return;
    }
    assignment->listed[view] = true;
    assignment->no_id_count += !row->has_id;
    if (row->test) assignment->test_views[assignment->test_count++] = view;
}

// Assigns the first half of the test rows to validation, the second to tests.
static void apply(struct assignment *assignment, bool list_only) {
    struct vw_view *views = assignment->scene->views;
    for (uint32_t v = 0; v < assignment->scene->view_count; v++)
        if (list_only && !assignment->listed[v]) views[v].split = VW_SPLIT_EXCLUDED;
    for (uint32_t i = 0; i < assignment->test_count; i++)
        views[assignment->test_views[i]].split = i < (assignment->test_count + 1) / 2 ? VW_SPLIT_VAL : VW_SPLIT_TEST;
}

static enum vw_status note_rows(const struct vw_tsv *tsv, const struct assignment *assignment, bool list_only) {
    struct vw_scene *scene = assignment->scene;
    size_t listed_count = tsv->row_count - assignment->skipped_count;
    enum vw_status status = VW_OK;
    if (assignment->skipped_count)
        status = vw_scene_note(
            scene,
            "%zu of %zu TSV rows skipped (%zu of them test): their photo is not registered or does not exist "
            "(first: %s)",
            assignment->skipped_count, tsv->row_count, assignment->skipped_test_count, assignment->first_skipped);
    if (!status && assignment->no_id_count)
        status =
            vw_scene_note(scene, "%zu TSV rows have no id but are used, because photos are identified by file name",
                          assignment->no_id_count);
    if (!status && listed_count < scene->view_count)
        status =
            vw_scene_note(scene, "%zu registered photos are not in the TSV and %s", scene->view_count - listed_count,
                          list_only ? "are excluded (--pool list)" : "are train photos (--pool list excludes them)");
    if (!status && !assignment->test_count)
        status = vw_scene_note(scene,
                               "the TSV has no test row with a registered photo: every eighth photo is for validation");
    return status;
}

static enum vw_status assign_splits(const struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                                    const uint32_t *views, const struct vw_tsv *tsv) {
    const bool list_only = builder->params->pool && !strcmp(builder->params->pool, "list");
    struct assignment assignment = {.scene = builder->scene,
                                    .model = model,
                                    .views = views,
                                    .listed = vw_allocate(builder->scene->view_count, sizeof *assignment.listed),
                                    .test_views = vw_allocate(tsv->test_count, sizeof *assignment.test_views)};
    enum vw_status status = assignment.listed && assignment.test_views ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < tsv->row_count; i++) assign_row(&tsv->rows[i], &assignment);
    if (!status) {
        apply(&assignment, list_only);
        status = note_rows(tsv, &assignment, list_only);
    }
    free(assignment.listed);
    free(assignment.test_views);
    return status;
}

// ---- Loading ----

// Makes the scene from its TSV and the model in `model_folder`.
static enum vw_status load_model(struct vw_scene_builder *builder, const struct vw_tsv *tsv, const char *model_folder,
                                 struct vw_colmap_model *model) {
    enum vw_status status = vw_colmap_read(model_folder, builder->folder, model);
    if (status) return status;
    uint32_t *views = vw_allocate(model->image_count, sizeof *views);
    if (!views) return VW_ERROR_MEMORY;
    status = vw_colmap_add_views(builder, model, "dense/images", views);
    if (!status) status = assign_splits(builder, model, views, tsv);
    if (!status) status = vw_colmap_take_points(model, views, builder->scene);
    if (!status) status = vw_bounds_choose(NULL, builder->scene);
    free(views);
    return status;
}

static enum vw_status load_dense(struct vw_scene_builder *builder, const struct vw_tsv *tsv) {
    char *dense = vw_path_join(builder->folder, "dense");
    if (!dense) return VW_ERROR_MEMORY;
    struct vw_colmap_model model = {0};
    char *model_folder = vw_colmap_find(dense);
    enum vw_status status =
        model_folder ? load_model(builder, tsv, model_folder, &model)
                     : vw_fail(VW_ERROR_INPUT, "%s/sparse: no COLMAP model; give cameras, images and points3D", dense);
    vw_colmap_clear(&model);
    free(model_folder);
    free(dense);
    return status;
}

enum vw_status vw_phototourism_load(struct vw_scene_builder *builder) {
    struct vw_tsv tsv = {0};
    enum vw_status status = vw_phototourism_read_tsv(builder->folder, &tsv);
    if (!status) status = load_dense(builder, &tsv);
    vw_tsv_clear(&tsv);
    return status;
}
