#include "run/out_folder.h"

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
#include "base/inside.h"
#include "base/memory.h"
#include "viewworth/log.h"

const struct vw_out_file vw_out_files[] = {
    // Results of a run, in the order of SHA256SUMS.
    {VW_ADVICE_FILE, VW_OUT_BY_SCORES},
    {"duplicates.csv", VW_OUT_BY_SCORES},
    {VW_SPLATS_FILE, VW_OUT_BY_SCORES},
    {VW_FIELD_FILE, VW_OUT_BY_STEPS},
    {VW_LEDGER_FILE, VW_OUT_STAYS},
    {VW_SCENE_MAP_FILE, VW_OUT_BY_SCORES},
    {"matrix.csv", VW_OUT_BY_SCORES},
    {"payout.csv", VW_OUT_BY_SCORES},
    {"payout_photos.csv", VW_OUT_BY_SCORES},
    {"providers.csv", VW_OUT_BY_SCORES},
    {VW_RECONSTRUCTION_FILE, VW_OUT_BY_SCORES},
    {VW_REPORT_FILE, VW_OUT_BY_SCORES},
    {VW_RESIDUALS_FILE, VW_OUT_BY_SCORES},
    {"scores.csv", VW_OUT_BY_SCORES},
    {VW_SPLITS_FILE, VW_OUT_STAYS}, // --splits may name it, even to resume the same run
    // Not results: the list of them, a stopped backward pass, and places for the next photos by the field.
    {VW_CHECKSUMS_FILE, VW_OUT_BY_SCORES},
    {VW_LASTING_PASS_FILE, VW_OUT_BY_STEPS},
    {VW_NEXT_FILE, VW_OUT_BY_STEPS},
};
const size_t vw_out_file_count = VW_ARRAY_COUNT(vw_out_files);

bool vw_out_is_result(const char *name) {
    for (size_t i = 0; i < VW_RESULT_FILE_COUNT; i++)
        if (!strcmp(vw_out_files[i].name, name)) return true;
    return false;
}

enum vw_status vw_out_check(const char *out) {
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    char *place = vw_copy_text(out);
    while (place && !vw_folder_exists(place)) { // up to the nearest folder that is there; "." and "/" are
        char *parent = vw_path_folder(place);
        free(place);
        place = parent;
    }
    if (!place) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (access(place, W_OK | X_OK))
        status = vw_fail(VW_ERROR_USAGE, "--out %s: cannot write in %s: %s; name another folder", out, place,
                         strerror(errno));
    free(place);
    return status;
}

// Returns whether a path is one of the files of `out`, there or not.
static bool is_out_file(const char *path, const char *out) {
    const char *name = strrchr(path, '/');
    char *folder = vw_path_folder(path);
    bool is_one = false, inside = folder && vw_folder_is_same(folder, out);
    for (size_t i = 0; inside && i < vw_out_file_count; i++)
        is_one |= !strcmp(name ? name + 1 : path, vw_out_files[i].name);
    free(folder);
    return is_one;
}

enum vw_status vw_out_check_target(const char *option, const char *path, const char *out, bool json) {
    if (!path) return VW_OK;
    if (!vw_path_ends_with(path, ".ply") && !(json && vw_path_ends_with(path, ".json")))
        return vw_fail(VW_ERROR_USAGE, "--%s %s: the name must end in .ply%s", option, path, json ? " or .json" : "");
    if (vw_file_exists(path) || vw_folder_exists(path))
        return vw_fail(VW_ERROR_USAGE, "--%s %s: exists; name a new file, or remove that one", option, path);
    if (!is_out_file(path, out)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s %s: commands write their own file of that name there; name another", option,
                   path);
}

static enum vw_status remove_outdated(const char *out, enum vw_out_outdated by) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < vw_out_file_count; i++)
        if (vw_out_files[i].outdated == by) status = vw_file_remove(out, vw_out_files[i].name);
    return status;
}

enum vw_status vw_run_remove_outdated(const char *out, bool pays) {
    enum vw_status status = vw_run_remove_derived(out, pays);
    return status ? status : remove_outdated(out, VW_OUT_BY_STEPS);
}

enum vw_status vw_run_remove_derived(const char *out, bool pays) {
    bool paid = vw_file_exists_inside(out, "payout.csv");
    enum vw_status status = vw_file_remove(out, VW_CHECKSUMS_FILE); // first: it vouches for the others
    if (!status) status = remove_outdated(out, VW_OUT_BY_SCORES);
    if (!status && paid && !pays)
        vw_log_warning("%s/payout.csv is removed, since this command was not asked to pay; worth or value --resume "
                       "with --payout AMOUNT pays by the scores of now",
                       out);
    return status;
}

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
    if (entry->fts_level == FTS_ROOTLEVEL + 1 && entry->fts_info != FTS_D && entry->fts_info != FTS_DP &&
        !strcmp(entry->fts_name, VW_OUT_MASKS))
        return vw_fail(VW_ERROR_USAGE, "%s: is not a folder, but masks are written there; remove it", entry->fts_path);
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
