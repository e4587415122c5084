#include "run/out_lock.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <fts.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

struct vw_out_lock {
    char *out;   // owned
    int file;    // descriptor; -1: none
    bool is_new; // OUT was not there
};

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

static enum vw_status acquire(struct vw_out_lock *lock) {
    char *path = vw_path_join(lock->out, VW_OUT_LOCK_FILE);
    if (!path) return VW_ERROR_MEMORY;
    lock->file = open(path, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
    enum vw_status status = VW_OK;
    if (lock->file < 0)
        status = vw_fail(VW_ERROR_USAGE, "%s: cannot open: %s; name another folder, or remove the file", path,
                         strerror(errno));
    free(path);
    if (status) return status;
    bool locked = !flock(lock->file, LOCK_EX | LOCK_NB);
    if (!locked && errno == EWOULDBLOCK) return fail_locked(lock);
    if (!locked)
        vw_log_warning("%s: the file system has no locks (%s); start no other command on this folder", lock->out,
                       strerror(errno));
    write_pid(lock);
    return VW_OK;
}

// Refuses what cannot be replaced by a result, before any work, and links below OUT, which a stranger's OUT may have:
// what is written would land elsewhere.
static enum vw_status check_entry(const FTSENT *entry) {
    if (entry->fts_level == FTS_ROOTLEVEL) return VW_OK;
    if (entry->fts_info == FTS_SL || entry->fts_info == FTS_SLNONE)
        return vw_fail(VW_ERROR_USAGE, "%s: is reached through a link; put what it leads to here, or remove it",
                       entry->fts_path);
    if (entry->fts_level == FTS_ROOTLEVEL + 1 && entry->fts_info != FTS_F && vw_out_is_result(entry->fts_name))
        return vw_fail(VW_ERROR_USAGE, "%s: is not a file, but a result is written there; remove it", entry->fts_path);
    return VW_OK;
}

static enum vw_status check_entries(const struct vw_out_lock *lock) {
    char *const roots[] = {lock->out, NULL};
    FTS *tree = fts_open(roots, FTS_PHYSICAL | FTS_COMFOLLOW | FTS_NOCHDIR, NULL);
    enum vw_status status = VW_OK;
    for (FTSENT *entry; tree && !status && (entry = fts_read(tree));) status = check_entry(entry);
    if (tree) fts_close(tree);
    return status;
}

// ---- Taking and releasing ------------------------------------------------------------------------------------------

// Returns whether the lock file is all that is in OUT.
static bool is_empty(const struct vw_out_lock *lock) {
    uint32_t names = 0;
    DIR *folder = opendir(lock->out);
    while (folder && readdir(folder)) names++;
    if (folder) closedir(folder);
    return names <= 3; // ".", ".." and the lock file
}

// Closes the lock file, which stays: another process may be about to lock it. An OUT without results goes with it.
static void close_lock(struct vw_out_lock *lock, bool mine) {
    struct vw_saved_error why = vw_error_save();
    if (mine && lock->is_new && is_empty(lock)) vw_folder_remove(lock->out);
    if (mine) (void)!ftruncate(lock->file, 0); // it names no process any more
    if (lock->file >= 0) close(lock->file);    // the lock ends here
    free(lock->out);
    free(lock);
    vw_error_restore(&why);
}

enum vw_status vw_out_lock_take(const char *out, struct vw_out_lock **lock) {
    struct vw_out_lock *taken = vw_allocate(1, sizeof *taken);
    if (!taken) return VW_ERROR_MEMORY;
    *taken = (struct vw_out_lock){.out = vw_copy_text(out), .file = -1, .is_new = !vw_folder_exists(out)};
    enum vw_status status = taken->out ? vw_folder_create(out) : VW_ERROR_MEMORY;
    if (!status) status = check_entries(taken);
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
