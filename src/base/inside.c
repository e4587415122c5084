#include "base/inside.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/openat2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"

static bool forced_walk; // set by tests before anything is opened

void vw_inside_force_walk(bool walk) { forced_walk = walk; }

bool vw_path_leaves_folder(const char *name) {
    if (*name == '/') return true;
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (!strncmp(part, "..", 2) && (part[2] == '/' || !part[2])) return true;
    }
    return false;
}

// ---- Opening without links -----------------------------------------------------------------------------------------

static void close_keeping_errno(int descriptor) {
    int cause = errno;
    if (descriptor >= 0) close(descriptor);
    errno = cause;
}

// Opens one part of a way. ELOOP for a link, also where it should be a folder, for which the kernel says ENOTDIR.
static int open_part(int folder, const char *part, int flags) {
    struct stat info;
    int opened = openat(folder, part, flags | O_NOFOLLOW | O_CLOEXEC);
    if (opened < 0 && errno == ENOTDIR && !fstatat(folder, part, &info, AT_SYMLINK_NOFOLLOW))
        errno = S_ISLNK(info.st_mode) ? ELOOP : ENOTDIR;
    return opened;
}

// Opens every part of `name` separately, and the last one with `flags`.
static int walk_below(int folder, const char *name, int flags) {
    char *parts = strdup(name), *rest = parts;
    int at = parts ? fcntl(folder, F_DUPFD_CLOEXEC, 0) : -1;
    for (char *part; at >= 0 && (part = strsep(&rest, "/"));) {
        if (!*part && rest) continue;
        int next = open_part(at, *part ? part : ".", rest ? O_PATH | O_DIRECTORY : flags);
        close_keeping_errno(at);
        at = next;
    }
    free(parts); // keeps errno
    return at;
}

// Returns the descriptor, or -1 with errno. Containers may forbid openat2 (EPERM), and old kernels lack it (ENOSYS).
static int open_below(int folder, const char *name, int flags) {
    const struct open_how how = {.flags = (uint64_t)(flags | O_NOFOLLOW | O_CLOEXEC),
                                 .resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS};
    long opened = -1;
    errno = ENOSYS;
    if (!forced_walk) opened = syscall(SYS_openat2, folder, name, &how, sizeof how);
    if (opened < 0 && (errno == ENOSYS || errno == EPERM)) return walk_below(folder, name, flags);
    return (int)opened;
}

// Returns the mode without opening the file, since opening a pipe may wait for ever. For a link it is the mode of the
// link. 0 with errno: nothing is there, or a part of the way is a link.
static mode_t mode_below(int folder, const char *name) {
    struct stat info;
    int place = open_below(folder, name, O_PATH);
    if (place < 0) return 0;
    mode_t mode = fstat(place, &info) ? 0 : info.st_mode;
    close_keeping_errno(place);
    return mode;
}

// ---- Plain files ---------------------------------------------------------------------------------------------------

enum problem { FINE, MISSING, LINKED, OTHER_KIND, FAILED }; // problem with a name; FAILED: errno says why

static enum problem problem_of(int cause) {
    if (cause == ENOENT) return MISSING;
    if (cause == ENOTDIR) return OTHER_KIND; // a file is where a folder should be
    return cause == ELOOP || cause == EXDEV ? LINKED : FAILED;
}

static enum problem find_below(int folder, const char *name, mode_t kind) {
    mode_t mode = mode_below(folder, name);
    if (!mode) return problem_of(errno);
    if (S_ISLNK(mode)) return LINKED;
    return (mode & S_IFMT) == kind ? FINE : OTHER_KIND;
}

// Checks the kind before opening and after it, since the file may have changed. O_NONBLOCK: opening a file that became
// a pipe meanwhile does not wait either.
static enum problem open_file_below(int folder, const char *name, int *descriptor) {
    struct stat info;
    enum problem problem = find_below(folder, name, S_IFREG);
    if (problem) return problem;
    int opened = open_below(folder, name, O_RDONLY | O_NONBLOCK | O_NOCTTY);
    if (opened < 0) return problem_of(errno);
    if (!fstat(opened, &info) && S_ISREG(info.st_mode)) {
        *descriptor = opened;
        return FINE;
    }
    close(opened);
    return OTHER_KIND;
}

static int open_folder(const char *path) { return open(path, O_PATH | O_DIRECTORY | O_CLOEXEC); }

static enum vw_status fail(const char *folder, const char *name, enum problem problem, int cause) {
    switch (problem) {
    case FINE: return VW_OK;
    case MISSING: return vw_fail(VW_ERROR_INPUT, "%s/%s: no such file; check the path", folder, name);
    case LINKED:
        return vw_fail(VW_ERROR_INPUT,
                       "%s/%s: is reached through a link; put the file itself there, or remove the link", folder, name);
    case OTHER_KIND:
        return vw_fail(VW_ERROR_INPUT, "%s/%s: is another kind of file than viewworth puts there; remove it", folder,
                       name);
    case FAILED: break;
    }
    return vw_fail(VW_ERROR_INPUT, "%s/%s: cannot open: %s; check the path and its permissions", folder, name,
                   strerror(cause));
}

static enum vw_status open_in(const char *folder, const char *name, int *descriptor) {
    int place = open_folder(folder);
    if (place < 0) return fail(folder, name, errno == ENOENT ? MISSING : FAILED, errno);
    enum problem problem = vw_path_leaves_folder(name) ? LINKED : open_file_below(place, name, descriptor);
    close_keeping_errno(place);
    return fail(folder, name, problem, errno);
}

enum vw_status vw_file_read_inside(const char *folder, const char *name, size_t limit_bytes, void **data,
                                   size_t *size_bytes) {
    int descriptor = -1;
    enum vw_status status = open_in(folder, name, &descriptor);
    if (status) return status;
    char *path = vw_path_join(folder, name);
    status = path ? vw_descriptor_read(descriptor, path, limit_bytes, data, size_bytes) : VW_ERROR_MEMORY;
    free(path);
    close(descriptor);
    return status;
}

static enum problem find_in(const char *folder, const char *name, mode_t kind) {
    int place = open_folder(folder);
    if (place < 0) return errno == ENOENT || errno == ENOTDIR ? MISSING : FAILED; // the caller sees the cause itself
    enum problem problem = vw_path_leaves_folder(name) ? LINKED : find_below(place, name, kind);
    close_keeping_errno(place);
    return problem;
}

bool vw_file_exists_inside(const char *folder, const char *name) { return find_in(folder, name, S_IFREG) == FINE; }

enum vw_status vw_file_check_inside(const char *folder, const char *name) {
    enum problem problem = find_in(folder, name, S_IFREG);
    return problem == MISSING ? VW_OK : fail(folder, name, problem, errno);
}

// ---- Folders -------------------------------------------------------------------------------------------------------

enum vw_status vw_folder_check_inside(const char *folder, const char *name) {
    enum problem problem = find_in(folder, name, S_IFDIR);
    return problem == MISSING ? VW_OK : fail(folder, name, problem, errno);
}

// Returns the cause of a failure, or 0.
static int create_below(int folder, const char *name) {
    char *parts = strdup(name), *rest = parts;
    int at = parts ? fcntl(folder, F_DUPFD_CLOEXEC, 0) : -1, cause = at < 0 ? errno : 0;
    for (char *part; !cause && (part = strsep(&rest, "/"));) {
        if (!*part) continue;
        bool made = !mkdirat(at, part, 0777) || errno == EEXIST;
        int next = made ? open_part(at, part, O_PATH | O_DIRECTORY) : -1;
        if (next < 0) cause = errno;
        close(at);
        at = next;
    }
    if (at >= 0) close(at);
    free(parts);
    return cause;
}

enum vw_status vw_folder_create_inside(const char *folder, const char *name) {
    enum vw_status status = vw_folder_check_inside(folder, name);
    int place = status ? -1 : open_folder(folder);
    if (status) return status;
    int cause = place < 0 ? errno : create_below(place, name);
    if (place >= 0) close(place);
    if (!cause) return VW_OK;
    return vw_fail(VW_ERROR_IO, "%s/%s: cannot create the folder: %s; check the path and its permissions", folder, name,
                   strerror(cause));
}

// ---- Links that stay inside ----------------------------------------------------------------------------------------

// Returns the name of a file below a folder after all links of both are followed, owned by the caller; NULL with the
// problem.
static char *resolve(const char *folder, const char *name, char **real_folder, enum problem *problem) {
    char *path = vw_path_join(folder, name), *real = path ? realpath(path, NULL) : NULL, *rest = NULL;
    if (path && !real) *problem = problem_of(errno);
    *real_folder = real ? realpath(folder, NULL) : NULL;
    size_t length = *real_folder ? strlen(*real_folder) : 0;
    if (length == 1) length = 0; // the root
    if (*real_folder && (strncmp(*real_folder, real, length) != 0 || real[length] != '/')) *problem = LINKED;
    else if (*real_folder) rest = vw_copy_text(real + length + 1);
    free(path); // keeps errno
    free(real);
    return rest;
}

// Follows the links first and opens the result without links, so that a link put there meanwhile is refused.
enum vw_status vw_file_open_inside(const char *folder, const char *name, int *descriptor) {
    char *real_folder = NULL;
    enum problem problem = vw_path_leaves_folder(name) ? LINKED : FAILED;
    char *real_name = problem == LINKED ? NULL : resolve(folder, name, &real_folder, &problem);
    int place = real_name ? open_folder(real_folder) : -1;
    if (place >= 0) problem = open_file_below(place, real_name, descriptor);
    close_keeping_errno(place);
    free(real_folder);
    free(real_name);
    if (problem == LINKED)
        return vw_fail(VW_ERROR_INPUT, "%s/%s: leaves the scene folder through a link; copy the file into it", folder,
                       name);
    if (problem == OTHER_KIND) return vw_fail(VW_ERROR_INPUT, "%s/%s: is not a plain file; name one", folder, name);
    return fail(folder, name, problem, errno);
}
