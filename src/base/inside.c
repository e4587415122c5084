#include "base/inside.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"

bool vw_path_leaves_folder(const char *name) {
    if (*name == '/') return true;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (!strncmp(part, "..", 2) && (part[2] == '/' || !part[2])) return true;
    }
    return false;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static enum vw_status fail_link(const char *folder, const char *name) {
    return vw_fail(VW_ERROR_INPUT, "%s/%s: leads out of the folder through a link; put the file itself there", folder,
                   name);
}

// Finds the path of a file after all links, which the caller owns. VW_ERROR_INPUT unless it lies in the folder.
static enum vw_status resolve(const char *folder, const char *name, char **path) {
    if (vw_path_leaves_folder(name)) return fail_link(folder, name);
    char *joined = vw_path_join(folder, name), *real = joined ? realpath(joined, NULL) : NULL;
    int cause = errno;
    char *real_folder = real ? realpath(folder, NULL) : NULL;
    size_t length = real_folder ? strlen(real_folder) : 0;
    bool inside = length == 1 || (real_folder && !strncmp(real_folder, real, length) && real[length] == '/');
    enum vw_status status = VW_OK;
    if (!joined) status = VW_ERROR_MEMORY;
    else if (!real && cause == ENOENT) status = vw_fail(VW_ERROR_INPUT, "%s: no such file; check the path", joined);
    else if (!real_folder)
        status =
            vw_fail(VW_ERROR_INPUT, "%s: cannot open: %s; check the path and its permissions", joined, strerror(cause));
    else if (!inside) status = fail_link(folder, name);
    free(joined);
    free(real_folder);
    if (status) free(real);
    else *path = real;
    return status;
}

enum vw_status vw_file_open_inside(const char *folder, const char *name, int *descriptor) {
    char *path = NULL;
    enum vw_status status = resolve(folder, name, &path);
    if (!status) status = vw_file_open(path, descriptor);
    free(path);
    return status;
}

enum vw_status vw_file_read_inside(const char *folder, const char *name, size_t limit_bytes, void **data,
                                   size_t *size_bytes) {
    char *path = NULL;
    enum vw_status status = resolve(folder, name, &path);
    if (!status) status = vw_file_read(path, limit_bytes, data, size_bytes);
    free(path);
    return status;
}

// ---- Names that are opened by their path ---------------------------------------------------------------------------

// Returns the mode of what has the name, links included; 0 where nothing has it.
static mode_t mode_of(const char *folder, const char *name) {
    struct stat info;
    char *path = vw_path_join(folder, name);
    bool there = path && !lstat(path, &info);
    free(path);
    return there ? info.st_mode : 0;
}

bool vw_file_exists_inside(const char *folder, const char *name) { return S_ISREG(mode_of(folder, name)); }

static enum vw_status check(const char *folder, const char *name, mode_t kind) {
    mode_t mode = mode_of(folder, name);
    if (S_ISLNK(mode) || vw_path_leaves_folder(name))
        return vw_fail(VW_ERROR_INPUT, "%s/%s: is a link; put the file itself there, or remove the link", folder, name);
    if (!mode || (mode & S_IFMT) == kind) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s/%s: is another kind of file than viewworth puts there; remove it", folder, name);
}

enum vw_status vw_file_check_inside(const char *folder, const char *name) { return check(folder, name, S_IFREG); }

enum vw_status vw_folder_check_inside(const char *folder, const char *name) { return check(folder, name, S_IFDIR); }

enum vw_status vw_folder_create_inside(const char *folder, const char *name) {
    enum vw_status status = vw_folder_check_inside(folder, name);
    char *path = status ? NULL : vw_path_join(folder, name);
    if (!status) status = path ? vw_folder_create(path) : VW_ERROR_MEMORY;
    free(path);
    return status;
}
