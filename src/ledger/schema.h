// The tables of the ledger.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/database.h"

// Kept in PRAGMA user_version; raise them when a table changes.
enum {
    VW_SCHEMA_VERSION = 7,
    VW_SCHEMA_VERSION_LASTING = 8, // the same tables, and those of a sweep of lasting credit
};

extern const struct vw_database_format vw_ledger_format;

#endif
