// Guards for the names and links in a scene: nothing is read outside the scene folder.
#ifndef VIEWWORTH_SAFE_PATH_H
#define VIEWWORTH_SAFE_PATH_H

#include <stdbool.h>

// Whether a path leaves the folder that it is relative to: it is absolute or has a part "..".
bool vw_path_leaves_folder(const char *name);
// Whether a file is in a folder, after following all links of both. False if either does not exist.
bool vw_path_lies_inside(const char *folder, const char *path);

#endif
