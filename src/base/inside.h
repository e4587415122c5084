// Files and folders below a folder that a stranger may have sent: what is read lies in it, whatever links it contains.
// The folder itself is the user's choice and may be reached through links. Nobody is expected to exchange files
// meanwhile.
#ifndef VIEWWORTH_BASE_INSIDE_H
#define VIEWWORTH_BASE_INSIDE_H

#include <stdbool.h>
#include <stddef.h>

#include "viewworth/status.h"

// Returns whether a path leaves the folder that it is relative to: it is absolute or has a part "..".
bool vw_path_leaves_folder(const char *name);

// Opens the plain file `name` of a folder for reading; the caller closes it. Links are followed as long as they stay in
// the folder. VW_ERROR_INPUT if the file is not there, is a folder, a pipe or a device, or lies elsewhere. An absolute
// name, or one with a part "..", lies elsewhere.
enum vw_status vw_file_open_inside(const char *folder, const char *name, int *descriptor);
// Reads such a file like vw_file_read().
enum vw_status vw_file_read_inside(const char *folder, const char *name, size_t limit_bytes, void **data,
                                   size_t *size_bytes);

// The functions below are for a folder of results, whose names viewworth gave: none is a link.

bool vw_file_exists_inside(const char *folder, const char *name); // a plain file
// Returns VW_OK for a plain file and for a name that is not taken; VW_ERROR_INPUT for links, folders, pipes and
// devices. It is for callers that open by path.
enum vw_status vw_file_check_inside(const char *folder, const char *name);
// Returns the same for a folder.
enum vw_status vw_folder_check_inside(const char *folder, const char *name);
// Creates a folder below a folder, and those between them; existing folders are fine, a link is not.
enum vw_status vw_folder_create_inside(const char *folder, const char *name);

#endif
