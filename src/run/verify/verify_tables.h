// Tables of OUT, made again from the ledger and compared with the files.
#ifndef VIEWWORTH_RUN_VERIFY_VERIFY_TABLES_H
#define VIEWWORTH_RUN_VERIFY_VERIFY_TABLES_H

#include <stdbool.h>

#include "run/scoring.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// The sources of tables; all borrowed.
struct vw_table_sources {
    const char *out;
    struct vw_ledger *ledger;
    const struct vw_scoring *scoring; // its scores are those recorded, or of a run that goes on those of its steps
    const char *providers;            // FILE.csv with the providers; NULL: those of the ledger
};

// Makes scores.csv, matrix.csv, providers.csv, payout.csv and payout_photos.csv again and compares them with the files
// that are there, byte by byte. Both tables of payouts divide the amount that the ledger records. VW_ERROR_MISMATCH
// names a file that differs, or a payout that the rules refuse.
enum vw_status vw_verify_tables(const struct vw_table_sources *sources);
// Returns whether a file is such a table; `*by_provider`: it depends on who supplied the photos.
bool vw_verify_covers(const char *name, bool *by_provider);

#endif
