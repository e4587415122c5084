#include "scene/val_weights.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 26;

// ---- The file ------------------------------------------------------------------------------------------------------

static enum vw_status read_header(const struct vw_csv *csv) {
    if (csv->field_count == 2 && !strcmp(csv->fields[0], "name") && !strcmp(csv->fields[1], "weight")) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s:%u: the header must be name,weight; add it", csv->path, csv->line);
}

static enum vw_status read_weight(const struct vw_csv *csv, struct vw_scene *scene, bool *named) {
    if (csv->field_count != 2)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: there must be two fields; write name,weight", csv->path, csv->line);
    const char *name = csv->fields[0], *text = csv->fields[1];
    struct vw_view *view = vw_scene_find_named(scene, name);
    char *end = NULL;
    double weight = isspace((unsigned char)*text) || strpbrk(text, "xX") ? NAN : strtod(text, &end);
    if (!view)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %s is not in the scene; write names as the scene file spells them",
                       csv->path, csv->line, name);
    if (view->split != VW_SPLIT_VAL)
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: %s is in the split %s, and only validation photos have weights; remove "
                       "the row, or move the photo by --val or --splits",
                       csv->path, csv->line, name, vw_split_name(view->split));
    if (!vw_text_is_clean(name))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: the photo's name is not UTF-8; rename it to give it a weight", csv->path,
                       csv->line);
    if (named[view - scene->views])
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %s has a weight already; keep one row of it", csv->path, csv->line,
                       name);
    if (!end || end == text || *end || !vw_val_weight_is_valid(weight))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: \"%s\" is not a weight; write 0, or a number from 0.001 to 1000",
                       csv->path, csv->line, text);
    named[view - scene->views] = true;
    view->weight = weight;
    return VW_OK;
}

static enum vw_status read_file(const char *path, struct vw_scene *scene) {
    struct vw_csv csv;
    bool found = false, *named = vw_allocate(scene->view_count, sizeof *named);
    if (!named) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) scene->views[v].weight = 1;
    enum vw_status status = vw_csv_open(path, FILE_LIMIT_BYTES, &csv);
    if (!status) status = vw_csv_next(&csv, &found);
    if (!status) status = read_header(&csv);
    while (!status && !(status = vw_csv_next(&csv, &found)) && found) status = read_weight(&csv, scene, named);
    vw_csv_close(&csv);
    free(named);
    return status;
}

// ---- All weights ---------------------------------------------------------------------------------------------------

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
    enum vw_status status = path ? read_file(path, scene) : VW_OK;
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
