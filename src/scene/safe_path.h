// Guards for the names and links in a scene: nothing is read outside the scene folder. What is checked is what is read,
// by one descriptor.
#ifndef VIEWWORTH_SCENE_SAFE_PATH_H
#define VIEWWORTH_SCENE_SAFE_PATH_H

#include <stddef.h>

#include "viewworth/status.h"

// Opens a plain file of a scene for reading; the caller closes it. `path` begins with `folder`, the scene folder, and a
// slash. VW_ERROR_INPUT if it is not there, is a folder, pipe or device, or lies outside of the folder, after following
// all links. With the folder NULL, the user named the file, which may be anywhere.
enum vw_status vw_scene_file_open(const char *folder, const char *path, int *descriptor);
// Reads the whole file, as vw_file_read() does.
enum vw_status vw_scene_file_read(const char *folder, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes);
// Checks that a file can be opened, so that an error is known before any work is done.
enum vw_status vw_scene_file_check(const char *folder, const char *path);

#endif
