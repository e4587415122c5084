// The tables of the ledger.
#ifndef VIEWWORTH_LEDGER_SCHEMA_H
#define VIEWWORTH_LEDGER_SCHEMA_H

#include "ledger/table.h"
#include "viewworth/ledger.h"

enum { VW_SCHEMA_VERSION = 3 }; // PRAGMA user_version; raised when a table changes

extern const struct vw_database_format vw_ledger_format;

// The rows that no struct of the library has.
struct vw_sealed_run {
    struct vw_ledger_run run;
    const char *row_hash, *final_hash;
};
struct vw_view_row {
    uint64_t step;
    uint32_t image_id;
    double mse, l1;
};
struct vw_retraining_row {
    uint64_t retraining;
    uint64_t seed;
    uint32_t epochs;
    const char *image_ids;
    double val_psnr;
};
struct vw_lasting_view_row {
    uint64_t step;
    uint32_t image_id;
    double psnr;
};

extern const struct vw_table vw_run_table;            // struct vw_sealed_run
extern const struct vw_table vw_image_table;          // struct vw_ledger_image
extern const struct vw_table vw_step_table;           // struct vw_step_record
extern const struct vw_table vw_view_table;           // struct vw_view_row
extern const struct vw_table vw_score_table;          // struct vw_ledger_score
extern const struct vw_table vw_retraining_table;     // struct vw_retraining_row
extern const struct vw_table vw_payout_request_table; // struct vw_payout_request
extern const struct vw_table vw_lasting_table;        // struct vw_lasting_pass: its settings
extern const struct vw_table vw_lasting_step_table;   // struct vw_lasting_step
extern const struct vw_table vw_lasting_check_table;  // struct vw_gate_check
extern const struct vw_table vw_lasting_view_table;   // struct vw_lasting_view_row

// Returns whether a step can be in its epoch, which every earlier epoch precedes with a step. What is imported, and
// what is read, has no other bound.
static inline bool vw_step_has_epoch(const struct vw_step_record *record) { return record->epoch <= record->step; }

#endif
