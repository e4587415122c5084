// Internal to the ledger: its object, and the functions that its files share.
#ifndef VIEWWORTH_LEDGER_LEDGER_PRIVATE_H
#define VIEWWORTH_LEDGER_LEDGER_PRIVATE_H

#include "ledger/schema.h"
#include "viewworth/ledger.h"

#define VW_LEDGER_RUNNING "running" // the status of a run that has not ended
#define VW_LEDGER_FINISHED "finished"

// The insertions of the rows of a step. Without statements the rows are only hashed.
struct vw_step_insertions {
    struct vw_insertion step, view;
};

struct vw_ledger {
    struct vw_database database;
    struct vw_step_insertions inserts;  // prepared at the first append
    char run_hash[VW_HASH_HEX_BYTES];   // row_hash of the run, where the chain begins
    char head[VW_HASH_HEX_BYTES];       // row_hash of the last step, or of the run before the first
    char final_hash[VW_HASH_HEX_BYTES]; // final_hash of the run
    uint64_t next_step;
    struct vw_ledger_run run;
    const char *new_field_sha256;     // the run.field_sha256 of the next end; NULL: none
    const char *extended_config_json; // the new run.config_json, written with the next transaction; NULL: unchanged
    struct vw_ledger_image *images;   // NULL until vw_ledger_get_images
    uint32_t image_count;
    char **texts; // the strings that `run`, `images` and scores point to
    size_t text_count, text_capacity;
};

// ---- ledger_read.c: reading rows, which may come from someone who wants to harm ----

// Copies a text; the copy lives as long as the ledger. Returns NULL with a recorded message if memory is short.
const char *vw_ledger_keep_text(struct vw_ledger *ledger, const char *text);
// Records that viewworth never writes such a value into this column.
enum vw_status vw_ledger_fail_column(const struct vw_ledger *ledger, const char *name);
// Checks a row that was read, and may complete it; the rows before it, of which there are `index`, precede it.
typedef enum vw_status vw_ledger_check_row(struct vw_ledger *ledger, uint64_t index, void *row);
// Reads all rows into an array, which the caller frees. VW_ERROR_INPUT if viewworth never writes such a value. `order`
// is as in vw_table_select(); `check` may be NULL. Where the table has a column of images, load these first.
enum vw_status vw_ledger_read_table(struct vw_ledger *ledger, const struct vw_table *table, const char *order,
                                    vw_ledger_check_row *check, void **rows, uint64_t *count);
// Loads the images that rows of other tables may name.
enum vw_status vw_ledger_load_images(struct vw_ledger *ledger);

// Reads the run row, the head of the chain and the next step.
enum vw_status vw_ledger_load(struct vw_ledger *ledger);

// ---- ledger_hash.c: hashes of the rows, as ledger.h describes them ----

// Computes run.row_hash, or run.final_hash from the row_hash of the run and that of the last step, in the caller's
// transaction, and stores it in the run row.
enum vw_status vw_ledger_write_run_hash(struct vw_database *database, char run_hash[VW_HASH_HEX_BYTES]);
enum vw_status vw_ledger_write_final_hash(struct vw_database *database, const char *run_hash, const char *head,
                                          char final_hash[VW_HASH_HEX_BYTES]);

// ---- ledger_lasting.c: lasting credit ----

// Removes its rows, in the caller's transaction.
enum vw_status vw_ledger_remove_lasting(struct vw_database *database);

// ---- ledger.c: the transaction of every change ----

// The state of a run: whether and how it has ended.
struct vw_ledger_state {
    const char *status;       // the texts live as long as the ledger
    const char *finished_utc; // NULL: it has not ended
    const char *field_sha256; // NULL: none
    const struct vw_ledger_score *scores;
    uint32_t score_count;
    char final_hash[VW_HASH_HEX_BYTES]; // filled by vw_ledger_change
};

bool vw_ledger_has_ended(const struct vw_ledger *ledger);
bool vw_ledger_has_finished(const struct vw_ledger *ledger); // only then it takes retrainings and lasting credit
// Returns the present state with other scores.
struct vw_ledger_state vw_ledger_state_with(const struct vw_ledger *ledger, const struct vw_ledger_score *scores,
                                            uint32_t score_count);
typedef enum vw_status vw_ledger_writer(struct vw_ledger *ledger, void *context);
// Changes the file in one synced transaction; all that changes an existing ledger goes through here. Checks that the
// file is as this object last saw it (VW_ERROR_MISMATCH if another process has written since), calls `write`, and
// writes the state with the extended config and a new final hash. `write` or `state` may be NULL. After a failure file
// and object are as before.
enum vw_status vw_ledger_change(struct vw_ledger *ledger, struct vw_ledger_state *state, vw_ledger_writer *write,
                                void *context);

#endif
