#include "base/hash.h"
#include "ledger/ledger_private.h"

enum vw_status vw_ledger_hash_rows(struct vw_database *database, const char *sql, struct vw_hasher *hasher) {
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
    enum vw_status status = vw_ledger_hash_rows(
        database, "SELECT run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version FROM run",
        &hasher);
    if (!status)
        status = vw_ledger_hash_rows(
            database,
            "SELECT image_id, scene_hash, name, split, provider, sha256, ground_truth FROM image ORDER "
            "BY scene_hash, image_id",
            &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

static enum vw_status find_running(struct vw_database *database, bool *running) {
    sqlite3_stmt *statement = NULL;
    enum vw_status status =
        vw_database_prepare(database, "SELECT 1 FROM run WHERE status = '" VW_LEDGER_RUNNING "'", &statement);
    if (!status) status = vw_database_next(database, statement, running);
    sqlite3_finalize(statement);
    return status;
}

enum vw_status vw_ledger_hash_final(struct vw_database *database, const char *run_hash, const char *head,
                                    char hash[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    bool running = false;
    enum vw_status status = find_running(database, &running);
    if (status) return status;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher,
                       running ? run_hash : head); // so that a batch of steps does not have to change final_hash
    status =
        vw_ledger_hash_rows(database,
                            "SELECT scene_path, config_json, scene_options_json, effects_json, plan_json, started_utc, "
                            "finished_utc, status, field_sha256 FROM run",
                            &hasher);
    if (!status)
        status = vw_ledger_hash_rows(
            database,
            "SELECT run_id, image_id, method, value, unit, stderr, visits, resampling_stderr, ci_low, "
            "ci_high, rank_ci_low,"
            " rank_ci_high FROM score ORDER BY rowid",
            &hasher);
    if (!status)
        status = vw_ledger_hash_rows(database,
                                     "SELECT run_id, retraining, whole_providers, seed, epochs, image_ids, val_psnr "
                                     "FROM retraining ORDER BY run_id, retraining",
                                     &hasher);
    if (!status)
        status = vw_ledger_hash_rows(database, "SELECT run_id, rays, epochs, states, row_hash FROM lasting", &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

static enum vw_status store(struct vw_database *database, const char *sql, const char *hash) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(database, sql, &row.statement);
    if (status) return status;
    vw_row_add_text(&row, hash);
    status = vw_row_write(&row, database, "record a hash of the run");
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_ledger_write_run_hash(struct vw_database *database, char run_hash[VW_HASH_HEX_BYTES]) {
    enum vw_status status = vw_ledger_hash_run(database, run_hash);
    return status ? status : store(database, "UPDATE run SET row_hash = ?", run_hash);
}

enum vw_status vw_ledger_write_final_hash(struct vw_database *database, const char *run_hash, const char *head,
                                          char final_hash[VW_HASH_HEX_BYTES]) {
    enum vw_status status = vw_ledger_hash_final(database, run_hash, head, final_hash);
    return status ? status : store(database, "UPDATE run SET final_hash = ?", final_hash);
}
