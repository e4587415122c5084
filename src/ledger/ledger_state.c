#include <string.h>

#include "ledger/ledger_private.h"

bool vw_ledger_has_ended(const struct vw_ledger *ledger) { return strcmp(ledger->run.status, VW_LEDGER_RUNNING) != 0; }

bool vw_ledger_has_finished(const struct vw_ledger *ledger) {
    return strcmp(ledger->run.status, VW_LEDGER_FINISHED) == 0;
}

struct vw_ledger_state vw_ledger_state_with(const struct vw_ledger *ledger, const struct vw_ledger_score *scores,
                                            uint32_t score_count) {
    return (struct vw_ledger_state){.status = ledger->run.status,
                                    .finished_utc = ledger->run.finished_utc,
                                    .field_sha256 = ledger->run.field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
}

// ---- Writing -------------------------------------------------------------------------------------------------------

static enum vw_status update_run(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        &ledger->database, "UPDATE run SET config_json = ?, finished_utc = ?, status = ?, field_sha256 = ?",
        &row.statement);
    if (status) return status;
    vw_row_add_text(&row, ledger->extended_config_json ? ledger->extended_config_json : ledger->run.config_json);
    vw_row_add_text(&row, state->finished_utc);
    vw_row_add_text(&row, state->status);
    vw_row_add_text(&row, state->field_sha256);
    status = vw_row_write(&row, &ledger->database, "record the state of the run");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_state(struct vw_ledger *ledger, struct vw_ledger_state *state) {
    struct vw_database *database = &ledger->database;
    enum vw_status status = vw_database_run(database, "DELETE FROM score");
    if (!status)
        status =
            vw_table_insert(database, &vw_score_table, ledger->run.run_id, state->scores, state->score_count, NULL);
    // A run that continues loses its retrainings: they trained for as many steps as the run had until now.
    if (!status && strcmp(state->status, VW_LEDGER_RUNNING) == 0)
        status = vw_database_run(database, "DELETE FROM retraining; DELETE FROM payout_request;");
    if (!status) status = update_run(ledger, state);
    return status ? status : vw_ledger_write_final_hash(database, ledger->run_hash, ledger->head, state->final_hash);
}

static void take_state(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    ledger->run.status = state->status;
    ledger->run.finished_utc = state->finished_utc;
    ledger->run.field_sha256 = state->field_sha256;
    ledger->new_field_sha256 = NULL;
    if (ledger->extended_config_json) ledger->run.config_json = ledger->extended_config_json;
    ledger->extended_config_json = NULL;
    memcpy(ledger->final_hash, state->final_hash, sizeof ledger->final_hash);
}

static enum vw_status check_current(struct vw_ledger *ledger) {
    char final_hash[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    struct vw_database *database = &ledger->database;
    enum vw_status status = vw_database_read_hash(database, "SELECT final_hash FROM run", final_hash);
    if (!status)
        status =
            vw_database_read_hash(database, "SELECT row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", head);
    if (status) return status;
    if (strcmp(final_hash, ledger->final_hash) == 0 && strcmp(head, ledger->next_step ? ledger->head : "") == 0)
        return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: another process has written to it; use each folder for one run at a time, then --resume",
                   database->path);
}

enum vw_status vw_ledger_change(struct vw_ledger *ledger, struct vw_ledger_state *state, vw_ledger_writer *write,
                                void *context) {
    enum vw_status status = vw_database_begin(&ledger->database);
    if (status) return status;
    status = check_current(ledger);
    if (!status && write) status = write(ledger, context);
    if (!status && state) status = write_state(ledger, state);
    status = vw_database_end(&ledger->database, status);
    if (!status && state) take_state(ledger, state);
    return status;
}

// ---- How a run ends ------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_ledger_state state = {.status = vw_ledger_keep_text(ledger, status),
                                    .finished_utc = vw_ledger_keep_text(ledger, finished_utc),
                                    .field_sha256 = ledger->new_field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
    if (!state.status || !state.finished_utc) return VW_ERROR_MEMORY;
    return vw_ledger_change(ledger, &state, NULL, NULL);
}

enum vw_status vw_ledger_set_field(struct vw_ledger *ledger, const char *sha256) {
    const char *kept = vw_ledger_keep_text(ledger, sha256);
    if (!kept) return VW_ERROR_MEMORY;
    ledger->new_field_sha256 = kept;
    return VW_OK;
}

enum vw_status vw_ledger_extend(struct vw_ledger *ledger, const char *config_json) {
    const char *kept = vw_ledger_keep_text(ledger, config_json);
    if (!kept) return VW_ERROR_MEMORY;
    ledger->extended_config_json = strcmp(kept, ledger->run.config_json) == 0 ? NULL : kept;
    return VW_OK;
}
