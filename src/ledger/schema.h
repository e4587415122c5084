// The tables of the ledger.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/database.h"

// Kept in PRAGMA user_version; raise them when a table changes.
enum {
    VW_SCHEMA_VERSION = 7,
    VW_SCHEMA_VERSION_LASTING = 8,       // the same tables, and those of a sweep of lasting credit
    VW_SCHEMA_VERSION_LASTING_VIEWS = 9, // and that of its credit by validation photo
};

extern const struct vw_database_format vw_ledger_format;

#endif
