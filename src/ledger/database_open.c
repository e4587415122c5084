
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/memory.h"
#include "ledger/database_file.h"

static const sqlite3_int64 SNAPSHOT_BYTES_MOST = 1 << 30;
enum { BUSY_WAIT_MS = 60000 }; // a program that reads the ledger of a running valuation must not make it fail

static enum vw_status open_handle(const char *path, const char *name, int flags, struct vw_database *database) {
    *database = (struct vw_database){.path = vw_copy_text(path)};
    if (!database->path) return VW_ERROR_MEMORY;
    if (sqlite3_open_v2(name, &database->handle, flags, NULL) != SQLITE_OK) return vw_database_fail(database, "open");
    if (sqlite3_busy_timeout(database->handle, BUSY_WAIT_MS) != SQLITE_OK) return vw_database_fail(database, "open");
    return vw_database_set_limits(database);
}

// Commits survive a power cut. EXTRA is FULL plus a sync of the folder after the journal is deleted. Without it, a
// power cut could restore the journal, which would undo a transaction that was reported as recorded.
static const char durable_sql[] = "PRAGMA foreign_keys = ON; PRAGMA journal_mode = DELETE; PRAGMA synchronous = EXTRA;";

enum vw_status vw_database_open_memory(const char *path, const struct vw_database_format *format,
                                       struct vw_database *database) {
    enum vw_status status = open_handle(path, ":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, database);
    if (!status) status = vw_database_run(database, "PRAGMA page_size = 4096; PRAGMA foreign_keys = ON;");
    _Static_assert(VW_DATABASE_PAGE_BYTES == 4096, "write it into the statement, too");
    return status ? status : vw_database_run(database, format->schema_sql);
}

// Compares the tables with those that our own statements create, which are the only definition of the format.
static enum vw_status check(struct vw_database *database, const struct vw_database_format *format) {
    struct vw_database expected;
    enum vw_status status = vw_database_open_memory(database->path, format, &expected);
    if (!status) status = vw_database_check(database, format, &expected);
    vw_database_close(&expected);
    return status;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

// Copies one state of a file under SQLite's lock, because a continuing run may be writing the file. Free `*bytes` with
// sqlite3_free(); it stays NULL if the file is too large to be copied.
static enum vw_status read_locked(struct vw_database *file, unsigned char **bytes, sqlite3_int64 *size_bytes) {
    int64_t version = 0; // the first query takes the lock, and fails where a killed program left a write half done
    enum vw_status status = vw_database_read_number(file, "PRAGMA user_version", &version);
    if (!status) status = vw_database_size(file, size_bytes);
    if (status || *size_bytes > SNAPSHOT_BYTES_MOST) return status;
    // Not by sqlite3_serialize(), which reads the schema first.
    unsigned char *copy = sqlite3_malloc64((sqlite3_uint64)*size_bytes);
    if (!copy) return vw_fail(VW_ERROR_MEMORY, "%s: out of memory to read the file", file->path);
    for (sqlite3_int64 at = 0; !status && at < *size_bytes; at += VW_DATABASE_PAGE_BYTES)
        status = vw_database_read_bytes(file, copy + at, VW_DATABASE_PAGE_BYTES, at);
    if (status) sqlite3_free(copy);
    else *bytes = copy;
    return status;
}

static enum vw_status open_bytes(const char *path, unsigned char *bytes, sqlite3_int64 size_bytes,
                                 struct vw_database *database) {
    enum vw_status status = open_handle(path, ":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, database);
    if (status) {
        sqlite3_free(bytes);
        return status;
    }
    int result = sqlite3_deserialize(database->handle, "main", bytes, size_bytes, size_bytes,
                                     SQLITE_DESERIALIZE_FREEONCLOSE | SQLITE_DESERIALIZE_READONLY); // also if it fails
    return result == SQLITE_OK ? VW_OK : vw_database_fail(database, "read");
}

// Replaces an open file by a copy of it in memory: whoever exchanges the file meanwhile, in whatever way, cannot have
// one state checked and another one read. Files beyond a GiB are read where they are.
static enum vw_status take_snapshot(struct vw_database *database, const struct vw_database_format *format) {
    unsigned char *bytes = NULL;
    sqlite3_int64 size_bytes = 0;
    enum vw_status status = vw_database_check_header(database, format->what);
    if (!status) status = vw_database_begin_reading(database);
    if (!status) status = vw_database_end(database, read_locked(database, &bytes, &size_bytes));
    if (status || !bytes) {
        sqlite3_free(bytes);
        return status;
    }
    struct vw_database file = *database;
    status = open_bytes(file.path, bytes, size_bytes, database);
    vw_database_close(&file);
    return status;
}

// ---- Opening -------------------------------------------------------------------------------------------------------

// Opens a file. Reading does not use SQLite's flag "immutable": the file may be the ledger of a running valuation,
// whose pages change, and a reader needs locks to see one state. A reader cannot write, so SQLite never rolls back,
// deletes or creates a file for it.
enum vw_status vw_database_open(const char *path, const struct vw_database_format *format,
                                enum vw_database_access access, struct vw_database *database) {
    *database = (struct vw_database){0};
    enum vw_status status = vw_database_check_place(path, access);
    if (status) return status;
    // A name that begins with "file:" or ":memory:" has a meaning of its own to SQLite.
    char *name = vw_format_text("%s%s", path[0] == '/' ? "" : "./", path);
    if (!name) return VW_ERROR_MEMORY;
    status =
        open_handle(path, name, access == VW_DATABASE_READ ? SQLITE_OPEN_READONLY : SQLITE_OPEN_READWRITE, database);
    free(name);
    if (!status && access == VW_DATABASE_READ) status = take_snapshot(database, format);
    if (!status) status = check(database, format);
    if (!status && access == VW_DATABASE_APPEND) status = vw_database_run(database, durable_sql);
    return status;
}

enum vw_status vw_database_create_file(struct vw_database *database) {
    sqlite3_int64 size_bytes = 0;
    enum vw_status status = vw_database_check_free(database->path);
    if (status) return status;
    unsigned char *bytes = sqlite3_serialize(database->handle, "main", &size_bytes, 0);
    if (!bytes) return vw_fail(VW_ERROR_MEMORY, "%s: out of memory", database->path);
    status = vw_file_create(database->path, bytes, (size_t)size_bytes);
    sqlite3_free(bytes);
    return status;
}

// Creates an empty file; also returns VW_OK if another process was faster.
static enum vw_status create_empty(const char *path, const struct vw_database_format *format) {
    struct vw_database empty;
    enum vw_status status = vw_database_open_memory(path, format, &empty);
    if (!status) status = vw_database_create_file(&empty);
    vw_database_close(&empty);
    return status == VW_ERROR_USAGE ? VW_OK : status;
}

enum vw_status vw_database_open_or_create(const char *path, const struct vw_database_format *format,
                                          struct vw_database *database) {
    struct stat info;
    *database = (struct vw_database){0};
    if (lstat(path, &info) && errno == ENOENT) {
        enum vw_status status = create_empty(path, format);
        if (status) return status;
    }
    return vw_database_open(path, format, VW_DATABASE_APPEND, database);
}
