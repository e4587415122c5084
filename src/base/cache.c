#include "base/cache.h"

#include <fcntl.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

// Warns once: a folder of somebody else is met for each file in it.
static bool is_ours(int descriptor, const char *path) {
    static atomic_flag warned = ATOMIC_FLAG_INIT;
    if (vw_descriptor_is_private(descriptor)) return true;
    if (!atomic_flag_test_and_set(&warned))
        vw_log_warning("%s: is not used, because another user owns it or may write to it; remove it, or name another "
                       "folder by XDG_CACHE_HOME",
                       path);
    return false;
}

static char *name_root(void) {
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (base && *base == '/') return vw_format_text("%s/viewworth", base);
    return home && *home == '/' ? vw_format_text("%s/.cache/viewworth", home) : NULL;
}

// Opens a folder that is ours, and makes it if it is missing; -1: there is none to be used.
static int open_folder(const char *path) {
    char *parent = vw_path_folder(path);
    if (parent && !vw_folder_exists(parent)) (void)vw_folder_create(parent);
    free(parent);
    mkdir(path, 0700); // it may be there; opening tells
    int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0 || is_ours(folder, path)) return folder;
    close(folder);
    return -1;
}

// Opens the cache folder and names a file in it; -1: there is none to be used.
static int open_root(const char *name, char **path) {
    struct vw_saved_error kept = vw_error_save();
    char *root = name_root();
    int folder = root ? open_folder(root) : -1;
    *path = folder >= 0 ? vw_path_join(root, name) : NULL;
    free(root);
    vw_error_restore(&kept);
    return folder;
}

char *vw_cache_folder(const char *name) {
    char *path = NULL;
    int root = open_root(name, &path), folder = path ? open_folder(path) : -1;
    if (root >= 0) close(root);
    if (folder >= 0) close(folder);
    if (folder >= 0) return path;
    free(path);
    return NULL;
}

bool vw_cache_read(const char *name, size_t limit_bytes, void **data, size_t *size_bytes) {
    struct vw_saved_error kept = vw_error_save();
    char *path = NULL;
    int folder = open_root(name, &path);
    int file = path ? openat(folder, name, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC) : -1;
    struct stat info;
    bool read = file >= 0 && !fstat(file, &info) && S_ISREG(info.st_mode) && is_ours(file, path) &&
                !vw_descriptor_read(file, path, limit_bytes, data, size_bytes);
    if (file >= 0) close(file);
    if (folder >= 0) close(folder);
    free(path);
    vw_error_restore(&kept);
    return read;
}

void vw_cache_write(const char *name, const void *data, size_t size_bytes) {
    struct vw_saved_error kept = vw_error_save();
    char *path = NULL;
    int folder = open_root(name, &path);
    if (path) (void)vw_file_write_private(path, data, size_bytes);
    if (folder >= 0) close(folder);
    free(path);
    vw_error_restore(&kept);
}
