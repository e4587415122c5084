#include "scene/builder.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

struct vw_view *vw_scene_builder_add_view(struct vw_scene_builder *builder, const char *name, const char *image_path,
                                          const struct vw_image_header *header) {
    struct vw_scene *scene = builder->scene;
    if (scene->view_count == VW_VIEWS_MOST) {
        vw_fail(VW_ERROR_INPUT, "%s: has more than %d photos; leave some out", scene->path ? scene->path : name,
                VW_VIEWS_MOST);
        return NULL;
    }
    size_t needed = (size_t)scene->view_count + 1;
    if (vw_grow((void **)&scene->views, &builder->view_capacity, needed, sizeof *scene->views)) return NULL;
    if (vw_grow((void **)&builder->photos, &builder->photo_capacity, needed, sizeof *builder->photos)) return NULL;
    struct vw_view *view = &scene->views[scene->view_count];
    struct vw_scene_builder_photo *photo = &builder->photos[scene->view_count];
    scene->view_count++; // from here on, closing the scene frees the view
    view->name = vw_copy_text(name);
    view->provider = vw_copy_text("");
    photo->image_path = vw_copy_text(image_path);
    photo->image_header = *header;
    return view->name && view->provider && photo->image_path ? view : NULL;
}

enum vw_status vw_scene_builder_set_mask(struct vw_scene_builder *builder, const char *mask_path) {
    struct vw_scene_builder_photo *photo = &builder->photos[builder->scene->view_count - 1];
    photo->mask_path = vw_copy_text(mask_path);
    return photo->mask_path ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_scene_note(struct vw_scene *scene, const char *format, ...) {
    char *note = NULL;
    va_list arguments;
    va_start(arguments, format);
    int length = vasprintf(&note, format, arguments);
    va_end(arguments);
    if (length < 0) return vw_fail(VW_ERROR_MEMORY, "out of memory for a note on the scene");
    char **notes = reallocarray(scene->notes, (size_t)scene->note_count + 1, sizeof *notes);
    if (!notes) {
        free(note);
        return vw_fail(VW_ERROR_MEMORY, "out of memory for a note on the scene");
    }
    vw_text_make_line(note);
    scene->notes = notes;
    scene->notes[scene->note_count++] = note;
    return VW_OK;
}

const char *vw_view_name_of(const char *name) {
    while (!strncmp(name, "./", 2)) name += 2;
    return name;
}

struct vw_view *vw_scene_find_view(const struct vw_scene *scene, const char *name) {
    name = vw_view_name_of(name);
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (!strcmp(scene->views[v].name, name)) return &scene->views[v];
    return NULL;
}

static bool ends_with_name(const char *path, const char *name) {
    size_t path_length = strlen(path), name_length = strlen(name);
    return path_length > name_length && path[path_length - name_length - 1] == '/' &&
           !strcmp(path + path_length - name_length, name);
}

// The view with that name in a COLMAP model, whose names omit the folder of the photos.
static struct vw_view *find_in_model(const struct vw_scene *scene, const char *name) {
    static const char *const photo_folders[] = {"images/", "dense/images/"};
    if (strcmp(scene->format, "colmap") != 0 && strcmp(scene->format, "phototourism") != 0) return NULL;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (size_t i = 0; i < VW_ARRAY_COUNT(photo_folders); i++) {
            size_t length = strlen(photo_folders[i]);
            const char *path = scene->views[v].name;
            if (!strncmp(path, photo_folders[i], length) && !strcmp(path + length, name)) return &scene->views[v];
        }
    return NULL;
}

struct vw_view *vw_scene_find_named(const struct vw_scene *scene, const char *name) {
    struct vw_view *found = vw_scene_find_view(scene, name);
    if (!found) found = find_in_model(scene, vw_view_name_of(name));
    if (found) return found;
    name = vw_view_name_of(name);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!ends_with_name(scene->views[v].name, name)) continue;
        if (found) return NULL;
        found = &scene->views[v];
    }
    return found;
}
