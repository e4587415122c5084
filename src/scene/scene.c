#include "viewworth/scene.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

#include "scene/draft.h"
#include "scene/recipe.h"
#include "viewworth/file.h"
#include "viewworth/memory.h"

static bool probe_recipe(const char *path) {
    json_t *file = json_load_file(path, 0, NULL); // fails on folders and on anything but JSON
    bool recipe = json_object_get(file, "viewworth_recipe") != NULL;
    json_decref(file);
    return recipe;
}

static enum vw_status load_recipe(struct vw_draft *draft) { return vw_recipe_load(draft->params, draft->scene); }

static const struct vw_scene_format formats[] = { // in the order they are tried
    {"recipe", probe_recipe, load_recipe},
    {"transforms", vw_transforms_probe, vw_transforms_load},
};

static enum vw_status find_format(const struct vw_scene_params *params, const struct vw_scene_format **format) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(formats); i++) {
        if (params->format ? strcmp(params->format, formats[i].name) != 0 : !formats[i].probe(params->path)) continue;
        *format = &formats[i];
        return VW_OK;
    }
    if (params->format) return vw_fail(VW_ERROR_USAGE, "--format %s: unknown format; use transforms or recipe", params->format);
    if (!vw_folder_exists(params->path)) return vw_fail(VW_ERROR_INPUT, "%s: no such scene; check the path", params->path);
    return vw_fail(VW_ERROR_INPUT, "%s: no scene found; give a folder with transforms.json or transforms_train.json, or a recipe",
                   params->path);
}

// Everything that does not depend on the format.
static enum vw_status finish(struct vw_draft *draft) {
    const struct vw_scene_params *params = draft->params;
    struct vw_scene *scene = draft->scene;
    enum vw_status status = vw_splits_assign(params, scene);
    if (!status && params->providers) status = vw_providers_read(params->providers, scene);
    if (!status && draft->image_paths) status = vw_photos_read(draft);
    if (!status && !params->headers_only) vw_scene_hash(scene, params->downscale, scene->hash);
    return status;
}

enum vw_status vw_scene_open(const struct vw_scene_params *params, struct vw_scene **scene) {
    struct vw_draft draft = {.params = params, .scene = vw_allocate(1, sizeof *draft.scene)};
    if (!draft.scene) return VW_ERROR_MEMORY;
    const struct vw_scene_format *format = NULL;
    enum vw_status status = find_format(params, &format);
    if (!status) {
        draft.scene->path = vw_copy_text(params->path);
        draft.scene->format = vw_copy_text(format->name);
        status = draft.scene->path && draft.scene->format ? format->load(&draft) : VW_ERROR_MEMORY;
    }
    if (!status) status = finish(&draft);
    for (size_t i = 0; i < draft.path_capacity; i++) free(draft.image_paths[i]);
    free(draft.image_paths);
    if (status)
        vw_scene_close(&draft.scene);
    else
        *scene = draft.scene;
    return status;
}

void vw_scene_close(struct vw_scene **scene) {
    struct vw_scene *closing = scene ? *scene : NULL;
    if (!closing) return;
    for (uint32_t v = 0; v < closing->view_count; v++) {
        free(closing->views[v].name);
        free(closing->views[v].provider);
        free(closing->views[v].truth);
        vw_image_clear(&closing->views[v].image);
    }
    for (uint32_t i = 0; i < closing->note_count; i++) free(closing->notes[i]);
    free(closing->notes);
    free(closing->views);
    free(closing->points);
    free(closing->tracks);
    free(closing->path);
    free(closing->format);
    free(closing->box_source);
    free(closing);
    *scene = NULL;
}
