#include "scene/formats/photo_list.h"

#include <ctype.h>
#include <string.h>
#include <sys/stat.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/text.h"
#include "scene/builder.h"

bool vw_photo_list_keeps(const struct vw_listed_photo *photo) {
    return photo->chosen || photo->split == VW_SPLIT_VAL || photo->split == VW_SPLIT_TEST;
}

enum vw_status vw_photo_list_refuse_missing(const struct vw_photo_list *list, const struct vw_listed_photo *photo) {
    return vw_fail(VW_ERROR_INPUT, "%s: no longer the scene that was valued: it lacks %s; restore it", list->scene_path,
                   photo->name);
}

enum vw_status vw_photo_list_check_new(const struct vw_photo_list *list) {
    struct stat info;
    if (lstat(list->to, &info) != 0) return VW_OK; // writing reports any other problem with the path
    return vw_fail(VW_ERROR_USAGE, "--to %s: exists; name a new file, or remove that one", list->to);
}

// ---- A name a line --------------------------------------------------------------------------------------------------

// Returns whether a reader that trims lines reads the name back.
static bool fits_a_line(const char *name) {
    size_t length = strlen(name);
    return length > 0 && vw_text_is_clean(name) && !isspace((unsigned char)name[0]) &&
           !isspace((unsigned char)name[length - 1]);
}

static void print_names(FILE *stream, const void *context) {
    const struct vw_photo_list *list = context;
    for (uint32_t i = 0; i < list->photo_count; i++)
        if (list->photos[i].chosen) fprintf(stream, "%s\n", list->photos[i].name);
}

static enum vw_status write_names(const struct vw_photo_list *list) {
    for (uint32_t i = 0; i < list->photo_count; i++)
        if (list->photos[i].chosen && !fits_a_line(list->photos[i].name))
            return vw_fail(
                VW_ERROR_INPUT,
                "photo %u (%s): the name has a line end, or a space at its start or end, and cannot be in a list; "
                "rename it",
                i, list->photos[i].name);
    enum vw_status status = vw_photo_list_check_new(list);
    return status || list->check_only ? status : vw_csv_write_file(list->to, print_names, list);
}

// ---- All lists ------------------------------------------------------------------------------------------------------

const char *vw_photo_list_format(const char *to) { return vw_path_ends_with(to, ".tsv") ? "phototourism" : "text"; }

enum vw_status vw_photo_list_write(const struct vw_photo_list *list) {
    if (vw_path_ends_with(list->to, ".txt")) return write_names(list);
    if (!vw_path_ends_with(list->to, ".tsv"))
        return vw_fail(VW_ERROR_USAGE,
                       "--to %s: takes a file of names (.txt) or, of a PhotoTourism scene, a NeRF-W TSV (.tsv); for "
                       "other trainers --copy DIR makes a scene",
                       list->to);
    if (!list->scene_path || !vw_phototourism_probe(list->scene_path))
        return vw_fail(VW_ERROR_USAGE, "--to %s: only a PhotoTourism scene has a TSV; name a .txt file", list->to);
    return vw_phototourism_write_list(list);
}
