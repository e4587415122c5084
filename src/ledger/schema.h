// The tables of the ledger.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/database.h"

enum { VW_SCHEMA_VERSION = 5 }; // kept in PRAGMA user_version; raise it when a table changes

// Creates the tables, in the caller's transaction.
enum vw_status vw_schema_create(struct vw_database *database);
// VW_ERROR_INPUT if the file is not a ledger, or a ledger of another version.
enum vw_status vw_schema_check(struct vw_database *database);

#endif
