#include "scene/formats/scene_copy.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/formats/ply.h"
#include "scene/photo_source.h"

static const size_t FILE_LIMIT_BYTES = (size_t)1 << 32;

// The origin of a kept view.
struct source {
    const struct vw_listed_photo *photo;
    const struct vw_scene_builder_photo *files;
};

struct copy {
    const struct vw_photo_list *list;
    const struct vw_scene *scene;
    const struct vw_interrupt *interrupt;
    char *folder;           // owned; where the files are written before they are all there
    size_t shared_bytes;    // length of what the paths of all photos begin with
    struct vw_scene kept;   // the part that is kept; its arrays are owned, but not what views point to
    struct source *sources; // owned; of each kept view
    char **masks;           // owned; of each kept view, relative to the copy; NULL: none
    uint32_t *places;       // owned; of each view of the scene in `kept`; UINT32_MAX: left out
};

// ---- What is kept --------------------------------------------------------------------------------------------------

// Skips the folder of the scene, slashes and "./".
static const char *path_in_scene(const struct vw_scene *scene, uint32_t view) {
    const char *path = scene->source->photos[view].image_path + strlen(scene->source->folder);
    return vw_view_name_of(path + strspn(path, "/"));
}

// Finds the folders that all photos share, up to images/ where that is one of them: what follows are names in a model.
static size_t find_shared(const struct vw_scene *scene) {
    const char *first = path_in_scene(scene, 0);
    size_t length = strlen(first);
    for (uint32_t v = 0; v < scene->view_count; v++)
        length = vw_text_shared_folder(first, length, path_in_scene(scene, v));
    for (const char *images = first; (images = strstr(images, "images/")) && images < first + length; images++)
        if (images == first || images[-1] == '/') return (size_t)(images - first) + strlen("images/");
    return length;
}

// Names a file that belongs to a photo, in the copy: by the photo and its own extension.
static char *name_attached(const char *place, const char *photo, const char *path) {
    const char *file = strrchr(path, '/'), *extension = file ? strrchr(file, '.') : NULL;
    return vw_format_text("%s/%s%s", place, photo, extension ? extension : "");
}

static enum vw_status keep_view(struct copy *copy, const struct vw_listed_photo *photo) {
    const struct vw_view *view = vw_scene_find_view(copy->scene, photo->name);
    if (!view) return vw_photo_list_refuse_missing(copy->list, photo);
    uint32_t index = (uint32_t)(view - copy->scene->views), place = copy->kept.view_count++;
    const struct vw_scene_builder_photo *files = &copy->scene->source->photos[index];
    struct vw_view *kept = &copy->kept.views[place];
    *kept = *view;
    kept->name = (char *)path_in_scene(copy->scene, index) + copy->shared_bytes;
    kept->split = photo->split;
    copy->places[index] = place;
    copy->sources[place] = (struct source){photo, files};
    if (!files->mask_path) return VW_OK;
    copy->masks[place] = name_attached("masks", kept->name, files->mask_path);
    return copy->masks[place] ? VW_OK : VW_ERROR_MEMORY;
}

static void keep_point(struct copy *copy, const struct vw_point *given) {
    struct vw_scene *kept = &copy->kept;
    struct vw_point point = *given;
    bool seen_by_two = false;
    point.first_track = kept->track_count;
    point.track_count = 0;
    for (uint32_t t = given->first_track; t < given->first_track + given->track_count; t++) {
        struct vw_track *track = &kept->tracks[point.first_track + point.track_count];
        *track = copy->scene->tracks[t];
        track->view = copy->places[track->view];
        if (track->view == UINT32_MAX) continue;
        seen_by_two |= track->view != kept->tracks[point.first_track].view;
        point.track_count++;
    }
    if (!seen_by_two) return;
    kept->track_count += point.track_count;
    kept->points[kept->point_count++] = point;
}

static enum vw_status keep(struct copy *copy) {
    const struct vw_scene *scene = copy->scene;
    struct vw_scene *kept = &copy->kept;
    uint32_t count = copy->list->photo_count;
    kept->views = vw_allocate(count, sizeof *kept->views);
    kept->points = vw_allocate(scene->point_count, sizeof *kept->points);
    kept->tracks = vw_allocate(scene->track_count, sizeof *kept->tracks);
    copy->sources = vw_allocate(count, sizeof *copy->sources);
    copy->masks = vw_allocate(count, sizeof *copy->masks);
    copy->places = vw_allocate(scene->view_count, sizeof *copy->places);
    if (!kept->views || !kept->points || !kept->tracks || !copy->sources || !copy->masks || !copy->places)
        return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) copy->places[v] = UINT32_MAX;
    copy->shared_bytes = find_shared(scene);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < count; i++)
        if (vw_photo_list_keeps(&copy->list->photos[i])) status = keep_view(copy, &copy->list->photos[i]);
    for (uint32_t p = 0; !status && p < scene->point_count; p++) keep_point(copy, &scene->points[p]);
    return status;
}

// ---- Files ---------------------------------------------------------------------------------------------------------

// Copies a file of a folder to a name in the copy that no other file has. `sha256` is what it must have, in hex; NULL:
// unknown.
static enum vw_status copy_file(const struct copy *copy, const char *inside, const char *path, const char *name,
                                const char *sha256) {
    char *to = vw_path_join(copy->folder, name), *folder = to ? vw_path_folder(to) : NULL, hex[VW_HASH_HEX_BYTES];
    void *data = NULL;
    size_t size_bytes = 0;
    int descriptor = -1;
    uint8_t hash[VW_HASH_BYTES];
    enum vw_status status = folder ? vw_folder_create(folder) : VW_ERROR_MEMORY;
    if (!status) status = vw_scene_file_open(inside, path, &descriptor);
    if (!status) status = vw_descriptor_read(descriptor, path, FILE_LIMIT_BYTES, &data, &size_bytes);
    if (!status && sha256) {
        vw_sha256(data, size_bytes, hash);
        vw_hash_to_hex(hash, hex);
        if (strcmp(hex, sha256) != 0)
            status = vw_fail(VW_ERROR_INPUT, "%s: not the file that was valued; restore it", path);
    }
    if (!status && vw_file_exists(to))
        status = vw_fail(VW_ERROR_INPUT, "%s: another file of the scene would be %s in the copy, too; rename one", path,
                         name);
    if (!status) status = vw_file_create(to, data, size_bytes);
    if (descriptor >= 0) close(descriptor);
    free(data);
    free(folder);
    free(to);
    return status;
}

static enum vw_status copy_photos(const struct copy *copy) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < copy->kept.view_count; i++) {
        if (vw_interrupt_requested(copy->interrupt))
            return vw_fail(VW_ERROR_INTERRUPTED, "interrupted; the same command copies again");
        const struct source *source = &copy->sources[i];
        const char *folder = copy->scene->source->folder, *mask_folder = source->files->mask_folder;
        const char *photo = copy->kept.views[i].name, *map = source->files->features_path;
        char *name = vw_format_text("images/%s", photo), *features = map ? name_attached("features", photo, map) : NULL;
        status =
            name ? copy_file(copy, folder, source->files->image_path, name, source->photo->sha256) : VW_ERROR_MEMORY;
        if (!status && copy->masks[i])
            status =
                copy_file(copy, mask_folder ? mask_folder : folder, source->files->mask_path, copy->masks[i], NULL);
        if (!status && map) status = features ? copy_file(copy, folder, map, features, NULL) : VW_ERROR_MEMORY;
        free(name);
        free(features);
    }
    return status;
}

static enum vw_status write_model(const struct copy *copy) {
    char *model = vw_path_join(copy->folder, "sparse/0"), *points = vw_path_join(copy->folder, "points.ply");
    enum vw_status status = model && points ? vw_folder_create(model) : VW_ERROR_MEMORY;
    if (!status) status = vw_colmap_write(&copy->kept, model);
    if (!status && copy->kept.point_count) status = vw_csv_write_file(points, vw_ply_print_points, &copy->kept);
    if (!status) status = vw_transforms_write(&copy->kept, copy->masks, copy->folder);
    free(model);
    free(points);
    return status;
}

// ---- The folder ----------------------------------------------------------------------------------------------------

static bool is_empty(const char *path) {
    DIR *folder = opendir(path);
    bool empty = folder != NULL;
    for (struct dirent *entry; empty && (entry = readdir(folder));)
        empty = !strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..");
    if (folder) closedir(folder);
    return empty;
}

enum vw_status vw_scene_copy_check(const char *folder, const struct vw_scene *scene) {
    struct stat info;
    if (!scene->source)
        return vw_fail(VW_ERROR_USAGE, "--copy %s: a recipe has no photo files; copy needs a scene of photos", folder);
    if (lstat(folder, &info) != 0) return VW_OK; // writing reports any other problem with the path
    if (S_ISDIR(info.st_mode) && is_empty(folder)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--copy %s: exists; name a new or an empty folder", folder);
}

static enum vw_status fail_folder(const struct copy *copy) {
    return vw_fail(VW_ERROR_IO, "--copy %s: cannot make the folder: %s; name one in a folder that you may write to",
                   copy->list->to, strerror(errno));
}

// Makes everything in `beside`, a new folder that only this user may open, and then moves it.
static enum vw_status write_beside(struct copy *copy, char *beside) {
    if (!mkdtemp(beside)) return fail_folder(copy);
    copy->folder = vw_path_join(beside, "copy");
    enum vw_status status = copy->folder ? vw_folder_create(copy->folder) : VW_ERROR_MEMORY;
    if (!status) status = copy_photos(copy);
    if (!status) status = write_model(copy);
    if (!status && rename(copy->folder, copy->list->to) != 0) status = fail_folder(copy);
    vw_folder_remove(beside);
    return status;
}

// Names a new folder beside `to`, for mkdtemp; owned by the caller.
static char *name_beside(const char *to) {
    size_t length = strlen(to);
    while (length > 1 && to[length - 1] == '/') length--;
    char *bare = vw_format_text("%.*s", (int)length, to), *parent = bare ? vw_path_folder(bare) : NULL,
         *beside = parent ? vw_path_join(parent, ".viewworth-XXXXXX") : NULL;
    free(bare);
    free(parent);
    return beside;
}

static void free_copy(struct copy *copy) {
    for (uint32_t i = 0; copy->masks && i < copy->kept.view_count; i++) free(copy->masks[i]);
    free(copy->kept.views);
    free(copy->kept.points);
    free(copy->kept.tracks);
    free(copy->sources);
    free(copy->masks);
    free(copy->places);
    free(copy->folder);
}

enum vw_status vw_scene_copy(const struct vw_photo_list *list, const struct vw_scene *scene,
                             const struct vw_interrupt *interrupt) {
    struct copy copy = {.list = list, .scene = scene, .interrupt = interrupt};
    enum vw_status status = vw_scene_copy_check(list->to, scene);
    char *beside = status ? NULL : name_beside(list->to);
    if (!status) status = beside ? keep(&copy) : VW_ERROR_MEMORY;
    if (!status) status = write_beside(&copy, beside);
    free_copy(&copy);
    free(beside);
    return status;
}
