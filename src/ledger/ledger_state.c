#include <string.h>

#include "ledger/ledger_private.h"

bool vw_ledger_has_ended(const struct vw_ledger *ledger) { return strcmp(ledger->run.status, VW_LEDGER_RUNNING) != 0; }

static enum vw_status replace_scores(struct vw_ledger *ledger, const struct vw_ledger_score *scores,
                                     uint32_t score_count) {
    enum vw_status status = vw_database_run(&ledger->database, "DELETE FROM score");
    if (status) return status;
    struct vw_row row = {0};
    status = vw_database_prepare(
        &ledger->database,
        "INSERT INTO score (run_id, image_id, method, value, unit, stderr, visits, resampling_stderr, ci_low, ci_high,"
        " rank_ci_low, rank_ci_high) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, nullif(?, 0), nullif(?, 0))",
        &row.statement);
    for (uint32_t i = 0; !status && i < score_count; i++) {
        const struct vw_ledger_score *score = &scores[i];
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, score->image_id);
        vw_row_add_text(&row, score->method);
        vw_row_add_real(&row, score->value);
        vw_row_add_text(&row, score->unit);
        vw_row_add_real(&row, score->standard_error);
        vw_row_add_integer(&row, score->visits);
        vw_row_add_real(&row, score->resampling_stderr);
        vw_row_add_real(&row, score->ci_low);
        vw_row_add_real(&row, score->ci_high);
        vw_row_add_integer(&row, score->rank_ci_low);
        vw_row_add_integer(&row, score->rank_ci_high);
        status = vw_row_write(&row, &ledger->database, "record a score");
    }
    sqlite3_finalize(row.statement);
    return status;
}

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

// Removes all retrainings when the run continues: they trained for as many steps as the run had until now.
static enum vw_status remove_retrainings(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    bool continues = strcmp(state->status, VW_LEDGER_RUNNING) == 0;
    return continues ? vw_database_run(&ledger->database, "DELETE FROM retraining") : VW_OK;
}

enum vw_status vw_ledger_write_state(struct vw_ledger *ledger, struct vw_ledger_state *state) {
    enum vw_status status = replace_scores(ledger, state->scores, state->score_count);
    if (!status) status = remove_retrainings(ledger, state);
    if (!status) status = update_run(ledger, state);
    if (!status)
        status = vw_ledger_write_final_hash(&ledger->database, ledger->run_hash, ledger->head, state->final_hash);
    return status;
}

void vw_ledger_take_state(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    ledger->run.status = state->status;
    ledger->run.finished_utc = state->finished_utc;
    ledger->run.field_sha256 = state->field_sha256;
    ledger->new_field_sha256 = NULL;
    if (ledger->extended_config_json) ledger->run.config_json = ledger->extended_config_json;
    ledger->extended_config_json = NULL;
    memcpy(ledger->final_hash, state->final_hash, sizeof ledger->final_hash);
}

enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_ledger_state state = {.status = vw_ledger_keep_text(ledger, status),
                                    .finished_utc = vw_ledger_keep_text(ledger, finished_utc),
                                    .field_sha256 = ledger->new_field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
    if (!state.status || !state.finished_utc) return VW_ERROR_MEMORY;
    enum vw_status result = vw_database_begin(&ledger->database);
    if (result) return result;
    result = vw_ledger_check_current(ledger);
    if (!result) result = vw_ledger_write_state(ledger, &state);
    result = vw_database_end(&ledger->database, result);
    if (!result) vw_ledger_take_state(ledger, &state);
    return result;
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
