// A database file as bytes, before SQLite obeys what they say. The file, or the folder it lies in, may come from
// someone who wants to harm.
#ifndef VIEWWORTH_LEDGER_DATABASE_FILE_H
#define VIEWWORTH_LEDGER_DATABASE_FILE_H

#include "ledger/database.h"

enum { VW_DATABASE_PAGE_BYTES = 4096 };

// Checks the path before the file is opened. It must be a plain file, not a link, without the files of another journal
// mode next to it. SQLite obeys a journal when it opens a file to append, so the journal must not name another file.
// VW_ERROR_INPUT names the file and the remedy.
enum vw_status vw_database_check_place(const char *path, enum vw_database_access access);
// Checks the path before a file is created. No file that SQLite would treat as part of the new one may exist next to
// it, such as the journal of a file that was removed. VW_ERROR_INPUT names it.
enum vw_status vw_database_check_free(const char *path);
// Reads bytes of an open file. Bytes beyond its end are 0.
enum vw_status vw_database_read_bytes(struct vw_database *database, uint8_t *bytes, int count, int64_t offset);
enum vw_status vw_database_size(struct vw_database *database, sqlite3_int64 *size_bytes);
// Checks, before the first query, that the header has the page format and the journal mode that viewworth writes.
enum vw_status vw_database_check_header(struct vw_database *database, const char *what);

// ---- An open file is exactly as viewworth writes it, down to the last row of its schema ----

// Bounds on what a file can make SQLite do; before the first query.
enum vw_status vw_database_set_limits(struct vw_database *database);
// Checks header, version, schema and contents, with work in proportion to the file's size, before any table is read.
// `expected` has the schema to compare with. Rolls back what a killed program left when the file is open to append.
// VW_ERROR_INPUT names what is wrong.
enum vw_status vw_database_check(struct vw_database *database, const struct vw_database_format *format,
                                 struct vw_database *expected);

#endif
