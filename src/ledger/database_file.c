#include "ledger/database_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

// ---- What lies beside ----------------------------------------------------------------------------------------------

// The end of a rollback journal that names a super-journal (sqlite.org/fileformat.html, section 3).
enum { NAME_END_BYTES = 16, MAGIC_BYTES = 8 }; // length of the name, checksum, magic
static const uint8_t journal_magic[MAGIC_BYTES] = {0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};

static enum vw_status fail_journal(const char *path, const char *why) {
    return vw_fail(VW_ERROR_INPUT,
                   "%s: %s, so viewworth did not write it, and following it could destroy files; remove it if the "
                   "folder comes from someone else, then run again",
                   path, why);
}

// Refuses a journal whose end names a super-journal, which SQLite deletes. A transaction across several files has one.
static enum vw_status check_journal_end(int descriptor, const char *path, int64_t size_bytes) {
    uint8_t end[NAME_END_BYTES];
    if (size_bytes < NAME_END_BYTES) return VW_OK;
    if (pread(descriptor, end, sizeof end, size_bytes - NAME_END_BYTES) != NAME_END_BYTES)
        return vw_fail(VW_ERROR_IO, "%s: cannot read: %s; check the disk", path, strerror(errno));
    if (memcmp(end + NAME_END_BYTES - MAGIC_BYTES, journal_magic, MAGIC_BYTES) != 0) return VW_OK;
    return fail_journal(path, "the journal names another file");
}

static enum vw_status check_journal(const char *path, enum vw_database_access access) {
    struct stat info;
    if (lstat(path, &info)) return VW_OK;
    if (!S_ISREG(info.st_mode)) return fail_journal(path, "it is a link, a folder, a pipe or a device");
    if (access == VW_DATABASE_READ) return VW_OK; // who reads only asks whether it is there
    int descriptor = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0)
        return vw_fail(VW_ERROR_IO, "%s: cannot open: %s; check its permissions", path, strerror(errno));
    enum vw_status status = check_journal_end(descriptor, path, info.st_size);
    close(descriptor);
    return status;
}

// Fails if a file of this ending exists beside. SQLite reads pages from a write-ahead log next to a database, whatever
// the database's header says.
static enum vw_status check_absent(const char *path, const char *ending) {
    struct stat info;
    char *beside = vw_format_text("%s%s", path, ending);
    if (!beside) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (!lstat(beside, &info))
        status = vw_fail(VW_ERROR_INPUT, "%s: is left of another file; remove it, then run again", beside);
    free(beside);
    return status;
}

enum vw_status vw_database_check_place(const char *path, enum vw_database_access access) {
    struct stat info;
    if (lstat(path, &info))
        return vw_fail(VW_ERROR_INPUT, "%s: cannot open: %s; check the path and its permissions", path,
                       strerror(errno));
    if (!S_ISREG(info.st_mode))
        return vw_fail(VW_ERROR_INPUT, "%s: is a link, a folder, a pipe or a device; give the path of a plain file",
                       path);
    char *journal = vw_format_text("%s-journal", path);
    enum vw_status status = journal ? check_absent(path, "-wal") : VW_ERROR_MEMORY;
    if (!status) status = check_absent(path, "-shm");
    if (!status) status = check_journal(journal, access);
    free(journal);
    return status;
}

enum vw_status vw_database_check_free(const char *path) {
    enum vw_status status = check_absent(path, "-journal");
    if (!status) status = check_absent(path, "-wal");
    return status ? status : check_absent(path, "-shm");
}

// ---- Its bytes -----------------------------------------------------------------------------------------------------

enum vw_status vw_database_read_bytes(struct vw_database *database, uint8_t *bytes, int count, int64_t offset) {
    sqlite3_file *file = NULL;
    // Through SQLite's own descriptor: closing another one would drop the locks that this process has on the file.
    if (sqlite3_file_control(database->handle, NULL, SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK || !file->pMethods)
        return vw_database_fail(database, "read");
    int result = file->pMethods->xRead(file, bytes, count, offset);
    if (result == SQLITE_OK || result == SQLITE_IOERR_SHORT_READ) return VW_OK; // SQLite fills up with zeros
    return vw_fail(VW_ERROR_IO, "%s: cannot read; check the disk", database->path);
}

enum vw_status vw_database_size(struct vw_database *database, sqlite3_int64 *size_bytes) {
    sqlite3_file *file = NULL;
    sqlite3_int64 size = 0;
    if (sqlite3_file_control(database->handle, NULL, SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK ||
        !file->pMethods || file->pMethods->xFileSize(file, &size) != SQLITE_OK)
        return vw_database_fail(database, "read");
    *size_bytes = size;
    return VW_OK;
}

enum vw_status vw_database_check_header(struct vw_database *database, const char *what) {
    enum { FORMAT = 16 }; // page size, journal mode, reserved bytes and fractions of a page
    static const char magic[FORMAT] = "SQLite format 3";
    static const uint8_t format[] = {VW_DATABASE_PAGE_BYTES >> 8, 0, 1, 1, 0, 64, 32, 32};
    uint8_t header[FORMAT + sizeof format] = {0};
    enum vw_status status = vw_database_read_bytes(database, header, sizeof header, 0);
    if (status) return status;
    if (memcmp(header, magic, sizeof magic) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: not %s; check the path", database->path, what);
    if (memcmp(header + FORMAT, format, sizeof format) == 0) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: damaged or hostile: its header has another page format or journal mode than viewworth writes; "
                   "restore it from a copy",
                   database->path);
}
