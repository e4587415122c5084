#include "scene/safe_path.h"

#include <stdlib.h>
#include <string.h>

bool vw_path_leaves_folder(const char *name) {
    if (name[0] == '/') return true;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (!strncmp(part, "..", 2) && (part[2] == '/' || !part[2])) return true;
    }
    return false;
}

bool vw_path_lies_inside(const char *folder, const char *path) {
    char *real_folder = realpath(folder, NULL), *real_path = realpath(path, NULL);
    size_t length = real_folder ? strlen(real_folder) : 0;
    bool root = length == 1;
    bool inside =
        real_folder && real_path && !strncmp(real_folder, real_path, length) && (root || real_path[length] == '/');
    free(real_folder);
    free(real_path);
    return inside;
}
