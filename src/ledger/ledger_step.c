#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "base/hash.h"
#include "ledger/ledger_private.h"

// ---- The rows of one step, and its hash ----

// Returns true if the trainer flagged the step or if a value that it reports is not finite.
static bool is_nonfinite(const struct vw_step_record *record) {
    if (record->nonfinite || !record->validated) return record->nonfinite;
    bool has_no_pooled =
        record->view_count == 0 &&
        isnan(record->val_psnr_pooled); // imported steps lack a pooled PSNR and are not flagged for that
    bool finite =
        isfinite(record->val_psnr) && (has_no_pooled || isfinite(record->val_psnr_pooled)) && isfinite(record->val_l1);
    for (uint32_t i = 0; finite && i < record->view_count; i++)
        finite = isfinite(record->views[i].mse) && isfinite(record->views[i].l1);
    return !finite;
}

// Returns the record as it is stored: without values of a step that is not finite.
static struct vw_step_record stored_record(const struct vw_step_record *record) {
    struct vw_step_record stored = *record;
    stored.nonfinite = is_nonfinite(record);
    stored.validated = record->validated && !stored.nonfinite;
    if (stored.nonfinite) stored.train_loss = NAN;
    if (!stored.validated) {
        stored.val_psnr = stored.val_psnr_pooled = stored.val_l1 = NAN;
        stored.floored_views = stored.view_count = 0;
    }
    return stored;
}

static enum vw_status chain_views(struct vw_insertion *insertion, const struct vw_step_record *record,
                                  const uint32_t *validation_views) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < record->view_count; i++) {
        assert(i == 0 || validation_views[i - 1] < validation_views[i]); // rows are hashed in key order
        const struct vw_view_row row = {.step = record->step,
                                        .image_id = validation_views[i],
                                        .mse = record->views[i].mse,
                                        .l1 = record->views[i].l1};
        status = vw_insertion_add(insertion, &row);
    }
    return status;
}

// Writes the rows of a step, or only hashes them. Replaces `head`, the row_hash before the step, by that of the step.
static enum vw_status chain_step(struct vw_step_insertions *insertions, const struct vw_step_record *record,
                                 const uint32_t *validation_views, char head[VW_HASH_HEX_BYTES]) {
    const struct vw_step_record stored = stored_record(record);
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, head);
    insertions->step.row.hasher = insertions->view.row.hasher = &hasher;
    vw_insertion_add_columns(&insertions->step, &stored);
    enum vw_status status = chain_views(&insertions->view, &stored, validation_views);
    if (status) return status;
    vw_row_end_hash(&hasher, head);
    return vw_insertion_write(&insertions->step, head);
}

static enum vw_status check_sequence(const struct vw_ledger *ledger, const struct vw_step_record *records,
                                     uint32_t count, uint64_t first) {
    for (uint32_t i = 0; i < count; i++)
        if (records[i].step != first + i)
            return vw_fail(VW_ERROR_USAGE,
                           "%s: step %" PRIu64 " was given, but the next step is %" PRIu64
                           "; resume from the ledger's end",
                           ledger->database.path, records[i].step, first + i);
    return VW_OK;
}

// ---- Appending ----

static enum vw_status prepare_inserts(struct vw_ledger *ledger) {
    struct vw_step_insertions *inserts = &ledger->inserts;
    struct vw_database *database = &ledger->database;
    const char *run_id = ledger->run.run_id;
    if (inserts->view.row.statement) return VW_OK;
    enum vw_status status = vw_insertion_begin(database, &vw_step_table, run_id, &inserts->step);
    return status ? status : vw_insertion_begin(database, &vw_view_table, run_id, &inserts->view);
}

struct appending {
    const struct vw_step_record *records;
    uint32_t count;
    const uint32_t *validation_views;
    bool continues; // the run is running again
    char head[VW_HASH_HEX_BYTES];
};

static enum vw_status write_steps(struct vw_ledger *ledger, void *context) {
    struct appending *appending = context;
    enum vw_status status = appending->continues ? vw_ledger_remove_lasting(&ledger->database) : VW_OK;
    for (uint32_t i = 0; !status && i < appending->count; i++)
        status = chain_step(&ledger->inserts, &appending->records[i], appending->validation_views, appending->head);
    return status;
}

enum vw_status vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                const uint32_t *validation_views) {
    // A run with new steps is running again, and its scores are out of date.
    struct vw_ledger_state running = {.status = VW_LEDGER_RUNNING};
    struct appending appending = {.records = records,
                                  .count = count,
                                  .validation_views = validation_views,
                                  .continues = vw_ledger_has_ended(ledger) || ledger->extended_config_json};
    memcpy(appending.head, ledger->head, sizeof appending.head);
    enum vw_status status = check_sequence(ledger, records, count, ledger->next_step);
    if (!status) status = prepare_inserts(ledger);
    if (!status) status = vw_ledger_change(ledger, appending.continues ? &running : NULL, write_steps, &appending);
    if (status) return status; // the ledger and this object are unchanged
    memcpy(ledger->head, appending.head, sizeof ledger->head);
    ledger->next_step += count;
    return VW_OK;
}

// ---- Comparing ----

// Reads the next row_hash; "", which equals no hash, if there is none.
static enum vw_status next_row_hash(struct vw_ledger *ledger, sqlite3_stmt *statement,
                                    char row_hash[VW_HASH_HEX_BYTES]) {
    bool found = false;
    row_hash[0] = 0;
    enum vw_status status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) vw_row_copy_hash(statement, 0, row_hash);
    return status;
}

static enum vw_status compare_steps(struct vw_ledger *ledger, sqlite3_stmt *row_hashes,
                                    const struct vw_step_record *records, uint32_t count,
                                    const uint32_t *validation_views) {
    const struct vw_insertion insertion = {.owner = ledger->run.run_id};
    struct vw_step_insertions hashing = {insertion, insertion};
    hashing.step.table = &vw_step_table;
    hashing.view.table = &vw_view_table;
    char head[VW_HASH_HEX_BYTES], recorded[VW_HASH_HEX_BYTES];
    memcpy(head, ledger->run_hash, sizeof head);
    enum vw_status status = records[0].step > 0 ? next_row_hash(ledger, row_hashes, head) : VW_OK;
    for (uint32_t i = 0; !status && i < count; i++) {
        status = chain_step(&hashing, &records[i], validation_views, head);
        if (!status) status = next_row_hash(ledger, row_hashes, recorded);
        if (!status && strcmp(head, recorded) != 0)
            status = vw_fail(
                VW_ERROR_MISMATCH,
                "%s: step %" PRIu64
                ", trained again, differs from the recorded step; check whether the ledger was edited (viewworth "
                "verify) or device, driver or CPU changed",
                ledger->database.path, records[i].step);
    }
    return status;
}

enum vw_status vw_ledger_compare(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                 const uint32_t *validation_views) {
    if (count == 0) return VW_OK;
    uint64_t first = records[0].step;
    enum vw_status status = check_sequence(ledger, records, count, first);
    if (!status && first + count > ledger->next_step)
        status = vw_fail(VW_ERROR_USAGE,
                         "%s: step %" PRIu64 " cannot be compared: only steps before step %" PRIu64 " are recorded",
                         ledger->database.path, first + count - 1, ledger->next_step);
    if (status) return status;
    struct vw_row key = {0};
    status = vw_database_prepare(
        &ledger->database, "SELECT row_hash FROM step WHERE run_id = ? AND step >= ? ORDER BY step", &key.statement);
    if (status) return status;
    vw_row_add_text(&key, ledger->run.run_id);
    vw_row_add_integer(&key, first > 0 ? (int64_t)first - 1 : 0); // the row before has the hash to start from
    status = key.failed ? vw_database_fail(&ledger->database, "query the ledger")
                        : compare_steps(ledger, key.statement, records, count, validation_views);
    sqlite3_finalize(key.statement);
    return status;
}
