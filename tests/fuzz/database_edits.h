// Database files for fuzzing: a valid one, changed by a script of edits that the fuzzer invents, so that what it tries
// stays near to what SQLite and the ledger take. An edit is 8 bytes: what to do, how far apart its repetitions lie, and
// three places or values of 2 bytes each, low byte first.
#ifndef VIEWWORTH_TESTS_FUZZ_DATABASE_EDITS_H
#define VIEWWORTH_TESTS_FUZZ_DATABASE_EDITS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { FUZZ_FILE_BYTES_MOST = 1 << 18, FUZZ_JOURNAL_BYTES_MOST = 1 << 15 };
struct fuzz_database {
    uint8_t bytes[FUZZ_FILE_BYTES_MOST];
    size_t size_bytes;
    uint8_t journal[FUZZ_JOURNAL_BYTES_MOST]; // the journal beside the file; none if it is empty
    size_t journal_bytes;
    const char *sql; // a change of rows by SQLite, before the others; NULL: none
    uint32_t sql_value;
};

// Reads a valid file from `path`, and applies the edits. `victim_path`: a file that a journal may name. `changes`: the
// statements that an edit may choose from; "?1" stands for its value.
void fuzz_edit_database(const uint8_t *valid, size_t valid_bytes, const uint8_t *edits, size_t edit_bytes,
                        const char *victim_path, const char *const *changes, size_t change_count,
                        struct fuzz_database *database);
// Writes file and journal; `path` is that of the file.
void fuzz_write_database(const char *path, const struct fuzz_database *database);
// Returns whether the file at `path` is the one written.
bool fuzz_database_is_unchanged(const char *path, const struct fuzz_database *database);

#endif
