#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "ledger/ledger_private.h"

// ---- The hashes of the run row, as ledger.h describes them ----------------------------------------------------------

// Adds the one row of a query of columns of the run.
static enum vw_status hash_run_columns(struct vw_database *database, const char *sql, struct vw_hasher *hasher) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(database, sql, &statement);
    while (!status && !(status = vw_database_next(database, statement, &found)) && found)
        vw_row_hash(statement, sqlite3_column_count(statement), hasher);
    sqlite3_finalize(statement);
    return status;
}

// Computes run.row_hash.
static enum vw_status hash_run(struct vw_database *database, char hash[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    enum vw_status status = hash_run_columns(
        database, "SELECT run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version FROM run",
        &hasher);
    if (!status) status = vw_table_hash(database, &vw_image_table, &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

// Computes run.final_hash from the row_hash of the run and that of the last step.
static enum vw_status hash_final(struct vw_database *database, const char *run_hash, const char *head,
                                 char hash[VW_HASH_HEX_BYTES]) {
    static const char running_sql[] = "SELECT count(*) FROM run WHERE status = '" VW_LEDGER_RUNNING "'";
    struct vw_hasher hasher;
    int64_t running = 0;
    enum vw_status status = vw_database_read_number(database, running_sql, &running);
    if (status) return status;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, running ? run_hash : head); // so that an append does not have to change final_hash
    status = hash_run_columns(database,
                              "SELECT scene_path, config_json, scene_options_json, effects_json, plan_json, "
                              "started_utc, finished_utc, status, field_sha256 FROM run",
                              &hasher);
    if (!status) status = vw_table_hash(database, &vw_score_table, &hasher);
    if (!status) status = vw_table_hash(database, &vw_retraining_table, &hasher);
    if (!status)
        status = hash_run_columns(database, "SELECT run_id, rays, epochs, states, row_hash FROM lasting", &hasher);
    if (!status) status = vw_table_hash(database, &vw_payout_request_table, &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

enum vw_status vw_ledger_write_run_hash(struct vw_database *database, char run_hash[VW_HASH_HEX_BYTES]) {
    enum vw_status status = hash_run(database, run_hash);
    return status ? status
                  : vw_database_run_with(database, "UPDATE run SET row_hash = ?", run_hash, NULL,
                                         "record a hash of the run");
}

enum vw_status vw_ledger_write_final_hash(struct vw_database *database, const char *run_hash, const char *head,
                                          char final_hash[VW_HASH_HEX_BYTES]) {
    enum vw_status status = hash_final(database, run_hash, head, final_hash);
    return status ? status
                  : vw_database_run_with(database, "UPDATE run SET final_hash = ?", final_hash, NULL,
                                         "record a hash of the run");
}

// ---- Verification --------------------------------------------------------------------------------------------------

// Recomputed hashes. Each is compared with the stored one before it is used.
struct verification {
    struct vw_database *database;
    char run_hash[VW_HASH_HEX_BYTES];
    char head[VW_HASH_HEX_BYTES];
};

// ---- The hashes of the run row ----

// Compares a hash in the run row with the recomputed one.
static enum vw_status compare_with_run(struct vw_database *database, const char *column, const char *hash,
                                       const char *suspects) {
    char stored[VW_HASH_HEX_BYTES];
    char *sql = vw_format_text("SELECT %s FROM run", column);
    enum vw_status status = sql ? vw_database_read_hash(database, sql, stored) : VW_ERROR_MEMORY;
    if (!status && strcmp(stored, hash) != 0)
        status = vw_fail(VW_ERROR_MISMATCH, "%s: %s: %s does not match", database->path, suspects, column);
    free(sql);
    return status;
}

static enum vw_status verify_run(struct verification *verification) {
    enum vw_status status = hash_run(verification->database, verification->run_hash);
    if (!status)
        status = compare_with_run(verification->database, "row_hash", verification->run_hash,
                                  "the run row was edited, or an image row was edited, removed or added");
    memcpy(verification->head, verification->run_hash, sizeof verification->head);
    return status;
}

static enum vw_status verify_final_hash(struct verification *verification) {
    char final_hash[VW_HASH_HEX_BYTES];
    enum vw_status status = hash_final(verification->database, verification->run_hash, verification->head, final_hash);
    return status ? status
                  : compare_with_run(
                        verification->database, "final_hash", final_hash,
                        "the run row was edited, a score row was edited, removed, added or moved, a retraining row "
                        "likewise, one of lasting or payout_request likewise, or the last step rows were removed");
}

// ---- The chain of the steps ----

// The view rows, read beside the steps in the order of the keys.
struct view_rows {
    sqlite3_stmt *statement;
    bool found; // there is a current row: the first one that no earlier step has used
};

static enum vw_status fail_orphan(const struct verification *verification, const struct view_rows *views) {
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: table view has a row of step %" PRId64
                   ", which has no step row: a step row was removed or the row was added",
                   verification->database->path, (int64_t)sqlite3_column_int64(views->statement, 1));
}

// Adds the view rows of this step.
static enum vw_status hash_views(struct verification *verification, struct view_rows *views, int64_t step,
                                 struct vw_hasher *hasher) {
    enum vw_status status = VW_OK;
    while (!status && views->found) {
        int64_t its_step = sqlite3_column_int64(views->statement, 1);
        if (its_step < step) return fail_orphan(verification, views);
        if (its_step > step) return VW_OK;
        vw_row_hash(views->statement, vw_view_table.column_count, hasher);
        status = vw_database_next(verification->database, views->statement, &views->found);
    }
    return status;
}

// Verifies the current row of `steps`, which must be that of `step`; its last column is row_hash.
static enum vw_status verify_step(struct verification *verification, sqlite3_stmt *steps, int64_t step,
                                  struct view_rows *views) {
    const char *path = verification->database->path;
    if (sqlite3_column_int64(steps, 1) != step)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: step %" PRId64 " is missing: step %" PRId64
                       " follows instead; step rows were removed, renumbered or added",
                       path, step, (int64_t)sqlite3_column_int64(steps, 1));
    int hash_column = vw_step_table.column_count;
    char stored[VW_HASH_HEX_BYTES];
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, verification->head);
    vw_row_hash(steps, hash_column, &hasher);
    enum vw_status status = hash_views(verification, views, step, &hasher);
    if (status) return status;
    vw_row_end_hash(&hasher, verification->head);
    vw_row_copy_hash(steps, hash_column, stored);
    if (strcmp(stored, verification->head) == 0) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: step %" PRId64 " or one of its view rows was edited or moved: its row_hash does not match",
                   path, step);
}

static enum vw_status verify_steps(struct verification *verification) {
    struct view_rows views = {0};
    sqlite3_stmt *steps = NULL;
    bool found = false;
    enum vw_status status = vw_table_select(verification->database, &vw_step_table, NULL, &steps);
    if (!status) status = vw_table_select(verification->database, &vw_view_table, NULL, &views.statement);
    if (!status) status = vw_database_next(verification->database, views.statement, &views.found);
    for (int64_t step = 0; !status && !(status = vw_database_next(verification->database, steps, &found)) && found;
         step++)
        status = verify_step(verification, steps, step, &views);
    if (!status && views.found) status = fail_orphan(verification, &views);
    sqlite3_finalize(steps);
    sqlite3_finalize(views.statement);
    return status;
}

// ---- Lasting credit ------------------------------------------------------------------------------------------------

static enum vw_status hash_pass(struct vw_database *database, const char *head, char hash[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, head);
    enum vw_status status = vw_table_hash(database, &vw_lasting_table, &hasher);
    if (!status) status = vw_table_hash(database, &vw_lasting_step_table, &hasher);
    if (!status) status = vw_table_hash(database, &vw_lasting_check_table, &hasher);
    if (!status) status = vw_table_hash(database, &vw_lasting_view_table, &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

// Verifies lasting credit; `head` is the row_hash of the last step.
static enum vw_status verify_lasting(struct vw_database *database, const char *head) {
    char hash[VW_HASH_HEX_BYTES], stored[VW_HASH_HEX_BYTES];
    int64_t pass_count = 0;
    enum vw_status status = vw_database_read_number(database, "SELECT count(*) FROM lasting", &pass_count);
    if (status || !pass_count) return status;
    status = vw_database_read_hash(database, "SELECT row_hash FROM lasting", stored);
    if (!status) status = hash_pass(database, head, hash);
    if (status || strcmp(stored, hash) == 0) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: a row of lasting credit (lasting, lasting_step, lasting_check or"
                   " lasting_view) was edited, "
                   "removed or added: its row_hash does not match",
                   database->path);
}

// ---- All of it -----------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_verify(struct vw_ledger *ledger) {
    struct verification verification = {.database = &ledger->database};
    enum vw_status status = vw_database_begin_reading(verification.database);
    if (status) return status;
    status = verify_run(&verification);
    if (!status) status = verify_steps(&verification);
    if (!status) status = verify_lasting(verification.database, verification.head);
    if (!status) status = verify_final_hash(&verification);
    return vw_database_end(verification.database, status);
}
