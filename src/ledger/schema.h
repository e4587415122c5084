// The ledger's tables.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/database.h"

enum { VW_SCHEMA_VERSION = 5 }; // kept in PRAGMA user_version; raise it when a table changes

// Makes the tables, inside the caller's transaction.
enum vw_status vw_schema_create(struct vw_database *database);
// Refuses a file that is no ledger, or one of another version.
enum vw_status vw_schema_check(struct vw_database *database);

#endif
