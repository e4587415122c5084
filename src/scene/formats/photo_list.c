#include "scene/formats/photo_list.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "scene/builder.h"
#include "scene/formats/colmap.h"
#include "scene/formats/transforms.h"

bool vw_photo_list_keeps(const struct vw_listed_photo *photo) {
    return photo->chosen || photo->split == VW_SPLIT_VAL || photo->split == VW_SPLIT_TEST;
}

enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo) {
    return vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that was valued: it lacks %s; restore it", list->scene_path,
                   photo->name);
}

enum vw_status vw_photo_list_check_new(const char *path) {
    struct stat info;
    if (lstat(path, &info) != 0) return VW_OK; // writing reports any other problem with the path
    return vw_fail(VW_ERROR_USAGE, "--to %s: exists; name a new file, or remove that one", path);
}

// ---- Folders ----

char *vw_photo_list_scene_folder(const struct vw_photo_list *list) {
    return vw_folder_exists(list->scene_path) ? vw_copy_text(list->scene_path) : vw_path_folder(list->scene_path);
}

// Returns the relative path between two folders, both without links; "/" counts as "".
static char *way_between(const char *from, const char *to) {
    size_t common = 0;
    for (size_t i = 0; from[i] == to[i] || ((!from[i] || from[i] == '/') && (!to[i] || to[i] == '/')); i++) {
        if ((!from[i] || from[i] == '/') && (!to[i] || to[i] == '/')) common = i;
        if (!from[i] || !to[i]) break;
    }
    size_t up_count = 0;
    for (const char *next = from + common; *next; next++) up_count += *next == '/';
    const char *down = to[common] ? to + common + 1 : "";
    char *way = vw_allocate(3 * up_count + strlen(down) + 2, 1);
    for (size_t i = 0; way && i < up_count; i++) strcat(way, "../");
    if (way && *down) strcat(strcat(way, down), "/");
    return way;
}

enum vw_status vw_photo_list_way(const struct vw_photo_list *list, const char *from, char **way) {
    char *folder = vw_photo_list_scene_folder(list), *made = NULL;
    char *real_from = realpath(from, NULL), *real_folder = folder ? realpath(folder, NULL) : NULL;
    enum vw_status status = VW_OK;
    if (!real_from || !real_folder)
        status =
            vw_fail(VW_ERROR_USAGE, "%s: %s; name a folder that exists", real_from ? folder : from, strerror(errno));
    if (!status) {
        made =
            way_between(strcmp(real_from, "/") == 0 ? "" : real_from, strcmp(real_folder, "/") == 0 ? "" : real_folder);
        if (!made) status = VW_ERROR_MEMORY;
    }
    if (!status && !vw_text_is_clean(made))
        status = vw_fail(VW_ERROR_USAGE, "--to: the path from there to %s (%s) is not UTF-8; write the list elsewhere",
                         folder, made);
    if (status) free(made);
    else *way = made;
    free(folder);
    free(real_from);
    free(real_folder);
    return status;
}

// Refuses, for any format, a folder with such a file, which would be read as a transforms scene.
enum vw_status vw_photo_list_check_place(const struct vw_photo_list *list) {
    const char *to = list->to, *slash = strrchr(to, '/');
    bool is_folder = vw_folder_exists(to);
    char *way = NULL;
    if (!is_folder && !vw_transforms_is_scene_file(slash ? slash + 1 : to)) return VW_OK;
    char *folder = is_folder ? vw_copy_text(to) : vw_path_folder(to);
    enum vw_status status = folder ? vw_photo_list_way(list, folder, &way) : VW_ERROR_MEMORY;
    if (!status && !*way)
        status = vw_fail(
            VW_ERROR_USAGE,
            "--to %s: with this file, the scene's folder would be read as another scene; choose another name", to);
    free(way);
    free(folder);
    return status;
}

// ---- A name a line ----

// Returns whether a reader that trims lines reads the name back.
static bool fits_a_line(const char *name) {
    size_t length = strlen(name);
    return length > 0 && vw_text_is_clean(name) && !isspace((unsigned char)name[0]) &&
           !isspace((unsigned char)name[length - 1]);
}

struct lines {
    const struct vw_photo_list *list;
    size_t prefix_bytes; // length of the names' prefix, which is left out
};

static void print_lines(FILE *stream, const void *context) {
    const struct lines *lines = context;
    for (uint32_t i = 0; i < lines->list->photo_count; i++)
        if (lines->list->photos[i].chosen) fprintf(stream, "%s\n", lines->list->photos[i].name + lines->prefix_bytes);
}

static enum vw_status write_lines(const struct vw_photo_list *list, size_t prefix_bytes) {
    for (uint32_t i = 0; i < list->photo_count; i++)
        if (list->photos[i].chosen && !fits_a_line(list->photos[i].name + prefix_bytes))
            return vw_fail(
                VW_ERROR_INPUT,
                "photo %u (%s): the name has a line end, or a space at its start or end, and cannot be in a list; "
                "rename it",
                i, list->photos[i].name);
    enum vw_status status = vw_photo_list_check_new(list->to);
    return status || list->check_only ? status
                                      : vw_csv_write_file(list->to, print_lines, &(struct lines){list, prefix_bytes});
}

enum vw_status vw_names_write_list(const struct vw_photo_list *list, bool *opens) {
    (void)opens;
    return write_lines(list, 0);
}

// Checks that the model has every valued photo; its names omit the folder of the photos.
static enum vw_status check_names(const struct vw_photo_list *list, const struct vw_colmap_model *model,
                                  const char *photo_folder) {
    size_t length = strlen(photo_folder);
    for (uint32_t i = 0; i < list->photo_count; i++) {
        const char *name = list->photos[i].name;
        bool inside = strncmp(name, photo_folder, length) == 0 && name[length] == '/';
        if (!inside || vw_colmap_find_image(model, name + length + 1) < 0)
            return vw_photo_list_refuse_missing(list, &list->photos[i]);
    }
    return VW_OK;
}

enum vw_status vw_colmap_write_list(const struct vw_photo_list *list, bool *opens) {
    (void)opens;
    struct vw_colmap_model model = {0};
    char *folder = vw_photo_list_scene_folder(list), *model_folder = folder ? vw_colmap_find(folder) : NULL;
    enum vw_status status = folder ? VW_OK : VW_ERROR_MEMORY;
    if (!status && !model_folder) status = vw_fail(VW_ERROR_INPUT, "%s: no COLMAP model; restore it", folder);
    if (!status) status = vw_colmap_read(model_folder, folder, &model);
    if (!status) {
        const char *photo_folder = vw_colmap_photo_folder(folder, model_folder);
        status = check_names(list, &model, photo_folder);
        if (!status) status = write_lines(list, strlen(photo_folder) + 1);
    }
    vw_colmap_clear(&model);
    free(model_folder);
    free(folder);
    return status;
}
