// Files and folders below a folder that a stranger may have sent: what is opened lies in it, whatever links it
// contains. The folder itself is the user's choice and may be reached through links. Between the check and the opening
// there is no gap: both are one call of the kernel, or one walk from descriptor to descriptor.
#ifndef VIEWWORTH_BASE_INSIDE_H
#define VIEWWORTH_BASE_INSIDE_H

#include <stdbool.h>
#include <stddef.h>

#include "viewworth/status.h"

// Returns whether a path leaves the folder that it is relative to: it is absolute or has a part "..".
bool vw_path_leaves_folder(const char *name);

// Opens the plain file `name` of a scene folder for reading; the caller closes it. Links are followed as long as they
// stay in the folder. VW_ERROR_INPUT if the file is not there, is a folder, a pipe or a device, or lies elsewhere. An
// absolute name, or one with a part "..", lies elsewhere.
enum vw_status vw_file_open_inside(const char *folder, const char *name, int *descriptor);

// The functions below are for a folder of results, whose names viewworth gave: no part of `name` may be a link.

// Reads a file like vw_file_read(), but returns VW_ERROR_INPUT also for a link.
enum vw_status vw_file_read_inside(const char *folder, const char *name, size_t limit_bytes, void **data,
                                   size_t *size_bytes);
bool vw_file_exists_inside(const char *folder, const char *name); // a plain file, reached without links
// Returns VW_OK for a plain file and for a name that is not taken; VW_ERROR_INPUT for links, folders, pipes and
// devices. It is for callers that open by path.
enum vw_status vw_file_check_inside(const char *folder, const char *name);
// Returns the same for a folder.
enum vw_status vw_folder_check_inside(const char *folder, const char *name);
// Creates a folder below a folder that exists, and those between them; existing folders are fine, links are not.
enum vw_status vw_folder_create_inside(const char *folder, const char *name);

// Makes tests open part by part, as on kernels without openat2.
void vw_inside_force_walk(bool walk);

#endif
