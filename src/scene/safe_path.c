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
    bool inside = real_folder && real_path && !strncmp(real_folder, real_path, length) && (root || real_path[length] == '/');
    free(real_folder);
    free(real_path);
    return inside;
}

// How many bytes the UTF-8 character at `text` has; 0 when it is none. Overlong forms, surrogates and what lies beyond U+10FFFF are none.
static int utf8_length(const unsigned char *text) {
    int length = text[0] < 0x80 ? 1 : text[0] >= 0xf0 && text[0] < 0xf5 ? 4 : text[0] >= 0xe0 ? 3 : text[0] >= 0xc2 ? 2 : 0;
    if (text[0] >= 0xf5) return 0;
    for (int i = 1; i < length; i++)
        if ((text[i] & 0xc0) != 0x80) return 0;
    bool overlong = (text[0] == 0xe0 && text[1] < 0xa0) || (text[0] == 0xf0 && text[1] < 0x90);
    bool surrogate = text[0] == 0xed && text[1] >= 0xa0;
    bool beyond = text[0] == 0xf4 && text[1] >= 0x90;
    return overlong || surrogate || beyond ? 0 : length;
}

bool vw_name_is_clean(const char *name) {
    for (const unsigned char *next = (const unsigned char *)name; *next;) {
        int length = utf8_length(next);
        if (!length || *next < 0x20 || *next == 0x7f) return false;
        next += length;
    }
    return true;
}
