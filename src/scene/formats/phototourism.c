// PhotoTourism scenes as NeRF-W uses them: dense/images, a COLMAP model in dense/sparse, and a TSV that names the test
// photos.
#include <dirent.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/formats/colmap.h"
#include "scene/formats/formats.h"
#include "scene/formats/nerfw_tsv.h"

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
