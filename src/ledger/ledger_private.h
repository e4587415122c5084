// Internal to the ledger: its object, and the functions that its files share.
#ifndef VIEWWORTH_LEDGER_LEDGER_PRIVATE_H
#define VIEWWORTH_LEDGER_LEDGER_PRIVATE_H

#include "ledger/database.h"
#include "viewworth/ledger.h"

#define VW_LEDGER_RUNNING "running" // the status of a run that has not ended

// The statements that insert the rows of a step; all NULL: the rows are only hashed.
struct vw_step_statements {
    sqlite3_stmt *step, *view, *probe;
};

extern const char *const vw_probe_kind_names[VW_PROBE_KIND_COUNT]; // as table probe spells them

struct vw_ledger {
    struct vw_database database;
    struct vw_step_statements inserts;  // prepared at the first append
    char run_hash[VW_HASH_HEX_BYTES];   // row_hash of the run, where the chain begins
    char head[VW_HASH_HEX_BYTES];       // row_hash of the last step, or of the run before the first
    char final_hash[VW_HASH_HEX_BYTES]; // final_hash of the run
    uint64_t next_step;
    struct vw_ledger_run run;
    const char *new_field_sha256;     // the run.field_sha256 of the next end; NULL: none
    const char *extended_config_json; // the new run.config_json, written with the next batch; NULL: unchanged
    struct vw_ledger_image *images;   // NULL until vw_ledger_get_images
    uint32_t image_count;
    char **texts; // the strings that `run`, `images` and scores point to
    size_t text_count, text_capacity;
};

// ---- ledger_read.c ----

// Reads the run row, the head of the chain and the next step.
enum vw_status vw_ledger_load(struct vw_ledger *ledger);
// Checks, in the caller's writing transaction, that the file is as this object last saw it. VW_ERROR_MISMATCH if
// another process has written to it since.
enum vw_status vw_ledger_check_current(struct vw_ledger *ledger);
// Copies a text; the copy lives as long as the ledger. Returns NULL with a recorded message if memory is short.
const char *vw_ledger_keep_text(struct vw_ledger *ledger, const char *text);
// Reads a column of the current row of a query, as do the next two: an integer of 0 to `most`; a finite number, or NaN
// for NULL; the id of one of ledger->images, which must have been loaded. They set `*status` (VW_ERROR_INPUT) if
// viewworth never writes such a value; the value that they then return has no meaning.
uint64_t vw_ledger_read_count(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, uint64_t most,
                              enum vw_status *status);
double vw_ledger_read_real(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status);
uint32_t vw_ledger_read_image_id(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column,
                                 enum vw_status *status);

// Loads the images that rows of other tables may name.
enum vw_status vw_ledger_load_images(struct vw_ledger *ledger);

// Reads the current row of a query into an item of an array; `index` counts the rows.
struct vw_row_reader {
    const char *sql;
    size_t item_bytes;
    enum vw_status (*read)(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item);
};
// Reads all rows into an array, which the caller frees.
enum vw_status vw_ledger_read_rows(struct vw_ledger *ledger, const struct vw_row_reader *reader, void **items,
                                   uint64_t *count);

// ---- ledger_hash.c: hashes of the rows, as ledger.h describes them ----

// Adds all rows of a query.
enum vw_status vw_ledger_hash_rows(struct vw_database *database, const char *sql, struct vw_hasher *hasher);
// Computes run.row_hash.
enum vw_status vw_ledger_hash_run(struct vw_database *database, char hash[VW_HASH_HEX_BYTES]);
// Computes run.final_hash from the row_hash of the run and that of the last step.
enum vw_status vw_ledger_hash_final(struct vw_database *database, const char *run_hash, const char *head,
                                    char hash[VW_HASH_HEX_BYTES]);
// Computes both, in the caller's transaction, and stores them in the run row.
enum vw_status vw_ledger_write_run_hash(struct vw_database *database, char run_hash[VW_HASH_HEX_BYTES]);
enum vw_status vw_ledger_write_final_hash(struct vw_database *database, const char *run_hash, const char *head,
                                          char final_hash[VW_HASH_HEX_BYTES]);

// ---- ledger_lasting.c: lasting credit ----

// Removes its rows, in the caller's transaction.
enum vw_status vw_ledger_remove_lasting(struct vw_database *database);
// Recomputes its row_hash; `head` is the row_hash of the last step. VW_ERROR_MISMATCH when it differs, or when a row
// belongs to no pass.
enum vw_status vw_ledger_verify_lasting(struct vw_database *database, const char *head);

// ---- ledger_state.c ----

// The state of a run: whether and how it has ended.
struct vw_ledger_state {
    const char *status;
    const char *finished_utc; // NULL: it has not ended
    const char *field_sha256; // NULL: none
    const struct vw_ledger_score *scores;
    uint32_t score_count;
    char final_hash[VW_HASH_HEX_BYTES]; // filled by vw_ledger_write_state
};

bool vw_ledger_has_ended(const struct vw_ledger *ledger);
// Writes state, scores, the extended config and a new final hash, in the caller's transaction.
enum vw_status vw_ledger_write_state(struct vw_ledger *ledger, struct vw_ledger_state *state);
// Updates the object after that transaction was committed. The texts of `state` must live as long as the ledger.
void vw_ledger_take_state(struct vw_ledger *ledger, const struct vw_ledger_state *state);

#endif
