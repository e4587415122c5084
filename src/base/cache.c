#include "base/cache.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

static char *name_root(void) {
    const char *base = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (base && *base == '/') return vw_format_text("%s/viewworth", base);
    return home && *home == '/' ? vw_format_text("%s/.cache/viewworth", home) : NULL;
}

// Returns whether the folder can be read, this user owns it, and no one else may write to it. Warns once: a folder of
// somebody else is met for each file in it.
static bool is_ours(const char *folder) {
    static atomic_flag warned = ATOMIC_FLAG_INIT;
    struct stat info;
    if (access(folder, R_OK | X_OK) || stat(folder, &info) || !S_ISDIR(info.st_mode)) return false;
    if (info.st_uid == geteuid() && !(info.st_mode & (S_IWGRP | S_IWOTH))) return true;
    if (!atomic_flag_test_and_set(&warned))
        vw_log_warning("%s: is not used, because another user owns it or may write to it; remove it, or name another "
                       "folder by XDG_CACHE_HOME",
                       folder);
    return false;
}

char *vw_cache_folder(const char *name) {
    struct vw_saved_error kept = vw_error_save();
    char *root = name_root(), *parent = root ? vw_path_folder(root) : NULL,
         *path = root ? vw_path_join(root, name) : NULL;
    bool usable = parent && path && !vw_folder_create(parent);
    for (int i = 0; usable && i < 2; i++) {
        const char *folder = i ? path : root;
        mkdir(folder, 0700); // it may be there
        usable = is_ours(folder);
    }
    free(root);
    free(parent);
    vw_error_restore(&kept);
    if (usable) return path;
    free(path);
    return NULL;
}

// Names a file of the cache folder, owned by the caller; NULL if there is no folder to be used.
static char *name_file(const char *name) {
    char *folder = vw_cache_folder(""), *path = folder ? vw_path_join(folder, name) : NULL;
    free(folder);
    return path;
}

bool vw_cache_read(const char *name, size_t limit_bytes, void **data, size_t *size_bytes) {
    struct vw_saved_error kept = vw_error_save();
    char *path = name_file(name);
    bool read = path && !vw_file_read(path, limit_bytes, data, size_bytes);
    free(path);
    vw_error_restore(&kept);
    return read;
}

void vw_cache_write(const char *name, const void *data, size_t size_bytes) {
    struct vw_saved_error kept = vw_error_save();
    char *path = name_file(name);
    if (path) (void)vw_file_write(path, data, size_bytes);
    free(path);
    vw_error_restore(&kept);
}
