// A database file as bytes, before SQLite obeys what they say. The file, or the folder it lies in, may come from
// someone who wants to harm.
#ifndef VIEWWORTH_LEDGER_DATABASE_FILE_H
#define VIEWWORTH_LEDGER_DATABASE_FILE_H

#include "ledger/database.h"

enum { VW_DATABASE_PAGE_BYTES = 4096 };

// Before the file is opened: it must be a plain file and no link, without the files of another journal mode beside it.
// SQLite does what a journal says when it opens a file to append: it must be one that viewworth left when it was
// killed. VW_ERROR_INPUT names the file and the remedy.
enum vw_status vw_database_check_place(const char *path, enum vw_database_access access);
// Before a file is made: nothing may lie beside its place that SQLite would take for part of it, such as the journal of
// a file that was removed. VW_ERROR_USAGE names it.
enum vw_status vw_database_check_free(const char *path);
// Of an open file. Bytes beyond its end are 0.
enum vw_status vw_database_read_bytes(struct vw_database *database, uint8_t *bytes, int count, int64_t offset);
enum vw_status vw_database_size(struct vw_database *database, sqlite3_int64 *size_bytes);
// Before the first query: the header must say what viewworth writes. With a journal beside it, the file may not be
// `whole`: then its size is not compared with the header.
enum vw_status vw_database_check_header(struct vw_database *database, const char *what, bool whole);

// The trees of a file, whose pages must form trees: no page twice, and none deeper than SQLite reads.
struct vw_database_trees {
    struct vw_database *database;
    uint8_t *visited; // by page; owned, freed with free()
    uint32_t page_count;
};
// In a reading transaction.
enum vw_status vw_database_trees_begin(struct vw_database *database, struct vw_database_trees *trees);
// Walks the tree below a root page.
enum vw_status vw_database_trees_check(struct vw_database_trees *trees, uint32_t root);

#endif
