#include "fuzz/database_edits.h"

#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "base/memory.h"
#include "fuzz/fuzz.h"

enum { EDIT_BYTES = 8, PAGE_BYTES = 4096, SECTOR_BYTES = 512, EDITS_MOST = 64 };

enum edit_kind {
    SET_HEADER,      // a byte of the file's header
    SET_BYTE,        // page, place, value
    SET_WORD,        // page, place, value of 2 bytes
    SET_PAGE_HEADER, // page, place in its first 12 bytes, value
    SET_LINK,        // page, place, a page number of 4 bytes
    COPY_PAGE,       // from, to
    SWAP_TEXT,       // page, place: exchanges two neighbouring bytes
    ADD_PAGES,       // how many; the header says so
    CUT,             // bytes from the end
    BEGIN_JOURNAL,   // pages, sector size, page size as powers of two
    JOURNAL_PAGE,    // page number, byte that it is full of
    NAME_VICTIM,     // ends the journal with the victim's name
    JOURNAL_BYTE,    // place, value
    RUN_SQL,         // which, value
    EDIT_KINDS
};

static const uint8_t journal_magic[] = {0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7};

static void put_u32(uint8_t *at, uint32_t value) {
    for (int i = 0; i < 4; i++) at[i] = (uint8_t)(value >> (24 - 8 * i));
}

static void add_to_journal(struct fuzz_database *database, const void *bytes, size_t size_bytes) {
    if (database->journal_bytes + size_bytes > FUZZ_JOURNAL_BYTES_MOST) return;
    memcpy(database->journal + database->journal_bytes, bytes, size_bytes);
    database->journal_bytes += size_bytes;
}

static void begin_journal(struct fuzz_database *database, uint32_t pages, uint32_t sector_power, uint32_t page_power) {
    uint8_t header[SECTOR_BYTES] = {0};
    memcpy(header, journal_magic, sizeof journal_magic);
    put_u32(header + 8, UINT32_MAX); // records: as many as there are
    put_u32(header + 16, pages);
    put_u32(header + 20, UINT32_C(1) << sector_power % 32);
    put_u32(header + 24, UINT32_C(1) << page_power % 32);
    database->journal_bytes = 0;
    add_to_journal(database, header, sizeof header);
}

// Adds a page with the checksum that SQLite demands: every 200th byte from the end.
static void add_journal_page(struct fuzz_database *database, uint32_t page, uint8_t fill) {
    uint8_t record[4 + PAGE_BYTES + 4];
    uint32_t sum = 0;
    put_u32(record, page);
    memset(record + 4, fill, PAGE_BYTES);
    if (page >= 1 && (size_t)page * PAGE_BYTES <= database->size_bytes)
        memcpy(record + 4, database->bytes + (size_t)(page - 1) * PAGE_BYTES, PAGE_BYTES / 2);
    for (int at = PAGE_BYTES - 200; at > 0; at -= 200) sum += record[4 + at];
    put_u32(record + 4 + PAGE_BYTES, sum);
    add_to_journal(database, record, sizeof record);
}

static void name_victim(struct fuzz_database *database, const char *path) {
    uint8_t end[16], page[4];
    uint32_t sum = 0;
    for (const char *at = path; *at; at++) sum += (uint8_t)*at;
    put_u32(page, 0x40000000 / PAGE_BYTES + 1);
    put_u32(end, (uint32_t)strlen(path));
    put_u32(end + 4, sum);
    memcpy(end + 8, journal_magic, sizeof journal_magic);
    add_to_journal(database, page, sizeof page);
    add_to_journal(database, path, strlen(path));
    add_to_journal(database, end, sizeof end);
}

static void add_pages(struct fuzz_database *database, uint32_t count) {
    for (uint32_t i = 0; i < count % 8 && database->size_bytes + PAGE_BYTES <= FUZZ_FILE_BYTES_MOST; i++) {
        memset(database->bytes + database->size_bytes, 0, PAGE_BYTES);
        database->size_bytes += PAGE_BYTES;
    }
    put_u32(database->bytes + 28, (uint32_t)(database->size_bytes / PAGE_BYTES));
}

static void apply_to_page(struct fuzz_database *database, enum edit_kind kind, const uint32_t *v) {
    uint32_t pages = (uint32_t)(database->size_bytes / PAGE_BYTES);
    if (!pages) return;
    uint8_t *page = database->bytes + (size_t)(v[0] % pages) * PAGE_BYTES;
    uint32_t place = v[1] % PAGE_BYTES, head = page == database->bytes ? 100 : 0;
    if (kind == SET_BYTE) page[place] = (uint8_t)v[2];
    if (kind == SET_WORD) page[place % (PAGE_BYTES - 1)] = (uint8_t)(v[2] >> 8), page[place % 4095 + 1] = (uint8_t)v[2];
    if (kind == SET_PAGE_HEADER) page[head + place % 12] = (uint8_t)v[2];
    if (kind == SET_LINK) put_u32(page + place % (PAGE_BYTES - 3), v[2]);
    if (kind == COPY_PAGE) memmove(database->bytes + (size_t)(v[1] % pages) * PAGE_BYTES, page, PAGE_BYTES);
    if (kind == SWAP_TEXT && place > 0) {
        uint8_t kept = page[place];
        page[place] = page[place - 1];
        page[place - 1] = kept;
    }
}

static void apply(struct fuzz_database *database, enum edit_kind kind, const uint32_t *v, const char *victim_path) {
    switch (kind) {
    case SET_HEADER:
        if (database->size_bytes >= 100) database->bytes[v[0] % 100] = (uint8_t)v[1];
        break;
    case ADD_PAGES: add_pages(database, v[0]); break;
    case CUT: database->size_bytes -= v[0] % (database->size_bytes + 1); break;
    case BEGIN_JOURNAL: begin_journal(database, v[0], v[1], v[2]); break;
    case JOURNAL_PAGE: add_journal_page(database, v[0], (uint8_t)v[1]); break;
    case NAME_VICTIM: name_victim(database, victim_path); break;
    case JOURNAL_BYTE:
        if (database->journal_bytes) database->journal[v[0] % database->journal_bytes] = (uint8_t)v[1];
        break;
    default: apply_to_page(database, kind, v);
    }
}

// Runs a statement in SQLite, which changes rows and indexes together, as a forger would. A file is made for it.
static void run_sql(struct fuzz_database *database, const char *sql, uint32_t value) {
    const char *path = fuzz_write("changed.db", database->bytes, database->size_bytes);
    sqlite3 *raw = NULL;
    sqlite3_stmt *statement = NULL;
    void *bytes = NULL;
    size_t size_bytes = 0;
    if (sqlite3_open_v2(path, &raw, SQLITE_OPEN_READWRITE, NULL) != SQLITE_OK) abort();
    sqlite3_exec(raw, "PRAGMA synchronous = OFF; PRAGMA ignore_check_constraints = ON; PRAGMA writable_schema = ON",
                 NULL, NULL, NULL);
    if (sqlite3_prepare_v2(raw, sql, -1, &statement, NULL) == SQLITE_OK) {
        if (sqlite3_bind_parameter_count(statement)) sqlite3_bind_int64(statement, 1, (int32_t)(value << 16) / 16384);
        sqlite3_step(statement);
    }
    sqlite3_finalize(statement);
    sqlite3_close(raw);
    if (vw_file_read(path, FUZZ_FILE_BYTES_MOST, &bytes, &size_bytes)) return;
    memcpy(database->bytes, bytes, size_bytes);
    database->size_bytes = size_bytes;
    free(bytes);
}

void fuzz_edit_database(const uint8_t *valid, size_t valid_bytes, const uint8_t *edits, size_t edit_bytes,
                        const char *victim_path, const char *const *changes, size_t change_count,
                        struct fuzz_database *database) {
    if (valid_bytes > FUZZ_FILE_BYTES_MOST) abort();
    memcpy(database->bytes, valid, valid_bytes);
    database->size_bytes = valid_bytes;
    database->journal_bytes = 0;
    bool changed = false; // by SQLite, once: it costs more than the rest
    for (size_t at = 0; at + EDIT_BYTES <= edit_bytes && at < EDITS_MOST * EDIT_BYTES; at += EDIT_BYTES) {
        const uint8_t *edit = edits + at;
        enum edit_kind kind = edit[0] % EDIT_KINDS;
        const uint32_t values[] = {edit[2] | (uint32_t)edit[3] << 8, edit[4] | (uint32_t)edit[5] << 8,
                                   edit[6] | (uint32_t)edit[7] << 8};
        if (kind != RUN_SQL) apply(database, kind, values, victim_path);
        else if (!changed) run_sql(database, changes[values[0] % change_count], values[1]);
        changed = changed || kind == RUN_SQL;
    }
}

void fuzz_write_database(const char *path, const struct fuzz_database *database) {
    char journal[1024];
    snprintf(journal, sizeof journal, "%s-journal", path);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(database->bytes, 1, database->size_bytes, file) != database->size_bytes || fclose(file))
        abort();
    unlink(journal);
    if (!database->journal_bytes) return;
    file = fopen(journal, "wb");
    if (!file || fwrite(database->journal, 1, database->journal_bytes, file) != database->journal_bytes || fclose(file))
        abort();
}

bool fuzz_database_is_unchanged(const char *path, const struct fuzz_database *database) {
    void *bytes = NULL;
    size_t size_bytes = 0;
    if (vw_file_read(path, SIZE_MAX, &bytes, &size_bytes)) return false;
    bool same = size_bytes == database->size_bytes && memcmp(bytes, database->bytes, size_bytes) == 0;
    free(bytes);
    return same;
}
