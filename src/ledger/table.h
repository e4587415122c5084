// Tables by their columns: one description of a table inserts, hashes and reads its rows.
#ifndef VIEWWORTH_LEDGER_TABLE_H
#define VIEWWORTH_LEDGER_TABLE_H

#include "base/rows.h"
#include "ledger/database.h"

struct vw_table {
    const char *name;
    const struct vw_column *columns; // in the order in which they are hashed
    int column_count;
    size_t row_bytes;      // size of the struct of a row
    const char *order;     // terms of ORDER BY, in whose order rows are hashed
    const char *doing;     // "record a score", for messages
    bool has_hash;         // a column row_hash follows the others
    const char *hashed_as; // name and version that begin row_hash where each row has a hash of its own; otherwise NULL
    int key_count;         // columns of the key where rows have a hash of their own: the first one or two
    const char *insert;    // NULL: "INSERT"; or with what to do about a row with the same key
};

// The members that every table sets. `list` is the array of its columns.
#define VW_TABLE(table_name, row, list)                                                                                \
    .name = (table_name), .columns = (list), .column_count = sizeof(list) / sizeof((list)[0]), .row_bytes = sizeof(row)

// An insertion of rows. Set row.hasher to hash them too; without row.statement they are only hashed.
struct vw_insertion {
    struct vw_database *database;
    const struct vw_table *table;
    const char *owner; // borrowed
    struct vw_row row;
};
// Prepares the statement. Call vw_insertion_end() also after a failure.
enum vw_status vw_insertion_begin(struct vw_database *database, const struct vw_table *table, const char *owner,
                                  struct vw_insertion *insertion);
// Inserts a row, with its own hash if it has one.
enum vw_status vw_insertion_add(struct vw_insertion *insertion, const void *row);
// Binds and hashes the columns, and inserts the row: the two halves, for a row_hash that covers other rows.
void vw_insertion_add_columns(struct vw_insertion *insertion, const void *row);
enum vw_status vw_insertion_write(struct vw_insertion *insertion, const char *row_hash);
void vw_insertion_end(struct vw_insertion *insertion);

// Inserts an array of rows; with `hasher`, hashes them too.
enum vw_status vw_table_insert(struct vw_database *database, const struct vw_table *table, const char *owner,
                               const void *rows, uint64_t count, struct vw_hasher *hasher);
// Returns true if each real number of the rows is one that its column stores.
bool vw_table_accepts(const struct vw_table *table, const void *rows, uint64_t count);
// Prepares the query of all columns of all rows, then row_hash; `order` are terms of ORDER BY; NULL: those of the
// table.
enum vw_status vw_table_select(struct vw_database *database, const struct vw_table *table, const char *order,
                               sqlite3_stmt **statement);
// Adds the columns of all rows in the table's order, but not row_hash.
enum vw_status vw_table_hash(struct vw_database *database, const struct vw_table *table, struct vw_hasher *hasher);

enum vw_found { VW_ROW_ABSENT, VW_ROW_FOUND, VW_ROW_EDITED };
// Finds the row that has the key of `row`, and fills in its real numbers if its own hash matches.
enum vw_status vw_table_find(struct vw_database *database, const struct vw_table *table, const char *owner, void *row,
                             enum vw_found *found);

// Writes ids as a column stores a list of them: with single spaces between. The caller owns the text; NULL with a
// recorded message if memory is short.
char *vw_table_list_ids(const uint32_t *ids, uint32_t count);

#endif
