// Tables of OUT, made again from the ledger and compared with the files.
#ifndef VIEWWORTH_RUN_VERIFY_VERIFY_TABLES_H
#define VIEWWORTH_RUN_VERIFY_VERIFY_TABLES_H

#include <stdbool.h>

#include "run/outputs/checksums.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

// The sources of tables; all borrowed.
struct vw_table_sources {
    const char *out;
    struct vw_ledger *ledger;
    const struct vw_value_input *input;
    const struct vw_ledger_score *scores; // recorded; of a run that has not ended those that its steps give
    uint32_t score_count;
    const char *providers;     // FILE.csv with the providers; NULL: those of the ledger
    struct vw_checksums *read; // notes the bytes that were compared
};

// Makes scores.csv, matrix.csv, providers.csv, payout.csv and payout_photos.csv again and compares them with the files
// that are there, byte by byte. The matrix and the intervals of payouts depend on logarithms, which another C library
// rounds another way: numbers in these columns may differ in the last digits, nothing else. Both tables of payouts
// divide the amount that payout.csv states, if the ledger records that it was to be paid. VW_ERROR_MISMATCH names a
// file that differs, or a payout that the rules refuse.
enum { VW_DERIVED_TABLE_COUNT = 5 };
struct vw_verified_table {
    const char *name;
    bool by_provider; // it depends on who supplied the photos
    bool present;
};
enum vw_status vw_verify_tables(const struct vw_table_sources *sources,
                                struct vw_verified_table tables[VW_DERIVED_TABLE_COUNT]);

#endif
