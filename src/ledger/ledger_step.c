#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "base/hash.h"
#include "ledger/ledger_private.h"

const char *const vw_probe_kind_names[VW_PROBE_KIND_COUNT] = {
    [VW_PROBE_REPEATED] = "repeated",
    [VW_PROBE_ZERO_LEARNING_RATE] = "zero_learning_rate",
    [VW_PROBE_RESAMPLED] = "resampled",
    [VW_PROBE_SAME_STATE] = "same_state",
};

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

static void add_step_columns(struct vw_row *row, const char *run_id, const struct vw_step_record *record,
                             bool nonfinite) {
    bool valued = record->validated && !nonfinite;
    vw_row_add_text(row, run_id);
    vw_row_add_integer(row, (int64_t)record->step);
    vw_row_add_integer(row, record->epoch);
    if (record->view == VW_RECORD_UNTRAINED) vw_row_add_null(row);
    else vw_row_add_integer(row, record->view);
    vw_row_add_real(row, nonfinite ? NAN : record->train_loss);
    vw_row_add_real(row, valued ? record->val_psnr : NAN);
    vw_row_add_real(row, valued ? record->val_psnr_pooled : NAN);
    vw_row_add_real(row, valued ? record->val_l1 : NAN);
    vw_row_add_integer(row, nonfinite);
    vw_row_add_integer(row, (int64_t)record->clamped_count);
    vw_row_add_integer(row, valued ? record->floored_views : 0);
}

static enum vw_status chain_views(struct vw_ledger *ledger, struct vw_row row, const struct vw_step_record *record,
                                  const uint32_t *validation_views) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < record->view_count; i++) {
        assert(i == 0 || validation_views[i - 1] < validation_views[i]); // rows are hashed in key order
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, (int64_t)record->step);
        vw_row_add_integer(&row, validation_views[i]);
        vw_row_add_real(&row, record->views[i].mse);
        vw_row_add_real(&row, record->views[i].l1);
        status = vw_row_write(&row, &ledger->database, "record a validation view");
    }
    return status;
}

static double finite_or_nan(double value) { return isfinite(value) ? value : NAN; }

static enum vw_status chain_probes(struct vw_ledger *ledger, struct vw_row row, const struct vw_step_record *record) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < record->probe_count; i++) {
        const struct vw_probe *probe = &record->probes[i];
        assert(probe->step == record->step);
        assert(i == 0 || record->probes[i - 1].index < probe->index); // rows are hashed in key order
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, (int64_t)probe->step);
        vw_row_add_integer(&row, probe->index);
        vw_row_add_text(&row, vw_probe_kind_names[probe->kind]);
        vw_row_add_real(&row, finite_or_nan(probe->val_psnr));
        vw_row_add_real(&row, finite_or_nan(probe->val_psnr_pooled));
        vw_row_add_real(&row, finite_or_nan(probe->val_l1));
        if (probe->view == VW_RECORD_UNTRAINED) vw_row_add_null(&row);
        else vw_row_add_integer(&row, probe->view);
        status = vw_row_write(&row, &ledger->database, "record a probe");
    }
    return status;
}

// Writes the rows of a step, or only hashes them. Replaces `head`, the row_hash before the step, by that of the step.
static enum vw_status chain_step(struct vw_ledger *ledger, const struct vw_step_statements *statements,
                                 const struct vw_step_record *record, const uint32_t *validation_views,
                                 char head[VW_HASH_HEX_BYTES]) {
    bool nonfinite = is_nonfinite(record);
    enum vw_status status = VW_OK;
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, head);
    struct vw_row row = {.statement = statements->step, .hasher = &hasher};
    add_step_columns(&row, ledger->run.run_id, record, nonfinite);
    if (record->validated && !nonfinite)
        status = chain_views(ledger, (struct vw_row){.statement = statements->view, .hasher = &hasher}, record,
                             validation_views);
    if (!status)
        status = chain_probes(ledger, (struct vw_row){.statement = statements->probe, .hasher = &hasher}, record);
    if (status) return status;
    vw_row_end_hash(&hasher, head);
    row.hasher = NULL;
    vw_row_add_text(&row, head);
    return vw_row_write(&row, &ledger->database, "record a step");
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
    struct vw_step_statements *inserts = &ledger->inserts;
    enum vw_status status = VW_OK;
    if (!inserts->step)
        status = vw_database_prepare(
            &ledger->database,
            "INSERT INTO step (run_id, step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1,"
            " nonfinite, clamped, floored, row_hash) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            &inserts->step);
    if (!status && !inserts->view)
        status = vw_database_prepare(&ledger->database,
                                     "INSERT INTO view (run_id, step, image_id, mse, l1) VALUES (?, ?, ?, ?, ?)",
                                     &inserts->view);
    if (!status && !inserts->probe)
        status = vw_database_prepare(
            &ledger->database,
            "INSERT INTO probe (run_id, step, probe, kind, val_psnr, val_psnr_pooled, val_l1, image_id)"
            " VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            &inserts->probe);
    return status;
}

enum vw_status vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                const uint32_t *validation_views) {
    enum vw_status status = check_sequence(ledger, records, count, ledger->next_step);
    if (!status) status = prepare_inserts(ledger);
    if (!status) status = vw_database_begin(&ledger->database);
    if (status) return status;
    char head[VW_HASH_HEX_BYTES];
    memcpy(head, ledger->head, sizeof head);
    // A run with new steps is running again, and its scores are out of date.
    struct vw_ledger_state running = {.status = VW_LEDGER_RUNNING};
    bool changes_state = vw_ledger_has_ended(ledger) || ledger->extended_config_json;
    status = vw_ledger_check_current(ledger);
    if (!status && changes_state) status = vw_ledger_remove_lasting(&ledger->database);
    if (!status && changes_state) status = vw_ledger_write_state(ledger, &running);
    for (uint32_t i = 0; !status && i < count; i++)
        status = chain_step(ledger, &ledger->inserts, &records[i], validation_views, head);
    status = vw_database_end(&ledger->database, status);
    if (status) return status; // the ledger and this object are unchanged
    if (changes_state) vw_ledger_take_state(ledger, &running);
    memcpy(ledger->head, head, sizeof head);
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
    const struct vw_step_statements none = {0};
    char head[VW_HASH_HEX_BYTES], recorded[VW_HASH_HEX_BYTES];
    memcpy(head, ledger->run_hash, sizeof head);
    enum vw_status status = records[0].step > 0 ? next_row_hash(ledger, row_hashes, head) : VW_OK;
    for (uint32_t i = 0; !status && i < count; i++) {
        status = chain_step(ledger, &none, &records[i], validation_views, head);
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
