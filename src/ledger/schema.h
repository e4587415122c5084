// The tables of the ledger.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/database.h"

enum { VW_SCHEMA_VERSION = 1 }; // PRAGMA user_version; raised when a table changes

extern const struct vw_database_format vw_ledger_format;

#endif
