// Files that belong to photos, in a folder beside theirs: masks and features.
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/builder.h"

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
