// Files: whole reads, atomic writes, names; the standard streams.
#ifndef VIEWWORTH_BASE_FILE_H
#define VIEWWORTH_BASE_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

// Opens a plain file for reading; the caller closes it. VW_ERROR_INPUT if it is not there or is a folder, a pipe or a
// device, which are not opened.
enum vw_status vw_file_open(const char *path, int *descriptor);
// Reads a whole plain file of at most `limit_bytes`; `*data` is owned by the caller (free) and has a zero byte after
// its end.
enum vw_status vw_file_read(const char *path, size_t limit_bytes, void **data, size_t *size_bytes);
// Reads an opened file, which stays open. `path` is for messages.
enum vw_status vw_descriptor_read(int descriptor, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes);
// Replaces `path`, or a link of that name, by a new file, which is on the disk with its name when the call returns. At
// every moment the old or the new file is there, whole. VW_ERROR_IO leaves what was there.
enum vw_status vw_file_write(const char *path, const void *data, size_t size_bytes);
// Writes a new file; VW_ERROR_USAGE if `path` exists.
enum vw_status vw_file_create(const char *path, const void *data, size_t size_bytes);
// Opens a new file without a name in a folder, to be written and read; the caller closes it, which also removes it.
// Where the file system has no such files it has a name for a moment. -1 with errno.
int vw_file_open_unnamed(const char *folder);
// Removes a file, or a link of that name; a name that nothing has is fine. VW_ERROR_IO.
enum vw_status vw_file_remove(const char *folder, const char *name);
// Removes temporary files of the functions above that a killed program has left in a folder. Only while no other
// program writes there.
void vw_folder_remove_leftovers(const char *path);
bool vw_file_exists(const char *path); // a plain file: not a folder, and not a device or pipe, which might never end
bool vw_folder_exists(const char *path);
bool vw_folder_is_same(const char *left, const char *right); // two names of one folder, or of one file
// Creates a folder and its parents; an existing folder is fine.
enum vw_status vw_folder_create(const char *path);
// Removes a folder with all that is in it; links are removed, not followed. What cannot be removed stays.
void vw_folder_remove(const char *path);
// Returns "folder/name", owned by the caller; NULL if memory is short. An absolute `name` is returned unchanged.
char *vw_path_join(const char *folder, const char *name);
// Returns whether a path ends in ".png", say, in upper or lower case, after some name.
bool vw_path_ends_with(const char *path, const char *ending);
// Returns the folder part of a path ("." if it has none), owned by the caller.
char *vw_path_folder(const char *path);

// Prepares the streams and signals that a program inherits; it calls this before anything else. A standard stream that
// is closed becomes one that cannot be written, so that no file gets its number and then the messages meant for it. A
// write that cannot be done, into a pipe without a reader or beyond the limit of file sizes, fails instead of killing
// the program. False if a stream cannot be opened.
bool vw_streams_prepare(void);

#endif
