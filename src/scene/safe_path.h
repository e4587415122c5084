// Nothing is read outside the scene folder: what guards the names and links that a scene gives.
#ifndef VIEWWORTH_SAFE_PATH_H
#define VIEWWORTH_SAFE_PATH_H

#include <stdbool.h>

// Whether a relative path would leave the folder it is relative to: absolute, or with a part "..".
bool vw_path_leaves_folder(const char *name);
// Whether a file, all links followed, lies in a folder (links followed too). False when either does not exist.
bool vw_path_lies_inside(const char *folder, const char *path);

#endif
