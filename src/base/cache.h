// The user's cache folder, $XDG_CACHE_HOME/viewworth or ~/.cache/viewworth, made for this user alone. One that somebody
// else owns or may write to is not used, which one warning says. No cache is worth an error: without the folder,
// nothing is kept.
#ifndef VIEWWORTH_BASE_CACHE_H
#define VIEWWORTH_BASE_CACHE_H

#include <stdbool.h>
#include <stddef.h>

// Makes a folder in the cache folder, unless it is there; "" is the cache folder. Returns its path, owned by the
// caller; NULL if there is none to be used.
char *vw_cache_folder(const char *name);
// Reads a file of the cache folder like vw_file_read(); false if it is not there or not to be used.
bool vw_cache_read(const char *name, size_t limit_bytes, void **data, size_t *size_bytes);
// Replaces a file of the cache folder, if that can be done.
void vw_cache_write(const char *name, const void *data, size_t size_bytes);

#endif
