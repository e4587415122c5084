#include "run/out_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <fts.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

enum { TRIES = 100 }; // tries to open a file that others may remove

struct vw_out_lock {
    char *out;           // owned
    int folder, file;    // descriptors; -1: none
    uint32_t new_levels; // OUT and its parents that were not there
};

// ---- The folder ----------------------------------------------------------------------------------------------------

static enum vw_status count_new_levels(struct vw_out_lock *lock) {
    char *path = vw_copy_text(lock->out);
    lock->new_levels = 0;
    while (path && !vw_folder_exists(path)) { // "." and "/" are there
        char *parent = vw_path_folder(path);
        free(path);
        path = parent;
        lock->new_levels++;
    }
    free(path);
    return path ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status create_folder(struct vw_out_lock *lock) {
    if (lock->folder >= 0) close(lock->folder);
    enum vw_status status = lock->new_levels ? VW_OK : count_new_levels(lock);
    if (!status) status = vw_folder_create(lock->out);
    if (status) return status;
    lock->folder = open(lock->out, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock->folder >= 0) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s: cannot open the folder: %s; check its permissions", lock->out, strerror(errno));
}

// Folders that hold something stay.
static void remove_new_levels(const struct vw_out_lock *lock) {
    char *path = lock->new_levels ? vw_copy_text(lock->out) : NULL;
    for (uint32_t i = 0; path && i < lock->new_levels; i++) {
        rmdir(path);
        char *parent = vw_path_folder(path);
        free(path);
        path = parent;
    }
    free(path);
}

// ---- The lock ------------------------------------------------------------------------------------------------------

static enum vw_status fail_locked(const struct vw_out_lock *lock) {
    char text[24] = "";
    ssize_t got = pread(lock->file, text, sizeof text - 1, 0);
    size_t digits = got > 0 ? strspn(text, "0123456789") : 0;
    bool known = digits && digits < 10 && text[digits] == '\n';
    return vw_fail(VW_ERROR_USAGE,
                   "%s: another viewworth process%s%.*s%s writes there; wait until it ends, or name another folder",
                   lock->out, known ? " (pid " : "", known ? (int)digits : 0, text, known ? ")" : "");
}

// Writes the process id for the message of another start.
static void write_pid(const struct vw_out_lock *lock) {
    char text[24];
    int length = snprintf(text, sizeof text, "%ld\n", (long)getpid());
    if (ftruncate(lock->file, 0) || pwrite(lock->file, text, (size_t)length, 0) < 0)
        vw_log_warning("%s/%s: %s", lock->out, VW_OUT_LOCK_FILE, strerror(errno));
}

// Opens the file, and creates the folder again where the process that held the lock has just removed it.
static enum vw_status open_file(struct vw_out_lock *lock) {
    const int flags = O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    enum vw_status status = VW_OK;
    for (int tries = 0; !status && tries < TRIES; tries++) {
        lock->file = openat(lock->folder, VW_OUT_LOCK_FILE, flags, 0600);
        if (lock->file >= 0 || errno != ENOENT) break;
        status = create_folder(lock);
    }
    if (status || lock->file >= 0) return status;
    return vw_fail(VW_ERROR_USAGE, "%s/%s: cannot open: %s; name another folder, or remove the file", lock->out,
                   VW_OUT_LOCK_FILE, strerror(errno));
}

// Returns whether the locked file still has the name: the process that held the lock before may just have removed it.
static bool is_current(const struct vw_out_lock *lock) {
    struct stat locked, named;
    return !fstat(lock->file, &locked) && !fstatat(lock->folder, VW_OUT_LOCK_FILE, &named, AT_SYMLINK_NOFOLLOW) &&
           named.st_dev == locked.st_dev && named.st_ino == locked.st_ino;
}

static enum vw_status acquire(struct vw_out_lock *lock) {
    for (int tries = 0; tries < TRIES; tries++) {
        enum vw_status status = open_file(lock);
        if (status) return status;
        bool locked = !flock(lock->file, LOCK_EX | LOCK_NB);
        if (!locked && errno == EWOULDBLOCK) return fail_locked(lock);
        if (!locked)
            vw_log_warning("%s: the file system has no locks (%s); start no other command on this folder", lock->out,
                           strerror(errno));
        if (is_current(lock)) {
            write_pid(lock);
            return VW_OK;
        }
        close(lock->file);
        lock->file = -1;
    }
    return vw_fail(VW_ERROR_USAGE, "%s: other processes keep locking and releasing it; name another folder", lock->out);
}

// Refuses links below OUT, which a stranger's OUT may have: what is written would land elsewhere.
static enum vw_status refuse_links(const struct vw_out_lock *lock) {
    char *const roots[] = {lock->out, NULL};
    FTS *tree = fts_open(roots, FTS_PHYSICAL | FTS_COMFOLLOW | FTS_NOCHDIR, NULL);
    enum vw_status status = VW_OK;
    for (FTSENT *entry; tree && !status && (entry = fts_read(tree));)
        if (entry->fts_level > FTS_ROOTLEVEL && (entry->fts_info == FTS_SL || entry->fts_info == FTS_SLNONE))
            status = vw_fail(VW_ERROR_USAGE, "%s: is reached through a link; put what it leads to here, or remove it",
                             entry->fts_path);
    if (tree) fts_close(tree);
    return status;
}

// ---- Taking and releasing ------------------------------------------------------------------------------------------

// Releases the lock; `mine`: the file is locked, and may be removed.
static void close_lock(struct vw_out_lock *lock, bool mine) {
    struct vw_saved_error why = vw_error_save();
    if (mine) unlinkat(lock->folder, VW_OUT_LOCK_FILE, 0);
    remove_new_levels(lock);
    if (lock->file >= 0) close(lock->file); // the lock ends here
    if (lock->folder >= 0) close(lock->folder);
    free(lock->out);
    free(lock);
    vw_error_restore(&why);
}

enum vw_status vw_out_lock_take(const char *out, struct vw_out_lock **lock) {
    struct vw_out_lock *taken = vw_allocate(1, sizeof *taken);
    if (!taken) return VW_ERROR_MEMORY;
    *taken = (struct vw_out_lock){.out = vw_copy_text(out), .folder = -1, .file = -1};
    enum vw_status status = taken->out ? create_folder(taken) : VW_ERROR_MEMORY;
    if (!status) status = refuse_links(taken);
    if (!status) status = acquire(taken);
    if (status) {
        close_lock(taken, false);
        return status;
    }
    vw_folder_remove_leftovers(out);
    *lock = taken;
    return VW_OK;
}

enum vw_status vw_out_lock_take_for(const char *to, const char *const *folders, uint32_t folder_count,
                                    struct vw_out_lock **lock) {
    enum vw_status status = VW_OK;
    char *folder = vw_path_folder(to);
    if (!folder) return VW_ERROR_MEMORY;
    *lock = NULL;
    for (uint32_t i = 0; !status && !*lock && i < folder_count; i++)
        if (vw_folder_is_same(folder, folders[i])) status = vw_out_lock_take(folders[i], lock);
    free(folder);
    return status;
}

const char *vw_out_lock_folder(const struct vw_out_lock *lock) { return lock->out; }

void vw_out_lock_release(struct vw_out_lock **lock) {
    if (!lock || !*lock) return;
    close_lock(*lock, true);
    *lock = NULL;
}
