// The folder in which the program keeps, from run to run, what it can also find out again.
#ifndef VIEWWORTH_BASE_CACHE_FOLDER_H
#define VIEWWORTH_BASE_CACHE_FOLDER_H

// Returns the path of a file in $XDG_CACHE_HOME/viewworth (or ~/.cache/viewworth), owned by the caller; NULL when there
// is no such folder, or memory is short.
char *vw_cache_path(const char *name);

#endif
