#include "scene/builder.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "image/image.h"

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

enum vw_status vw_scene_builder_count_missing(struct vw_scene_builder *builder, const char *name) {
    builder->missing_count++;
    if (!builder->missing_name) builder->missing_name = vw_copy_text(name);
    return builder->missing_name ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_scene_builder_note_repairs(const struct vw_scene_builder *builder) {
    struct vw_scene *scene = builder->scene;
    enum vw_status status = VW_OK;
    if (builder->missing_count)
        status = vw_scene_note(scene, "%u photo%s skipped, without an image file (first: %s)", builder->missing_count,
                               vw_plural(builder->missing_count), builder->missing_name);
    if (!status && builder->missing_count) scene->missing = scene->notes[scene->note_count - 1];
    if (!status && builder->rescaled_count)
        status =
            vw_scene_note(scene, "%u photo%s: intrinsics scaled from the size in the scene file to that of the photo",
                          builder->rescaled_count, vw_plural(builder->rescaled_count));
    return status;
}

enum vw_status vw_scene_index_names(struct vw_scene *scene) {
    struct vw_name_index *index = vw_allocate(1, sizeof *index);
    if (!index) return VW_ERROR_MEMORY;
    scene->names = index;
    return vw_name_index_make(scene->views, sizeof *scene->views, offsetof(struct vw_view, name), scene->view_count,
                              index);
}

struct vw_view *vw_scene_find_view(const struct vw_scene *scene, const char *name) {
    size_t place = 0;
    return vw_name_index_find(scene->names, name, &place) ? &scene->views[place] : NULL;
}

// Finds the view with that name in a COLMAP model, whose names omit the folder of the photos.
static struct vw_view *find_in_model(const struct vw_scene *scene, const char *name) {
    static const char *const photo_folders[] = {"images/", "dense/images/"};
    struct vw_view *found = NULL;
    if (strcmp(scene->format, "colmap") != 0 && strcmp(scene->format, "phototourism") != 0) return NULL;
    for (size_t i = 0; i < VW_ARRAY_COUNT(photo_folders) && !found; i++) {
        char *path = vw_format_text("%s%s", photo_folders[i], name);
        if (path) found = vw_scene_find_view(scene, path);
        free(path);
    }
    return found;
}

struct vw_view *vw_scene_find_named(const struct vw_scene *scene, const char *name) {
    size_t place = 0;
    struct vw_view *found = vw_scene_find_view(scene, name);
    if (!found) found = find_in_model(scene, vw_view_name_of(name));
    if (!found && vw_name_index_find_ending(scene->names, name, &place)) found = &scene->views[place];
    return found;
}

// ---- Tables --------------------------------------------------------------------------------------------------------

static const size_t TABLE_LIMIT_BYTES = (size_t)1 << 26;

enum vw_status vw_scene_refuse_name(const char *path, uint32_t line, const char *name) {
    return vw_fail(VW_ERROR_INPUT, "%s:%u: %s is not in the scene; write names as the scene file spells them", path,
                   line, name);
}

static enum vw_status read_header(const struct vw_csv *csv, const char *column) {
    if (csv->field_count == 2 && !strcmp(csv->fields[0], "name") && !strcmp(csv->fields[1], column)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s:%u: the header must be name,%s; add it", csv->path, csv->line, column);
}

// Finds the view of a row and marks it in `named`, which has an entry per view.
static enum vw_status read_name(const struct vw_scene *scene, const struct vw_csv *csv, const char *column, bool *named,
                                struct vw_view **view) {
    if (csv->field_count != 2)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: there must be two fields; write name,%s", csv->path, csv->line, column);
    *view = vw_scene_find_named(scene, csv->fields[0]);
    if (!*view) return vw_scene_refuse_name(csv->path, csv->line, csv->fields[0]);
    bool *before = &named[*view - scene->views];
    if (*before)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: %s has a %s already; keep one row of it", csv->path, csv->line,
                       csv->fields[0], column);
    *before = true;
    return VW_OK;
}

enum vw_status vw_scene_table_read(const struct vw_scene *scene, const char *path, const char *column,
                                   vw_scene_row_taker *take, void *context) {
    struct vw_csv csv;
    struct vw_view *view = NULL;
    bool found = false, *named = vw_allocate(scene->view_count, sizeof *named);
    if (!named) return VW_ERROR_MEMORY;
    enum vw_status status = vw_csv_open(path, TABLE_LIMIT_BYTES, &csv);
    if (!status) status = vw_csv_next(&csv, &found);
    if (!status) status = read_header(&csv, column);
    while (!status && !(status = vw_csv_next(&csv, &found)) && found) {
        status = read_name(scene, &csv, column, named, &view);
        if (!status) status = take(context, &csv, view);
    }
    vw_csv_close(&csv);
    free(named);
    return status;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

enum vw_status vw_scene_file_open(const char *folder, const char *path, int *descriptor) {
    if (!folder) return vw_file_open(path, descriptor);
    size_t length = strlen(folder);
    if (strncmp(path, folder, length) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: is not in the scene folder %s; copy it there", path, folder);
    const char *name = path + length;
    return vw_file_open_inside(folder, name + strspn(name, "/"), descriptor);
}

enum vw_status vw_scene_file_read(const char *folder, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (status) return status;
    status = vw_descriptor_read(descriptor, path, limit_bytes, data, size_bytes);
    close(descriptor);
    return status;
}

bool vw_scene_has_file(const char *folder, const char *name) {
    char *path = vw_path_join(folder, name);
    bool found = path && vw_file_exists(path);
    free(path);
    return found;
}

enum vw_status vw_scene_file_check(const char *folder, const char *path) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (!status) close(descriptor);
    return status;
}

enum vw_status vw_scene_file_hash(const char *folder, const char *path, uint8_t sha256[VW_HASH_BYTES]) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(folder, path, &descriptor);
    if (status) return status;
    status = vw_sha256_descriptor(descriptor, path, sha256);
    close(descriptor);
    return status;
}

enum vw_status vw_scene_photo_probe(const struct vw_scene_builder *builder, const char *path,
                                    struct vw_image_header *header) {
    int descriptor = -1;
    enum vw_status status = vw_scene_file_open(builder->folder, path, &descriptor);
    return status ? status : vw_image_probe(path, descriptor, header);
}

// ---- Files beside photos -------------------------------------------------------------------------------------------

// Finds the last "/images/" in the part of the path below the folder; NULL: none.
static const char *find_images_folder(const char *folder, const char *image_path) {
    const char *found = NULL, *next = image_path + strlen(folder) - (*folder && folder[strlen(folder) - 1] == '/');
    while ((next = strstr(next, "/images/"))) found = next++;
    return found;
}

enum vw_status vw_scene_find_beside(const char *folder, const char *image_path, const char *place, const char *ending,
                                    bool same_name, char **path) {
    const char *images = find_images_folder(folder, image_path);
    if (!images) return VW_OK;
    const char *name = images + strlen("/images/"), *dot = strrchr(name, '.');
    int place_length = (int)(images - image_path), stem_length = (int)(dot ? dot - name : (long)strlen(name));
    char *const candidates[] = {
        vw_format_text("%.*s/%s/%s", place_length, image_path, place, name),
        vw_format_text("%.*s/%s/%s%s", place_length, image_path, place, name, ending),
        vw_format_text("%.*s/%s/%.*s%s", place_length, image_path, place, stem_length, name, ending),
    };
    enum vw_status status = VW_OK;
    for (size_t i = same_name ? 0 : 1; i < VW_ARRAY_COUNT(candidates); i++) {
        if (!candidates[i]) status = VW_ERROR_MEMORY;
        if (status || *path || !vw_file_exists(candidates[i])) continue;
        status = vw_scene_file_check(folder, candidates[i]);
        if (!status && !(*path = vw_copy_text(candidates[i]))) status = VW_ERROR_MEMORY;
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(candidates); i++) free(candidates[i]);
    return status;
}
