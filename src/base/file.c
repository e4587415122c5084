#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

static enum vw_status read_all(FILE *file, const char *path, size_t limit_bytes, void **data, size_t *size_bytes) {
    char *text = NULL;
    size_t capacity = 0, used = 0;
    enum vw_status status = VW_OK;
    for (;;) { // grows the buffer, because a pipe has no size
        status = vw_grow((void **)&text, &capacity, used + 4096, 1);
        if (status) break;
        size_t got = fread(text + used, 1, capacity - used - 1, file);
        used += got;
        if (ferror(file))
            status = vw_fail(errno == EISDIR ? VW_ERROR_INPUT : VW_ERROR_IO,
                             "%s: cannot read: %s; check the path and the disk", path, strerror(errno));
        else if (used > limit_bytes)
            status = vw_fail(VW_ERROR_INPUT, "%s: larger than the %zu bytes allowed here; check the path", path,
                             limit_bytes);
        if (status || !got) break;
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
    FILE *file = fopen(path, "rb");
    if (!file)
        return vw_fail(VW_ERROR_INPUT, "%s: cannot open: %s; check the path and its permissions", path,
                       strerror(errno));
    enum vw_status status = read_all(file, path, limit_bytes, data, size_bytes);
    fclose(file);
    return status;
}

static bool write_all(int descriptor, const void *data, size_t size_bytes) {
    const char *next = data;
    while (size_bytes) {
        ssize_t written = write(descriptor, next, size_bytes);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return false;
        next += written;
        size_bytes -= (size_t)written;
    }
    return fsync(descriptor) == 0;
}

// Makes a rename survive a power cut. Some file systems cannot sync a folder; failures are ignored, since the rename
// itself was done.
static void sync_folder_of(const char *path) {
    char *folder = vw_path_folder(path);
    int descriptor = folder ? open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    if (descriptor >= 0) {
        fsync(descriptor);
        close(descriptor);
    }
    free(folder);
}

enum vw_status vw_file_write(const char *path, const void *data, size_t size_bytes) {
    char *temporary = vw_format_text("%s.part-%ld", path, (long)getpid());
    if (!temporary) return VW_ERROR_MEMORY;
    int descriptor = open(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    bool opened = descriptor >= 0;
    bool done = opened && write_all(descriptor, data, size_bytes);
    int cause = errno; // errno of the first failure, which closing and removing may change
    if (opened && close(descriptor) && done) {
        done = false;
        cause = errno;
    }
    if (done && rename(temporary, path)) {
        done = false;
        cause = errno;
    }
    if (opened && !done) unlink(temporary);
    free(temporary);
    if (!done)
        return vw_fail(VW_ERROR_IO, "%s: cannot write: %s; check the folder, its permissions and the free space", path,
                       strerror(cause));
    sync_folder_of(path);
    return VW_OK;
}

bool vw_file_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

bool vw_folder_exists(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
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

char *vw_path_join(const char *folder, const char *name) {
    if (name[0] == '/') return vw_copy_text(name);
    size_t length = strlen(folder);
    bool separated = length == 0 || folder[length - 1] == '/';
    return vw_format_text("%s%s%s", folder, separated ? "" : "/", name);
}

char *vw_path_folder(const char *path) {
    const char *slash = strrchr(path, '/');
    if (!slash) return vw_copy_text(".");
    if (slash == path) return vw_copy_text("/");
    return vw_format_text("%.*s", (int)(slash - path), path);
}

// The number of bytes of the UTF-8 character at `text`; 0 if it is invalid (overlong, a surrogate, or beyond U+10FFFF).
static int utf8_length(const unsigned char *text) {
    int length = text[0] < 0x80                      ? 1
                 : text[0] >= 0xf0 && text[0] < 0xf5 ? 4
                 : text[0] >= 0xe0                   ? 3
                 : text[0] >= 0xc2                   ? 2
                                                     : 0;
    if (text[0] >= 0xf5) return 0;
    for (int i = 1; i < length; i++)
        if ((text[i] & 0xc0) != 0x80) return 0;
    bool overlong = (text[0] == 0xe0 && text[1] < 0xa0) || (text[0] == 0xf0 && text[1] < 0x90);
    bool surrogate = text[0] == 0xed && text[1] >= 0xa0;
    bool beyond = text[0] == 0xf4 && text[1] >= 0x90;
    return overlong || surrogate || beyond ? 0 : length;
}

bool vw_name_is_clean(const char *name) {
    for (const unsigned char *next = (const unsigned char *)name; *next;) {
        int length = utf8_length(next);
        if (!length || *next < 0x20 || *next == 0x7f) return false;
        next += length;
    }
    return true;
}
