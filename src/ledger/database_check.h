// Checks that an open file is exactly as viewworth writes it, down to the last row of its schema and index.
#ifndef VIEWWORTH_LEDGER_DATABASE_CHECK_H
#define VIEWWORTH_LEDGER_DATABASE_CHECK_H

#include "ledger/database.h"

// Bounds on what a file can make SQLite do; before the first query.
enum vw_status vw_database_set_limits(struct vw_database *database);
// Checks header, version, trees, schema and contents, with work and memory in proportion to the file's size, before any
// table is read. `expected` has the schema to compare with. Rolls back what a killed program left when the file is open
// to append. VW_ERROR_INPUT names what is wrong.
enum vw_status vw_database_check(struct vw_database *database, const struct vw_database_format *format,
                                 struct vw_database *expected);

#endif
