#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/ledger_private.h"

// ---- The run and its state ----

// Checks the status: an unknown word would be shown as if viewworth had written it.
static enum vw_status check_run(struct vw_ledger *ledger, uint64_t index, void *row) {
    static const char *const known[] = {VW_LEDGER_RUNNING, VW_LEDGER_FINISHED, "interrupted", "failed"};
    const struct vw_sealed_run *run = row;
    if (index > 0)
        return vw_fail(VW_ERROR_MISMATCH, "%s: has more than one run; use the ledger of a single run",
                       ledger->database.path);
    for (size_t i = 0; i < VW_ARRAY_COUNT(known); i++)
        if (strcmp(run->run.status, known[i]) == 0) return VW_OK;
    return vw_ledger_fail_column(ledger, "status");
}

// Copies a hash; "", which equals no hash, if the text is something else.
static void copy_hash(const char *text, char hash[VW_HASH_HEX_BYTES]) {
    bool is_hash = strlen(text) == VW_HASH_HEX_BYTES - 1;
    memcpy(hash, is_hash ? text : "", is_hash ? VW_HASH_HEX_BYTES : 1);
}

static enum vw_status load_run(struct vw_ledger *ledger) {
    void *rows = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_read_table(ledger, &vw_run_table, NULL, check_run, &rows, &count);
    if (!status && !count)
        status = vw_fail(VW_ERROR_MISMATCH, "%s: its run row was removed; restore the file from a copy",
                         ledger->database.path);
    if (!status) {
        const struct vw_sealed_run *row = rows;
        ledger->run = row->run;
        copy_hash(row->row_hash, ledger->run_hash);
        copy_hash(row->final_hash, ledger->final_hash);
        memcpy(ledger->head, ledger->run_hash, sizeof ledger->head);
    }
    free(rows);
    return status;
}

static enum vw_status load_last_step(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT step, row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) {
        int64_t step = sqlite3_column_int64(statement, 0);
        if (step < 0 || step == INT64_MAX) status = vw_ledger_fail_column(ledger, "step");
        else ledger->next_step = (uint64_t)step + 1;
        vw_row_copy_hash(statement, 1, ledger->head);
    }
    sqlite3_finalize(statement);
    return status;
}

// Reads both in one transaction, because another process may be appending.
enum vw_status vw_ledger_load(struct vw_ledger *ledger) {
    enum vw_status status = vw_database_begin_reading(&ledger->database);
    if (status) return status;
    status = load_run(ledger);
    if (!status) status = load_last_step(ledger);
    return vw_database_end(&ledger->database, status);
}

enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run) {
    *run = ledger->run;
    return VW_OK;
}

// ---- Tables ----

static enum vw_status check_step(struct vw_ledger *ledger, uint64_t index, void *row) {
    struct vw_step_record *record = row;
    record->validated = !isnan(record->val_psnr);
    if (record->step != index) return vw_ledger_fail_column(ledger, "step");
    return vw_step_has_epoch(record) ? VW_OK : vw_ledger_fail_column(ledger, "epoch");
}

enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count) {
    enum vw_status status = vw_ledger_load_images(ledger);
    return status ? status : vw_ledger_read_table(ledger, &vw_step_table, NULL, check_step, (void **)records, count);
}

enum vw_status vw_ledger_get_scores(struct vw_ledger *ledger, struct vw_ledger_score **scores, uint32_t *count) {
    static const char by_first_row_of_method[] = "min(rowid) OVER (PARTITION BY method), image_id";
    uint64_t read_count = 0;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status)
        status =
            vw_ledger_read_table(ledger, &vw_score_table, by_first_row_of_method, NULL, (void **)scores, &read_count);
    if (!status) *count = (uint32_t)read_count;
    return status;
}

enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = vw_table_select(&ledger->database, &vw_view_table, NULL, &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        struct vw_view_row row = {0};
        status = vw_ledger_read_row(ledger, &vw_view_table, statement, &row);
        const struct vw_view_error error = {.mse = row.mse, .l1 = row.l1};
        if (!status) take(context, row.step, row.image_id, &error);
    }
    sqlite3_finalize(statement);
    return status;
}
