#include "scene/formats/train_list.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/csv.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/nerfw_tsv.h"
#include "scene/formats/transforms.h"

struct reading {
    const struct vw_scene *scene;
    const char *path;
    bool *chosen;          // per view
    uint32_t *passed_over; // photos that are not train photos
    double least;          // the lowest score of a chosen photo
};

// Chooses a photo if it is a train photo.
static void add_photo(const struct reading *reading, const struct vw_view *view) {
    if (view->split == VW_SPLIT_TRAIN) reading->chosen[view - reading->scene->views] = true;
    else ++*reading->passed_over;
}

// ---- Names, one a line ----

static enum vw_status add_name(void *context, int line, const char *name) {
    const struct reading *reading = context;
    const struct vw_view *view = vw_scene_find_named(reading->scene, name);
    if (!view) return vw_scene_refuse_name(reading->path, (uint32_t)line, name);
    if (view->split != VW_SPLIT_TRAIN)
        return vw_fail(VW_ERROR_INPUT, "%s:%d: %s is not a train photo, its split is %s; remove the line",
                       reading->path, line, name, vw_split_name(view->split));
    add_photo(reading, view);
    return VW_OK;
}

static enum vw_status read_names(struct reading *reading) {
    uint32_t count;
    return vw_names_read(reading->path, add_name, reading, &count);
}

// ---- A NeRF-W TSV ----

static enum vw_status read_tsv(const struct reading *reading) {
    struct vw_tsv tsv = {0};
    enum vw_status status = vw_tsv_read(NULL, reading->path, &tsv);
    for (size_t i = 0; !status && i < tsv.row_count; i++) {
        if (tsv.rows[i].test || !tsv.rows[i].has_id) continue;
        const struct vw_view *view = vw_scene_find_named(reading->scene, tsv.rows[i].name);
        if (view) add_photo(reading, view);
        else ++*reading->passed_over;
    }
    vw_tsv_clear(&tsv);
    return status;
}

// ---- A transforms file ----

static const struct vw_view *find_framed(const struct vw_scene *scene, const char *file_path) {
    const struct vw_view *view = NULL;
    for (const char *name = file_path; name && !view; name = strchr(name, '/') ? strchr(name, '/') + 1 : NULL)
        view = vw_scene_find_named(scene, name);
    return view;
}

static enum vw_status add_frame(const struct reading *reading, size_t place, const json_t *frame) {
    const char *name = json_string_value(json_object_get(frame, "file_path"));
    if (!name)
        return vw_fail(VW_ERROR_INPUT, "%s: frame %zu: field file_path is missing or not a text", reading->path, place);
    const struct vw_view *view = find_framed(reading->scene, name);
    if (!view)
        return vw_fail(VW_ERROR_INPUT, "%s: frame %zu (%s) is not in the scene; give a file that was written for it",
                       reading->path, place, vw_text_is_clean(name) ? name : "its name has control characters");
    add_photo(reading, view);
    return VW_OK;
}

static enum vw_status read_transforms(const struct reading *reading) {
    json_t *file = NULL;
    enum vw_status status = vw_transforms_parse(NULL, reading->path, &file);
    if (status) return status;
    const json_t *frames = json_object_get(file, "frames");
    if (!json_is_array(frames))
        status = vw_fail(VW_ERROR_INPUT, "%s: field frames is missing; give a transforms file", reading->path);
    for (size_t i = 0; !status && i < json_array_size(frames); i++)
        status = add_frame(reading, i, json_array_get(frames, i));
    json_decref(file);
    return status;
}

// ---- Scores ----

static enum vw_status add_score(void *context, const struct vw_csv *csv, struct vw_view *view) {
    const struct reading *reading = context;
    char *end = NULL;
    double score = strtod(csv->fields[1], &end);
    if (end == csv->fields[1] || *end || !isfinite(score))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: field score: \"%s\" is not a number; correct it", csv->path, csv->line,
                       csv->fields[1]);
    if (score >= reading->least) add_photo(reading, view);
    else ++*reading->passed_over;
    return VW_OK;
}

enum vw_status vw_train_list_read(const struct vw_scene *scene, const char *path, const double *least, bool *chosen,
                                  uint32_t *passed_over) {
    struct reading reading = {scene, path, chosen, passed_over, least ? *least : 0};
    const char *extension = strrchr(path, '.');
    bool any = false;
    *passed_over = 0;
    enum vw_status status;
    if (least) status = vw_scene_table_read(scene, path, "score", add_score, &reading);
    else if (vw_tsv_has_header(NULL, path)) status = read_tsv(&reading);
    else if (extension && !strcasecmp(extension, ".json")) status = read_transforms(&reading);
    else status = read_names(&reading);
    for (uint32_t v = 0; v < scene->view_count; v++) any |= chosen[v];
    if (status || any) return status;
    if (least)
        return vw_fail(VW_ERROR_INPUT, "%s: no train photo has a score of %g or more; use a lower threshold", path,
                       *least);
    return vw_fail(VW_ERROR_INPUT, "%s: names no train photo; give another list", path);
}
