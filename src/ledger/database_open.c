#include "ledger/database_open.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "ledger/database_check.h"
#include "ledger/database_file.h"
#include "base/file.h"
#include "base/memory.h"

enum { BUSY_WAIT_MS = 60000 }; // a program that reads the ledger of a running valuation must not make it fail

static enum vw_status open_handle(const char *path, const char *name, int flags, struct vw_database *database) {
    *database = (struct vw_database){.path = vw_copy_text(path)};
    if (!database->path) return VW_ERROR_MEMORY;
    if (sqlite3_open_v2(name, &database->handle, flags, NULL) != SQLITE_OK) return vw_database_fail(database, "open");
    if (sqlite3_busy_timeout(database->handle, BUSY_WAIT_MS) != SQLITE_OK) return vw_database_fail(database, "open");
    return vw_database_set_limits(database);
}

// EXTRA is FULL plus a sync of the folder after the journal is deleted. Without it, a power cut could restore the
// journal, which would undo a batch that was reported as recorded.
static enum vw_status make_durable(struct vw_database *database) {
    return vw_database_run(database,
                           "PRAGMA foreign_keys = ON; PRAGMA journal_mode = DELETE; PRAGMA synchronous = EXTRA;");
}

enum vw_status vw_database_open_memory(const char *path, const struct vw_database_format *format,
                                       struct vw_database *database) {
    enum vw_status status = open_handle(path, ":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, database);
    if (!status) status = vw_database_run(database, "PRAGMA page_size = 4096; PRAGMA foreign_keys = ON;");
    _Static_assert(VW_DATABASE_PAGE_BYTES == 4096, "write it into the statement, too");
    return status ? status : vw_database_run(database, format->schema_sql);
}

// There is one source of truth for the tables: what our own statements make.
static enum vw_status check(struct vw_database *database, const struct vw_database_format *format) {
    struct vw_database expected;
    enum vw_status status = vw_database_open_memory(database->path, format, &expected);
    if (!status) status = vw_database_check(database, format, &expected);
    vw_database_close(&expected);
    return status;
}

// A reader is not SQLite's "immutable": it may read the ledger of a running valuation, whose pages change, and needs
// locks to see one state. Without the right to write, SQLite never rolls back, deletes or makes a file.
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
    if (!status) status = check(database, format);
    if (!status && access == VW_DATABASE_APPEND) status = make_durable(database);
    return status;
}

enum vw_status vw_database_create_file(struct vw_database *database) {
    sqlite3_int64 size_bytes = 0;
    unsigned char *bytes = sqlite3_serialize(database->handle, "main", &size_bytes, 0);
    if (!bytes) return vw_fail(VW_ERROR_MEMORY, "%s: out of memory", database->path);
    enum vw_status status = vw_file_create(database->path, bytes, (size_t)size_bytes);
    sqlite3_free(bytes);
    return status;
}

// VW_OK also if another process was faster.
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
        enum vw_status status = vw_database_check_free(path);
        if (!status) status = create_empty(path, format);
        if (status) return status;
    }
    return vw_database_open(path, format, VW_DATABASE_APPEND, database);
}
