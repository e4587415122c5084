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

// ---- Limits --------------------------------------------------------------------------------------------------------

enum {
    SQL_BYTES_MOST = 16384,        // a statement, also one in the schema
    SCHEMA_ROW_BYTES_MOST = 32768, // a row of the schema
    ROW_BYTES_MOST = 1 << 24,      // a row of a table; the longest list the photos of a run or retraining
    COLUMNS_MOST = 64,
    SCHEMA_WORK_MOST = 100000, // operations to read a schema; ours takes some hundred
    STEPS_PER_CALL = 1000,     // operations between two calls of spend_work
    WORK_PER_BYTE = 64         // operations to check a file; ours takes about one for every byte
};

enum vw_status vw_database_set_limits(struct vw_database *database) {
    sqlite3 *handle = database->handle;
    sqlite3_limit(handle, SQLITE_LIMIT_SQL_LENGTH, SQL_BYTES_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, ROW_BYTES_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_COLUMN, COLUMNS_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
    // Ours have tables only. A file from elsewhere may have views that never end, or triggers that undo what is
    // written: these are disabled, and refused as soon as the schema is read.
    static const int off[] = {SQLITE_DBCONFIG_ENABLE_VIEW, SQLITE_DBCONFIG_ENABLE_TRIGGER,
                              SQLITE_DBCONFIG_TRUSTED_SCHEMA};
    bool failed = sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL) != SQLITE_OK;
    for (size_t i = 0; i < sizeof off / sizeof off[0]; i++)
        if (sqlite3_db_config(handle, off[i], 0, NULL) != SQLITE_OK) failed = true;
    if (failed) return vw_database_fail(database, "open");
    return vw_database_run(database, "PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0; PRAGMA temp_store = MEMORY;");
}

// Counts operations, not seconds: the same file is refused or taken on every machine.
struct work {
    uint64_t left;
};

static int spend_work(void *context) {
    struct work *work = context;
    if (work->left < STEPS_PER_CALL) return 1;
    work->left -= STEPS_PER_CALL;
    return 0;
}

// ---- The schema ----------------------------------------------------------------------------------------------------

static enum vw_status compare_versions(const struct vw_database *database, const struct vw_database_format *format,
                                       int64_t found) {
    int64_t wanted = format->version, series = VW_DATABASE_VERSION_SERIES;
    const char *path = database->path;
    if (found == wanted) return VW_OK;
    if (found < 1 || found / series != wanted / series)
        return vw_fail(VW_ERROR_INPUT, "%s: not %s; check the path", path, format->what);
    return vw_fail(VW_ERROR_INPUT,
                   "%s: made by a newer viewworth (version %" PRId64 ", this viewworth reads %" PRId64
                   "); update viewworth",
                   path, found % series, wanted % series);
}

// Lists the whole schema as one text.
static const char schema_query[] =
    "SELECT group_concat(type || ' ' || name || ' ' || tbl_name || ' ' || coalesce(sql, ''), char(10)) FROM "
    "(SELECT * FROM sqlite_schema ORDER BY type, name, tbl_name, rowid)";

static bool is_same_text(sqlite3_stmt *ours, sqlite3_stmt *theirs) {
    const void *expected = sqlite3_column_text(ours, 0), *found = sqlite3_column_text(theirs, 0);
    int size_bytes = sqlite3_column_bytes(ours, 0);
    return expected && found && size_bytes == sqlite3_column_bytes(theirs, 0) &&
           memcmp(expected, found, (size_t)size_bytes) == 0;
}

static enum vw_status compare_schema(struct vw_database *database, struct vw_database *expected) {
    sqlite3_stmt *ours = NULL, *theirs = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(expected, schema_query, &ours);
    if (!status) status = vw_database_next(expected, ours, &found);
    if (!status) status = vw_database_prepare(database, schema_query, &theirs);
    if (!status) status = vw_database_next(database, theirs, &found);
    if (!status && !is_same_text(ours, theirs))
        status = vw_fail(VW_ERROR_INPUT,
                         "%s: damaged or hostile: it has a table, index, view or trigger that viewworth does not make, "
                         "or lacks one; restore it from a copy",
                         database->path);
    sqlite3_finalize(ours);
    sqlite3_finalize(theirs);
    return status;
}

static enum vw_status check_schema(struct vw_database *database, struct vw_database *expected) {
    struct work work = {SCHEMA_WORK_MOST};
    sqlite3_limit(database->handle, SQLITE_LIMIT_LENGTH, SCHEMA_ROW_BYTES_MOST);
    sqlite3_progress_handler(database->handle, STEPS_PER_CALL, spend_work, &work);
    enum vw_status status = compare_schema(database, expected);
    sqlite3_progress_handler(database->handle, 0, NULL, NULL);
    sqlite3_limit(database->handle, SQLITE_LIMIT_LENGTH, ROW_BYTES_MOST);
    return status;
}

// ---- The contents --------------------------------------------------------------------------------------------------

// Visits every row by every tree. A cursor refuses trees that are too deep, which quick_check follows until the stack
// is exhausted.
static enum vw_status check_depths(struct vw_database *database) {
    static const char trees[] = "SELECT 'SELECT sum(1) FROM ' || tbl_name || iif(type = 'table', ' NOT INDEXED', "
                                "' INDEXED BY ' || name) FROM sqlite_schema WHERE rootpage > 0";
    sqlite3_stmt *list = NULL;
    bool listed = false, found = false;
    enum vw_status status = vw_database_prepare(database, trees, &list);
    while (!status && !(status = vw_database_next(database, list, &listed)) && listed) {
        sqlite3_stmt *rows = NULL;
        status = vw_database_prepare(database, (const char *)sqlite3_column_text(list, 0), &rows);
        if (!status) status = vw_database_next(database, rows, &found);
        sqlite3_finalize(rows);
    }
    sqlite3_finalize(list);
    return status;
}

// Finds damaged pages, and values that a column cannot store.
static enum vw_status check_contents(struct vw_database *database, sqlite3_int64 size_bytes) {
    struct work work = {WORK_PER_BYTE * (uint64_t)size_bytes};
    static const char out_of_memory[] = "error code=7";
    sqlite3_stmt *statement = NULL;
    bool found = false;
    sqlite3_progress_handler(database->handle, STEPS_PER_CALL, spend_work, &work);
    enum vw_status status = check_depths(database);
    if (!status) status = vw_database_prepare(database, "PRAGMA quick_check(1)", &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    const char *answer = !status && found ? (const char *)sqlite3_column_text(statement, 0) : NULL;
    // If memory is short, the check lists unread parts as a fault of the file: "... error code=7".
    if (answer && strstr(answer, out_of_memory))
        status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory to check the file; close other programs", database->path);
    if (!status && (!answer || strcmp(answer, "ok") != 0))
        status = vw_fail(VW_ERROR_INPUT, "%s: damaged or hostile: %s; restore it from a copy", database->path,
                         answer ? answer : "it cannot be checked");
    sqlite3_finalize(statement);
    sqlite3_progress_handler(database->handle, 0, NULL, NULL);
    return status;
}

static enum vw_status check_locked(struct vw_database *database, const struct vw_database_format *format,
                                   struct vw_database *expected) {
    int64_t version = 0;
    sqlite3_int64 size_bytes = 0;
    // The first query: it takes the lock, and rolls back when the file is open to append. It reads no schema yet.
    enum vw_status status = vw_database_read_number(database, "PRAGMA user_version", &version);
    if (!status) status = compare_versions(database, format, version);
    if (!status) status = check_schema(database, expected);
    if (!status) status = vw_database_size(database, &size_bytes);
    return status ? status : check_contents(database, size_bytes);
}

enum vw_status vw_database_check(struct vw_database *database, const struct vw_database_format *format,
                                 struct vw_database *expected) {
    enum vw_status status = vw_database_check_header(database, format->what);
    if (!status) status = vw_database_begin_reading(database);
    return status ? status : vw_database_end(database, check_locked(database, format, expected));
}
