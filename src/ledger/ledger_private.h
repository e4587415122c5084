// What ledger.c (writing) and ledger_read.c (reading) share.
#ifndef VIEWWORTH_LEDGER_PRIVATE_H
#define VIEWWORTH_LEDGER_PRIVATE_H

#include "ledger/database.h"
#include "viewworth/ledger.h"

struct vw_ledger {
    struct vw_database database;
    sqlite3_stmt *insert_step, *insert_view; // prepared at the first append
    char head[VW_HASH_HEX_BYTES];            // row_hash of the last step, or of the run before the first
    uint64_t next_step;
    bool finished; // has a final_hash, which an append would make wrong
    struct vw_ledger_run run;
    struct vw_ledger_image *images; // NULL until asked for
    uint32_t image_count;
    char **texts; // the strings that `run` and `images` lend
    size_t text_count, text_capacity;
};

// Reads the run row, the head of the chain and the next step.
enum vw_status vw_ledger_load(struct vw_ledger *ledger);

#endif
