#include "scene/splits_file.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/duplicates.h"
#include "scene/formats/nerfw_tsv.h"

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

static void train_on_test_views(struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_TEST) scene->views[v].split = VW_SPLIT_TRAIN;
}

static enum vw_status assign_by_lists(const struct vw_scene_params *params, struct vw_scene *scene, uint8_t *claims) {
    bool none = params->test_list && strcmp(params->test_list, "none") == 0;
    const char *const lists[LIST_COUNT] = {params->train_list, params->val_list, none ? NULL : params->test_list};
    enum vw_status status = VW_OK;
    for (enum vw_split split = 0; !status && split < VW_SPLIT_EXCLUDED; split++)
        if (lists[split])
            status = vw_tsv_has_header(NULL, lists[split]) ? read_tsv(scene, lists[split], split, claims)
                                                           : read_list(scene, lists[split], split, claims);
    if (status) return status;
    if (!loader_has_opinion(scene)) split_by_stride(scene, lists);
    if (none) train_on_test_views(scene);
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

// ---- Reading -------------------------------------------------------------------------------------------------------

static const size_t LIMIT_BYTES = (size_t)1 << 26;

struct reading {
    struct vw_json_reader reader;
    struct vw_scene *scene;
    json_t *named; // owned; by name: its split
    uint8_t *claims;
    uint32_t claimed_count, absent_count; // names of photos that are in the scene, and that are not
};

// Notes the split of a name. A photo that the scene does not have is refused in two splits, too.
static void take_split_name(struct reading *reading, enum vw_split split, size_t place, const json_t *item) {
    char key[64];
    const char *name = json_string_value(item) ? vw_view_name_of(json_string_value(item)) : NULL;
    const json_t *before = name ? json_object_get(reading->named, name) : NULL;
    const struct vw_view *view = name ? vw_scene_find_view(reading->scene, name) : NULL;
    snprintf(key, sizeof key, "%s[%zu]", vw_split_name(split), place);
    if (!name) vw_json_refuse(&reading->reader, key, "expected a text, the name of a photo");
    if (before && json_integer_value(before) != (json_int_t)split)
        vw_json_refuse(&reading->reader, key, "%s is in two splits, %s and %s; keep it in one", name,
                       vw_split_name((enum vw_split)json_integer_value(before)), vw_split_name(split));
    if (!name || before) return;
    vw_json_set(&reading->named, name, json_integer(split));
    if (view) reading->claims[view - reading->scene->views] = (uint8_t)(1 + split);
    reading->claimed_count += view != NULL;
    reading->absent_count += view == NULL;
}

static void read_split(struct reading *reading, const json_t *root, enum vw_split split) {
    const json_t *names = json_object_get(root, vw_split_name(split));
    if (!names && split == VW_SPLIT_EXCLUDED) return;
    if (!json_is_array(names))
        vw_json_refuse(&reading->reader, vw_split_name(split), "%s; give a list of names, [] for none",
                       names ? "is not a list" : "is missing");
    for (size_t i = 0; i < json_array_size(names) && !reading->reader.status; i++)
        take_split_name(reading, split, i, json_array_get(names, i));
}

static void read_weights(struct reading *reading, json_t *weights) {
    const char *key;
    json_t *value;
    if (weights && !json_is_object(weights))
        vw_json_refuse(&reading->reader, "weights",
                       "is not an object of names and numbers; correct it or leave it out");
    json_object_foreach(weights, key, value) {
        const char *name = vw_view_name_of(key);
        const json_t *split = json_object_get(reading->named, name);
        const struct vw_view *view = vw_scene_find_view(reading->scene, name);
        if (!split || json_integer_value(split) != VW_SPLIT_VAL)
            vw_json_refuse(&reading->reader, "weights", "%s is not in val; remove it from the weights", name);
        else if (!json_is_number(value) || !vw_val_weight_is_valid(json_number_value(value)))
            vw_json_refuse(&reading->reader, "weights",
                           "that of %s is not a weight; write 0, or a number from 0.001 to 1000", name);
        else if (view) reading->scene->views[view - reading->scene->views].weight = json_number_value(value);
        if (reading->reader.status) return;
    }
}

static void read_all(struct reading *reading, const json_t *root) {
    vw_json_check_keys(&reading->reader, root, "train val test excluded weights");
    for (enum vw_split split = VW_SPLIT_TRAIN; split <= VW_SPLIT_EXCLUDED && !reading->reader.status; split++)
        read_split(reading, root, split);
    if (!reading->reader.status) read_weights(reading, json_object_get(root, "weights"));
    if (!reading->reader.status && !reading->named)
        reading->reader.status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory for its names", reading->reader.path);
    if (!reading->reader.status && !reading->claimed_count)
        vw_json_refuse(&reading->reader, "train",
                       "neither this nor another split names a photo of the scene; use the "
                       "splits.json of a run of this scene");
}

enum vw_status vw_splits_file_read(struct vw_scene *scene, const char *path, uint8_t *claims, uint32_t *absent_count) {
    json_t *root = NULL;
    struct reading reading = {.reader.path = path, .scene = scene, .named = json_object(), .claims = claims};
    reading.reader.status = vw_json_read_file(path, LIMIT_BYTES, &root);
    if (!reading.reader.status) read_all(&reading, root);
    if (!reading.reader.status) *absent_count = reading.absent_count;
    json_decref(reading.named);
    json_decref(root);
    return reading.reader.status;
}

// ---- Added photos --------------------------------------------------------------------------------------------------

// Lists views that were added, or those that validate or test and were not.
static uint32_t list_views(const struct vw_scene_builder *builder, bool added, uint32_t *views) {
    const struct vw_scene *scene = builder->scene;
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        bool judges = scene->views[v].split == VW_SPLIT_VAL || scene->views[v].split == VW_SPLIT_TEST;
        if (added ? builder->added[v] : judges && !builder->added[v]) views[count++] = v;
    }
    return count;
}

static enum vw_status note_added(const struct vw_scene_builder *builder, uint32_t added, uint32_t joined) {
    if (!joined)
        return vw_scene_note(builder->scene, "%u photos that %s does not name train", added, builder->params->splits);
    return vw_scene_note(builder->scene,
                         "%u photos that %s does not name train, and %u that are near-duplicates of validation or "
                         "test photos join them",
                         added - joined, builder->params->splits, joined);
}

enum vw_status vw_splits_join_duplicates(struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    uint32_t *views = vw_allocate(scene->view_count, sizeof *views);
    uint32_t *judges = vw_allocate(scene->view_count, sizeof *judges);
    uint32_t *matches = vw_allocate(scene->view_count, sizeof *matches);
    enum vw_status status = views && judges && matches ? VW_OK : VW_ERROR_MEMORY;
    uint32_t added = status ? 0 : list_views(builder, true, views), joined = 0;
    if (added)
        status = vw_scene_match_duplicates(scene, views, added, judges, list_views(builder, false, judges), matches);
    for (uint32_t i = 0; i < added && !status; i++) {
        if (matches[i] == UINT32_MAX) continue;
        scene->views[views[i]].split = scene->views[matches[i]].split;
        joined++;
    }
    if (added && !status) status = note_added(builder, added, joined);
    free(views);
    free(judges);
    free(matches);
    return status;
}

// ---- Writing -------------------------------------------------------------------------------------------------------

enum vw_status vw_splits_file_make(const struct vw_scene *scene, char **text) {
    json_t *root = json_object(), *lists[VW_SPLIT_EXCLUDED + 1];
    for (enum vw_split split = VW_SPLIT_TRAIN; split <= VW_SPLIT_EXCLUDED; split++) lists[split] = json_array();
    for (uint32_t v = 0; v < scene->view_count; v++)
        vw_json_append(&lists[scene->views[v].split], vw_json_string(scene->views[v].name));
    for (enum vw_split split = VW_SPLIT_TRAIN; split < VW_SPLIT_EXCLUDED; split++)
        vw_json_set(&root, vw_split_name(split), lists[split]);
    if (scene->split_count[VW_SPLIT_EXCLUDED])
        vw_json_set(&root, vw_split_name(VW_SPLIT_EXCLUDED), lists[VW_SPLIT_EXCLUDED]);
    else json_decref(lists[VW_SPLIT_EXCLUDED]);
    vw_scene_add_weights(scene, &root);
    *text = vw_json_to_text(root, JSON_INDENT(2));
    json_decref(root);
    return *text ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for the splits of the scene");
}

// ---- Weights of validation photos ----------------------------------------------------------------------------------

static enum vw_status take_weight(void *context, const struct vw_csv *csv, struct vw_view *view) {
    (void)context;
    const char *name = csv->fields[0], *text = csv->fields[1];
    char *end = NULL;
    double weight = isspace((unsigned char)*text) || strpbrk(text, "xX") ? NAN : strtod(text, &end);
    if (view->split != VW_SPLIT_VAL)
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: %s is in the split %s, and only validation photos have weights; remove "
                       "the row, or move the photo by --val or --splits",
                       csv->path, csv->line, name, vw_split_name(view->split));
    if (!vw_text_is_clean(name))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: the photo's name is not UTF-8; rename it to give it a weight", csv->path,
                       csv->line);
    if (!end || end == text || *end || !vw_val_weight_is_valid(weight))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: \"%s\" is not a weight; write 0, or a number from 0.001 to 1000",
                       csv->path, csv->line, text);
    view->weight = weight;
    return VW_OK;
}

// Brings equal weights to 1, since the scene is then the same as without them.
static void level(struct vw_scene *scene, double weight) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL && scene->views[v].weight != weight) return;
    for (uint32_t v = 0; v < scene->view_count; v++) scene->views[v].weight = 1;
}

enum vw_status vw_val_weights_settle(const struct vw_scene_builder *builder) {
    const char *path = builder->params->val_weights;
    struct vw_scene *scene = builder->scene;
    double most = 0;
    for (uint32_t v = 0; path && v < scene->view_count; v++) scene->views[v].weight = 1;
    enum vw_status status = path ? vw_scene_table_read(scene, path, "weight", take_weight, NULL) : VW_OK;
    if (status || !scene->split_count[VW_SPLIT_VAL]) return status;
    if (!path) path = builder->params->splits;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL && scene->views[v].weight > most) most = scene->views[v].weight;
    if (!(most > 0))
        return vw_fail(VW_ERROR_INPUT,
                       "%s: all validation photos of the scene have weight 0; give one a weight above 0", path);
    level(scene, most);
    return vw_scene_has_weights(scene) ? vw_scene_note(scene, "validation photos are weighted by %s", path) : VW_OK;
}

bool vw_scene_has_weights(const struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL && scene->views[v].weight != 1) return true;
    return false;
}

void vw_scene_add_weights(const struct vw_scene *scene, json_t **object) {
    if (!vw_scene_has_weights(scene)) return;
    json_t *weights = json_object();
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL && scene->views[v].weight != 1)
            vw_json_set(&weights, scene->views[v].name, json_real(scene->views[v].weight));
    vw_json_set(object, "weights", weights);
}
