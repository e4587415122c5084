#include "base/hash.h"
#include "ledger/ledger_private.h"

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

enum vw_status vw_ledger_hash_run(struct vw_database *database, char hash[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    enum vw_status status = hash_run_columns(
        database, "SELECT run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version FROM run",
        &hasher);
    if (!status) status = vw_table_hash(database, &vw_image_table, &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

enum vw_status vw_ledger_hash_final(struct vw_database *database, const char *run_hash, const char *head,
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
    enum vw_status status = vw_ledger_hash_run(database, run_hash);
    return status ? status
                  : vw_database_run_with(database, "UPDATE run SET row_hash = ?", run_hash, NULL,
                                         "record a hash of the run");
}

enum vw_status vw_ledger_write_final_hash(struct vw_database *database, const char *run_hash, const char *head,
                                          char final_hash[VW_HASH_HEX_BYTES]) {
    enum vw_status status = vw_ledger_hash_final(database, run_hash, head, final_hash);
    return status ? status
                  : vw_database_run_with(database, "UPDATE run SET final_hash = ?", final_hash, NULL,
                                         "record a hash of the run");
}
