#include "ledger/database_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <sodium.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

static uint32_t read_u16(const uint8_t *bytes) { return (uint32_t)bytes[0] << 8 | bytes[1]; }
static uint32_t read_u32(const uint8_t *bytes) { return read_u16(bytes) << 16 | read_u16(bytes + 2); }

// ---- What lies beside ----------------------------------------------------------------------------------------------

// The header of a rollback journal (sqlite.org/fileformat.html, section 3), and the end of one that names a
// super-journal.
enum {
    MAGIC_BYTES = 8,
    INITIAL_PAGES = 16,
    SECTOR_BYTES = 20,
    PAGE_BYTES = 24,
    JOURNAL_HEADER_BYTES = 28,
    NAME_END_BYTES = 16, // length of the name, checksum, magic
    SECTOR_BYTES_LEAST = 512,
    SECTOR_BYTES_MOST = 65536
};
static const uint8_t journal_magic[MAGIC_BYTES] = {0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};

static enum vw_status fail_journal(const char *path, const char *why) {
    return vw_fail(VW_ERROR_INPUT,
                   "%s: %s, so viewworth did not write it, and following it could destroy files; remove it if the "
                   "folder comes from someone else, then run again",
                   path, why);
}

// Returns true if the end of a journal names a super-journal, which SQLite deletes. A transaction across several files
// has one.
static bool names_a_file(const uint8_t *end, int64_t size_bytes) {
    uint32_t name_bytes = read_u32(end);
    return memcmp(end + NAME_END_BYTES - MAGIC_BYTES, journal_magic, MAGIC_BYTES) == 0 && name_bytes > 0 &&
           name_bytes <= size_bytes - NAME_END_BYTES;
}

// Returns true for a journal that a power cut left empty, cut short, or with only a part of its magic. SQLite ignores
// such a journal.
static bool is_torn(const uint8_t *header, size_t size_bytes) {
    size_t same = 0;
    while (same < size_bytes && same < MAGIC_BYTES && header[same] == journal_magic[same]) same++;
    size_t zeros = same;
    while (zeros < MAGIC_BYTES && header[zeros] == 0) zeros++; // also past the end, where there is nothing
    return size_bytes < JOURNAL_HEADER_BYTES ? zeros == MAGIC_BYTES : same < MAGIC_BYTES && zeros == MAGIC_BYTES;
}

static enum vw_status check_journal_bytes(int descriptor, const char *path, int64_t size_bytes,
                                          int64_t database_pages) {
    uint8_t header[JOURNAL_HEADER_BYTES] = {0}, end[NAME_END_BYTES] = {0};
    ssize_t got = pread(descriptor, header, sizeof header, 0);
    ssize_t end_got =
        size_bytes < NAME_END_BYTES ? NAME_END_BYTES : pread(descriptor, end, sizeof end, size_bytes - NAME_END_BYTES);
    if (got < 0 || end_got != NAME_END_BYTES)
        return vw_fail(VW_ERROR_IO, "%s: cannot read: %s; check the disk", path, strerror(errno));
    if (names_a_file(end, size_bytes)) return fail_journal(path, "the journal names another file");
    if (is_torn(header, (size_t)got)) return VW_OK;
    if (memcmp(header, journal_magic, MAGIC_BYTES) != 0) return fail_journal(path, "it is not an SQLite journal");
    uint32_t sector_bytes = read_u32(header + SECTOR_BYTES), pages = read_u32(header + INITIAL_PAGES);
    if (read_u32(header + PAGE_BYTES) != VW_DATABASE_PAGE_BYTES)
        return fail_journal(path, "the journal has pages of another size");
    if (sector_bytes < SECTOR_BYTES_LEAST || sector_bytes > SECTOR_BYTES_MOST || sector_bytes & (sector_bytes - 1))
        return fail_journal(path, "the journal has an invalid sector size");
    if (pages == 0 || pages > database_pages)
        return fail_journal(path, "the journal is that of a larger or empty file");
    return VW_OK;
}

static enum vw_status check_journal(const char *path, int64_t database_pages, enum vw_database_access access) {
    struct stat info;
    if (lstat(path, &info)) return VW_OK;
    if (!S_ISREG(info.st_mode)) return fail_journal(path, "it is a link, a folder, a pipe or a device");
    if (access == VW_DATABASE_READ) return VW_OK; // who reads only asks whether it is there
    int descriptor = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0)
        return vw_fail(VW_ERROR_IO, "%s: cannot open: %s; check its permissions", path, strerror(errno));
    enum vw_status status = fstat(descriptor, &info) || !S_ISREG(info.st_mode)
                                ? fail_journal(path, "it is not a plain file")
                                : check_journal_bytes(descriptor, path, info.st_size, database_pages);
    close(descriptor);
    return status;
}

// Fails if a file exists here. SQLite reads pages from a write-ahead log next to a database, whatever the database's
// header says.
static enum vw_status check_absent(const char *path) {
    struct stat info;
    if (lstat(path, &info)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "%s: viewworth writes no such file beside its own; remove it, then run again", path);
}

enum vw_status vw_database_check_place(const char *path, enum vw_database_access access) {
    struct stat info;
    if (lstat(path, &info))
        return vw_fail(VW_ERROR_INPUT, "%s: cannot open: %s; check the path and its permissions", path,
                       strerror(errno));
    if (S_ISLNK(info.st_mode))
        return vw_fail(VW_ERROR_INPUT, "%s: is a link; name the folder that holds the file itself", path);
    if (!S_ISREG(info.st_mode))
        return vw_fail(VW_ERROR_INPUT, "%s: is a folder, a pipe or a device; give the path of a plain file", path);
    if (access == VW_DATABASE_APPEND && info.st_nlink != 1) // a write would change another folder as well
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: has %ju hard links, so that other folders would change with it; replace it by a copy: cp %s "
            "COPY && mv COPY %s",
            path, (uintmax_t)info.st_nlink, path, path);
    char *journal = vw_format_text("%s-journal", path), *log = vw_format_text("%s-wal", path);
    char *log_index = vw_format_text("%s-shm", path);
    enum vw_status status = journal && log && log_index ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = check_absent(log);
    if (!status) status = check_absent(log_index);
    if (!status) status = check_journal(journal, info.st_size / VW_DATABASE_PAGE_BYTES, access);
    free(journal);
    free(log);
    free(log_index);
    return status;
}

enum vw_status vw_database_check_free(const char *path) {
    static const char *const endings[] = {"-journal", "-wal", "-shm"};
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(endings); i++) {
        struct stat info;
        char *beside = vw_format_text("%s%s", path, endings[i]);
        if (!beside) return VW_ERROR_MEMORY;
        if (lstat(beside, &info) == 0)
            status = vw_fail(VW_ERROR_INPUT, "%s: belongs to a removed file; remove it too, or choose another --out",
                             beside);
        free(beside);
    }
    return status;
}

// ---- The header ----------------------------------------------------------------------------------------------------

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

enum vw_status vw_database_hash_file(struct vw_database *database, char sha256[VW_HASH_HEX_BYTES]) {
    enum { PIECE_BYTES = 16 * VW_DATABASE_PAGE_BYTES };
    uint8_t piece[PIECE_BYTES], hash[VW_HASH_BYTES];
    crypto_hash_sha256_state state;
    int64_t version = 0; // the query takes SQLite's lock
    sqlite3_int64 size_bytes = 0;
    enum vw_status status = vw_database_read_number(database, "PRAGMA user_version", &version);
    if (!status) status = vw_database_size(database, &size_bytes);
    crypto_hash_sha256_init(&state);
    for (sqlite3_int64 at = 0; !status && at < size_bytes; at += PIECE_BYTES) {
        int count = size_bytes - at < PIECE_BYTES ? (int)(size_bytes - at) : PIECE_BYTES;
        status = vw_database_read_bytes(database, piece, count, at);
        if (!status) crypto_hash_sha256_update(&state, piece, (unsigned long long)count);
    }
    crypto_hash_sha256_final(&state, hash);
    if (!status) vw_hash_to_hex(hash, sha256);
    return status;
}

static enum vw_status fail_damaged(const struct vw_database *database, const char *what) {
    return vw_fail(VW_ERROR_INPUT, "%s: damaged or hostile: %s; restore it from a copy", database->path, what);
}

enum {
    HEADER_BYTES = 100,
    FORMAT = 16, // page size, journal mode, reserved bytes and fractions of a page
    PAGE_COUNT = 28,
    SCHEMA_FORMAT = 44,
    AUTO_VACUUM = 52,
    ENCODING = 56,
    INCREMENTAL_VACUUM = 64
};
static const char header_magic[16] = "SQLite format 3";
static const uint8_t header_format[] = {VW_DATABASE_PAGE_BYTES >> 8, 0, 1, 1, 0, 64, 32, 32};

enum vw_status vw_database_check_header(struct vw_database *database, const char *what, bool whole) {
    uint8_t header[HEADER_BYTES] = {0};
    sqlite3_int64 size_bytes = 0;
    enum vw_status status = vw_database_read_bytes(database, header, HEADER_BYTES, 0);
    if (!status) status = vw_database_size(database, &size_bytes);
    if (status) return status;
    if (size_bytes < HEADER_BYTES || memcmp(header, header_magic, sizeof header_magic) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: not %s; check the path", database->path, what);
    if (memcmp(header + FORMAT, header_format, sizeof header_format) != 0)
        return fail_damaged(database, "its header has another page format or journal mode than viewworth writes");
    if (read_u32(header + SCHEMA_FORMAT) != 4)
        return fail_damaged(database, "its schema has another format than viewworth writes");
    if (read_u32(header + ENCODING) != 1) return fail_damaged(database, "its text is not UTF-8");
    if (read_u32(header + AUTO_VACUUM) != 0 || read_u32(header + INCREMENTAL_VACUUM) != 0)
        return fail_damaged(database, "its header asks for vacuuming, which viewworth does not use");
    if (whole && (size_bytes % VW_DATABASE_PAGE_BYTES != 0 ||
                  read_u32(header + PAGE_COUNT) != size_bytes / VW_DATABASE_PAGE_BYTES))
        return fail_damaged(database, "its size differs from what its header says");
    return VW_OK;
}

// ---- The trees -----------------------------------------------------------------------------------------------------

enum {
    INTERIOR_INDEX = 2,
    INTERIOR_TABLE = 5,
    LEAF_INDEX = 10,
    LEAF_TABLE = 13,
    CELL_COUNT = 3,
    RIGHT_CHILD = 8,
    INTERIOR_HEADER_BYTES = 12,
    DEPTH_MOST = 20 // as SQLite's cursors
};

enum vw_status vw_database_trees_begin(struct vw_database *database, struct vw_database_trees *trees) {
    sqlite3_int64 size_bytes = 0;
    enum vw_status status = vw_database_size(database, &size_bytes);
    if (status) return status;
    *trees =
        (struct vw_database_trees){.database = database, .page_count = (uint32_t)(size_bytes / VW_DATABASE_PAGE_BYTES)};
    trees->visited = vw_allocate(trees->page_count + (size_t)1, 1);
    return trees->visited ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status visit(struct vw_database_trees *trees, uint32_t page, uint32_t depth);

// Visits the children of an interior page. `head` is the offset of the page's own header: page 1 begins with the header
// of the file.
static enum vw_status visit_children(struct vw_database_trees *trees, uint32_t page, uint32_t head, uint32_t depth) {
    uint8_t bytes[VW_DATABASE_PAGE_BYTES] = {0};
    enum vw_status status =
        vw_database_read_bytes(trees->database, bytes, sizeof bytes, (int64_t)(page - 1) * VW_DATABASE_PAGE_BYTES);
    uint32_t cell_count = status ? 0 : read_u16(bytes + head + CELL_COUNT);
    if (!status && head + INTERIOR_HEADER_BYTES + 2 * cell_count > sizeof bytes)
        status = fail_damaged(trees->database, "a page has more cells than fit");
    for (uint32_t i = 0; !status && i < cell_count; i++) {
        uint32_t cell = read_u16(bytes + head + INTERIOR_HEADER_BYTES + 2 * i);
        status = cell > sizeof bytes - 4 ? fail_damaged(trees->database, "a cell lies outside its page")
                                         : visit(trees, read_u32(bytes + cell), depth + 1);
    }
    return status ? status : visit(trees, read_u32(bytes + head + RIGHT_CHILD), depth + 1);
}

static enum vw_status visit(struct vw_database_trees *trees, uint32_t page, uint32_t depth) {
    if (page < 1 || page > trees->page_count) return fail_damaged(trees->database, "a tree leads out of the file");
    if (trees->visited[page]) return fail_damaged(trees->database, "a page belongs to two places");
    if (depth > DEPTH_MOST) return fail_damaged(trees->database, "a tree is too deep");
    trees->visited[page] = 1;
    uint32_t head = page == 1 ? HEADER_BYTES : 0;
    uint8_t type = 0;
    enum vw_status status =
        vw_database_read_bytes(trees->database, &type, 1, (int64_t)(page - 1) * VW_DATABASE_PAGE_BYTES + head);
    if (status || type == LEAF_INDEX || type == LEAF_TABLE) return status;
    if (type == INTERIOR_INDEX || type == INTERIOR_TABLE) return visit_children(trees, page, head, depth);
    return fail_damaged(trees->database, "a page of a tree is none");
}

// Checks the shape of a tree and visits each page once. This comes before SQLite's own check, which finds a page that
// is used twice only after it has read everything below that page again and again, and which follows a chain of pages
// until its stack is exhausted.
enum vw_status vw_database_trees_check(struct vw_database_trees *trees, uint32_t root) { return visit(trees, root, 1); }
