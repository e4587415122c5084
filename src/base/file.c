#include "base/file.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

// ---- Reading -------------------------------------------------------------------------------------------------------

// Checks the kind before opening, since opening a pipe may wait for ever and opening a device may have effects.
enum vw_status vw_file_open(const char *path, int *descriptor) {
    struct stat info;
    bool found = !stat(path, &info);
    if (found && !S_ISREG(info.st_mode))
        return vw_fail(VW_ERROR_INPUT, "%s: is a folder, a pipe or a device; give the path of a plain file", path);
    int opened = found ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    if (opened < 0)
        return vw_fail(VW_ERROR_INPUT, "%s: cannot open: %s; check the path and its permissions", path,
                       strerror(errno));
    *descriptor = opened;
    return VW_OK;
}

static enum vw_status fail_size(const char *path, size_t limit_bytes) {
    return vw_fail(VW_ERROR_INPUT, "%s: larger than the %zu bytes allowed here; check the path", path, limit_bytes);
}

enum vw_status vw_descriptor_read(int descriptor, const char *path, size_t limit_bytes, void **data,
                                  size_t *size_bytes) {
    struct stat info;
    char *text = NULL;
    size_t capacity = 0, used = 0;
    if (fstat(descriptor, &info)) info.st_size = 0; // a guess is enough, since the file may grow meanwhile
    if ((uint64_t)info.st_size > limit_bytes) return fail_size(path, limit_bytes);
    enum vw_status status = vw_grow((void **)&text, &capacity, (size_t)info.st_size + 2, 1);
    for (bool ended = false; !status && !ended;) {
        ssize_t got = read(descriptor, text + used, capacity - used - 1);
        ended = got == 0;
        if (got > 0) used += (size_t)got;
        if (got < 0 && errno != EINTR)
            status = vw_fail(VW_ERROR_IO, "%s: cannot read: %s; check the disk", path, strerror(errno));
        else if (used > limit_bytes) status = fail_size(path, limit_bytes);
        else status = vw_grow((void **)&text, &capacity, used + 2, 1);
    }
    if (status) {
        free(text);
        return status;
    }
    text[used] = 0;
    *data = text;
    *size_bytes = used;
    return VW_OK;
}

enum vw_status vw_file_read(const char *path, size_t limit_bytes, void **data, size_t *size_bytes) {
    int descriptor = -1;
    enum vw_status status = vw_file_open(path, &descriptor);
    if (status) return status;
    status = vw_descriptor_read(descriptor, path, limit_bytes, data, size_bytes);
    close(descriptor);
    return status;
}

// ---- Writing -------------------------------------------------------------------------------------------------------

// Unpredictable, so that no one can plant a link where a file is about to be written; the pattern tells what a killed
// program has left behind.
#define TEMPORARY_PREFIX ".viewworth-"
#define TEMPORARY_SUFFIX ".part"
enum {
    RANDOM_DIGITS = 32,
    TEMPORARY_NAME_BYTES = sizeof TEMPORARY_PREFIX - 1 + RANDOM_DIGITS + sizeof TEMPORARY_SUFFIX
};

// Returns the cause of a failure, or 0.
static int make_temporary_name(char name[TEMPORARY_NAME_BYTES]) {
    uint64_t random[2];
    if (getentropy(random, sizeof random)) return errno;
    snprintf(name, TEMPORARY_NAME_BYTES, TEMPORARY_PREFIX "%016" PRIx64 "%016" PRIx64 TEMPORARY_SUFFIX, random[0],
             random[1]);
    return 0;
}

static bool is_temporary_name(const char *name) {
    size_t prefix = strlen(TEMPORARY_PREFIX);
    return !strncmp(name, TEMPORARY_PREFIX, prefix) && strspn(name + prefix, "0123456789abcdef") == RANDOM_DIGITS &&
           !strcmp(name + prefix + RANDOM_DIGITS, TEMPORARY_SUFFIX);
}

// Writes all bytes; returns the cause of a failure, or 0.
static int write_all(int descriptor, const void *data, size_t size_bytes) {
    const char *next = data;
    while (size_bytes) {
        ssize_t written = write(descriptor, next, size_bytes);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return errno;
        next += written;
        size_bytes -= (size_t)written;
    }
    return 0;
}

// Returns the cause of a failure, or 0. After a failure no file remains.
static int write_temporary(int folder, const char *name, const void *data, size_t size_bytes) {
    int descriptor = openat(folder, name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor < 0) return errno;
    int cause = write_all(descriptor, data, size_bytes);
    if (!cause && fsync(descriptor)) cause = errno;
    if (close(descriptor) && !cause) cause = errno;
    if (cause) unlinkat(folder, name, 0);
    return cause;
}

// Gives the temporary file its name. Where the file system cannot rename without replacing, it can link.
static int publish(int folder, const char *temporary, const char *name, bool replaces) {
    int failed = replaces ? renameat(folder, temporary, folder, name)
                          : renameat2(folder, temporary, folder, name, RENAME_NOREPLACE);
    int cause = failed ? errno : 0;
    if (!replaces && (cause == EINVAL || cause == ENOSYS)) {
        cause = linkat(folder, temporary, folder, name, 0) ? errno : 0;
        if (!cause) unlinkat(folder, temporary, 0);
    }
    if (cause) unlinkat(folder, temporary, 0);
    return cause;
}

// Returns the cause of a failure, or 0.
static int write_in_folder(const char *folder_path, const char *name, const void *data, size_t size_bytes,
                           bool replaces) {
    char temporary[TEMPORARY_NAME_BYTES];
    int folder = open(folder_path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder < 0) return errno;
    int cause = make_temporary_name(temporary);
    if (!cause) cause = write_temporary(folder, temporary, data, size_bytes);
    if (!cause) cause = publish(folder, temporary, name, replaces);
    // Makes the new name survive a power cut. Some file systems cannot sync a folder; the file is there all the same.
    if (!cause) fsync(folder);
    close(folder);
    return cause;
}

static enum vw_status write_file(const char *path, const void *data, size_t size_bytes, bool replaces) {
    char *folder = vw_path_folder(path);
    if (!folder) return VW_ERROR_MEMORY;
    const char *slash = strrchr(path, '/');
    int cause = write_in_folder(folder, slash ? slash + 1 : path, data, size_bytes, replaces);
    free(folder);
    if (!cause) return VW_OK;
    if (cause == EEXIST && !replaces)
        return vw_fail(VW_ERROR_USAGE, "%s: is there already; remove it or choose another path", path);
    return vw_fail(VW_ERROR_IO, "%s: cannot write: %s; check the folder, its permissions and the free space", path,
                   strerror(cause));
}

enum vw_status vw_file_write(const char *path, const void *data, size_t size_bytes) {
    return write_file(path, data, size_bytes, true);
}

enum vw_status vw_file_create(const char *path, const void *data, size_t size_bytes) {
    return write_file(path, data, size_bytes, false);
}

enum vw_status vw_file_remove(const char *folder, const char *name) {
    char *path = vw_path_join(folder, name);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (unlink(path) && errno != ENOENT)
        status =
            vw_fail(VW_ERROR_IO, "%s: cannot remove: %s; remove it, and repeat the command", path, strerror(errno));
    free(path);
    return status;
}

void vw_folder_remove_leftovers(const char *path) {
    DIR *folder = opendir(path);
    for (struct dirent *entry; folder && (entry = readdir(folder));)
        if (is_temporary_name(entry->d_name)) unlinkat(dirfd(folder), entry->d_name, 0);
    if (folder) closedir(folder);
}

// ---- Names ---------------------------------------------------------------------------------------------------------

bool vw_file_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

bool vw_folder_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

bool vw_folder_is_same(const char *left, const char *right) {
    struct stat a, b;
    return !stat(left, &a) && !stat(right, &b) && a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

enum vw_status vw_folder_create(const char *path) {
    char *partial = vw_copy_text(path);
    if (!partial) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    for (char *end = partial; !status && *end;) {
        end += strspn(end, "/");
        end += strcspn(end, "/");
        char following = *end;
        *end = 0;
        int cause = mkdir(partial, 0777) ? errno : 0;
        if (cause && !vw_folder_exists(partial))
            status = vw_fail(VW_ERROR_IO, "%s: cannot create the folder: %s; check the path and its permissions",
                             partial, strerror(cause));
        *end = following;
    }
    free(partial);
    return status;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *place) {
    (void)info, (void)kind, (void)place;
    (void)remove(path);
    return 0;
}

void vw_folder_remove(const char *path) { (void)nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS); }

char *vw_path_join(const char *folder, const char *name) {
    if (name[0] == '/') return vw_copy_text(name);
    size_t length = strlen(folder);
    bool separated = length == 0 || folder[length - 1] == '/';
    return vw_format_text("%s%s%s", folder, separated ? "" : "/", name);
}

bool vw_path_ends_with(const char *path, const char *ending) {
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && !strcasecmp(path + length - tail, ending);
}

char *vw_path_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    if (!slash) return vw_copy_text(".");
    if (slash == path) return vw_copy_text("/");
    return vw_format_text("%.*s", (int)(slash - path), path);
}

int vw_file_open_unnamed(const char *folder) {
    int descriptor = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (descriptor >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return descriptor;
    char *path = vw_path_join(folder, "unnamed-XXXXXX");
    if (!path) return -1;
    descriptor = mkostemp(path, O_CLOEXEC);
    if (descriptor >= 0) unlink(path);
    free(path);
    return descriptor;
}

// ---- Standard streams ----------------------------------------------------------------------------------------------

enum { STANDARD_STREAMS = 3 };

bool vw_streams_prepare(void) {
    for (int stream = 0; stream < STANDARD_STREAMS; stream++)
        if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", O_RDONLY) != stream)
            return false; // the lowest that is free
    return signal(SIGPIPE, SIG_IGN) != SIG_ERR && signal(SIGXFSZ, SIG_IGN) != SIG_ERR;
}
