// Decides the splits: which views are for training, validation and tests.
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/nerfw_tsv.h"
#include "scene/splits_file.h"

enum { LIST_COUNT = VW_SPLIT_EXCLUDED, TRAIN_VIEWS_MIN = 2, STRIDE = 8, TEST_PHASE = 4 };

enum vw_status vw_scene_list_views(const struct vw_scene *scene, enum vw_split split, uint32_t **views,
                                   uint32_t *count) {
    *views = vw_allocate(scene->view_count, sizeof **views);
    if (!*views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == split) (*views)[(*count)++] = v;
    return VW_OK;
}

// Records that a list names a view. `claims` has for each view 0, or 1 + the split of its list.
static enum vw_status claim(const struct vw_scene *scene, const char *path, int line, const char *name,
                            enum vw_split split, uint8_t *claims) {
    const struct vw_view *view = vw_scene_find_named(scene, name);
    if (!view) return vw_scene_refuse_name(path, (uint32_t)line, name);
    uint8_t *by = &claims[view - scene->views];
    if (*by && *by != 1 + split)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: %s is in two splits, %s and %s; keep it in one list", path, line, name,
                       vw_split_name(*by - 1u), vw_split_name(split));
    *by = (uint8_t)(1 + split);
    return VW_OK;
}

struct list {
    const struct vw_scene *scene;
    const char *path;
    enum vw_split split;
    uint8_t *claims;
};

static enum vw_status take_name(void *context, int line, const char *name) {
    const struct list *list = context;
    return claim(list->scene, list->path, line, name, list->split, list->claims);
}

static enum vw_status read_list(const struct vw_scene *scene, const char *path, enum vw_split split, uint8_t *claims) {
    struct list list = {scene, path, split, claims};
    uint32_t count;
    enum vw_status status = vw_names_read(path, take_name, &list, &count);
    if (!status && !count)
        status = vw_fail(VW_ERROR_INPUT, "%s: has no names; write one name per line, or leave --%s out", path,
                         vw_split_name(split));
    return status;
}

// Claims the train rows of a NeRF-W TSV, or its test rows (for validation and tests).
static enum vw_status read_tsv(const struct vw_scene *scene, const char *path, enum vw_split split, uint8_t *claims) {
    struct vw_tsv tsv = {0};
    bool tests = split != VW_SPLIT_TRAIN, empty = true;
    enum vw_status status = vw_tsv_read(NULL, path, &tsv);
    for (size_t i = 0; !status && i < tsv.row_count; i++) {
        if (tsv.rows[i].test != tests) continue;
        status = claim(scene, path, tsv.rows[i].line, tsv.rows[i].name, split, claims);
        empty = false;
    }
    vw_tsv_clear(&tsv);
    if (!status && empty)
        status = vw_fail(VW_ERROR_INPUT, "%s: has no row for --%s; use another TSV, or leave --%s out", path,
                         vw_split_name(split), vw_split_name(split));
    return status;
}

static bool loader_has_opinion(const struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL || scene->views[v].split == VW_SPLIT_TEST) return true;
    return false;
}

// Takes every eighth view for validation and every eighth for tests, unless too few would be left to train. Excluded
// views are not counted.
static void split_by_stride(struct vw_scene *scene, const char *const lists[LIST_COUNT]) {
    uint32_t train = 0, i = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) train += scene->views[v].split == VW_SPLIT_TRAIN;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split == VW_SPLIT_EXCLUDED) continue;
        enum vw_split split = i % STRIDE == 0            ? VW_SPLIT_VAL
                              : i % STRIDE == TEST_PHASE ? VW_SPLIT_TEST
                                                         : VW_SPLIT_TRAIN;
        i++;
        if (split == VW_SPLIT_TRAIN || lists[split] || train <= TRAIN_VIEWS_MIN) continue;
        scene->views[v].split = split;
        train--;
    }
}

// Replaces a split by its list: views of the split that no list names are excluded.
static void apply_claims(struct vw_scene *scene, const char *const lists[LIST_COUNT], const uint8_t *claims) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        if (claims[v]) view->split = claims[v] - 1u;
        else if (view->split < VW_SPLIT_EXCLUDED && lists[view->split]) view->split = VW_SPLIT_EXCLUDED;
    }
}

static enum vw_status check_counts(const char *path, const struct vw_scene *scene) {
    uint32_t train = scene->split_count[VW_SPLIT_TRAIN];
    if (train >= TRAIN_VIEWS_MIN) return VW_OK;
    if (scene->view_count < TRAIN_VIEWS_MIN)
        return vw_fail(VW_ERROR_INPUT, "%s: a single photo cannot be valued; give a scene with at least %d", path,
                       TRAIN_VIEWS_MIN);
    return vw_fail(VW_ERROR_INPUT, "%s: %s left to train, at least %d are needed; check the lists and splits", path,
                   train ? "only one view is" : "no view is", TRAIN_VIEWS_MIN);
}

enum vw_status vw_splits_count(const char *path, struct vw_scene *scene) {
    memset(scene->split_count, 0, sizeof scene->split_count);
    for (uint32_t v = 0; v < scene->view_count; v++) scene->split_count[scene->views[v].split]++;
    return check_counts(path, scene);
}

static enum vw_status assign_by_lists(const struct vw_scene_params *params, struct vw_scene *scene, uint8_t *claims) {
    const char *const lists[LIST_COUNT] = {params->train_list, params->val_list, params->test_list};
    enum vw_status status = VW_OK;
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++)
        if (lists[split])
            status = vw_tsv_has_header(NULL, lists[split]) ? read_tsv(scene, lists[split], split, claims)
                                                           : read_list(scene, lists[split], split, claims);
    if (status) return status;
    if (!loader_has_opinion(scene)) split_by_stride(scene, lists);
    apply_claims(scene, lists, claims);
    return VW_OK;
}

// Obeys the splits of an earlier run. Photos that came later train, unless the scene excludes them.
static enum vw_status assign_by_file(struct vw_scene_builder *builder, uint8_t *claims) {
    const struct vw_scene_params *params = builder->params;
    struct vw_scene *scene = builder->scene;
    uint32_t absent = 0;
    if (params->train_list || params->val_list || params->test_list)
        return vw_fail(VW_ERROR_USAGE, "--splits names the photos of all splits; leave out --train, --val and --test");
    builder->added = vw_allocate(scene->view_count, sizeof *builder->added);
    enum vw_status status =
        builder->added ? vw_splits_file_read(scene, params->splits, claims, &absent) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        builder->added[v] = !claims[v] && view->split != VW_SPLIT_EXCLUDED;
        if (claims[v]) view->split = claims[v] - 1u;
        else if (builder->added[v]) view->split = VW_SPLIT_TRAIN;
    }
    return status || !absent ? status
                             : vw_scene_note(scene, "skipped %u photo%s that %s names: not in the scene", absent,
                                             vw_plural(absent), params->splits);
}

enum vw_status vw_splits_assign(struct vw_scene_builder *builder) {
    const struct vw_scene_params *params = builder->params;
    uint8_t *claims = vw_allocate(builder->scene->view_count, sizeof *claims);
    if (!claims) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < builder->scene->view_count; v++) builder->scene->views[v].weight = 1;
    enum vw_status status =
        params->splits ? assign_by_file(builder, claims) : assign_by_lists(params, builder->scene, claims);
    free(claims);
    return status ? status : vw_splits_count(params->path, builder->scene);
}
