#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

// Recomputed hashes. Each is compared with the stored one before it is used.
struct verification {
    struct vw_database *database;
    const struct vw_ledger *ledger; // its images are loaded
    char run_hash[VW_HASH_HEX_BYTES];
    char head[VW_HASH_HEX_BYTES];
};

// ---- Rows that belong to no run or scene ----

static enum vw_status find_stray(struct vw_database *database, const char *table, const char *column) {
    char *sql = vw_format_text("SELECT 1 FROM %s WHERE %s IS NOT (SELECT %s FROM run) LIMIT 1", table, column, column);
    if (!sql) return VW_ERROR_MEMORY;
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(database, sql, &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    if (!status && found)
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: table %s has a row whose %s is not that of the run: a row was edited or added",
                         database->path, table, column);
    sqlite3_finalize(statement);
    free(sql);
    return status;
}

static enum vw_status verify_belonging(struct vw_database *database) {
    static const char *const tables[] = {"step", "view", "score", "retraining", "payout_request"};
    enum vw_status status = find_stray(database, "image", "scene_hash");
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(tables); i++) status = find_stray(database, tables[i], "run_id");
    return status;
}

// ---- The status ----

// Looks for rows that a run of this status cannot have: an append removes them all, and only a run that has finished
// gets retrainings and lasting credit. So no status hides rows from whoever computes them again.
static enum vw_status verify_status(struct vw_database *database) {
    static const struct {
        const char *rows, *sql;
    } refused[] = {
        {"score rows, or a field", "SELECT count(*) FROM run WHERE status = '" VW_LEDGER_RUNNING "' AND (field_sha256 "
                                   "IS NOT NULL OR EXISTS (SELECT 1 FROM score))"},
        {"retraining rows, a payout request, or rows of lasting credit",
         "SELECT count(*) FROM run WHERE status <> '" VW_LEDGER_FINISHED "' AND (EXISTS (SELECT 1 FROM retraining) "
         "OR EXISTS (SELECT 1 FROM payout_request) OR EXISTS (SELECT 1 FROM lasting))"},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(refused); i++) {
        int64_t found = 0;
        status = vw_database_read_number(database, refused[i].sql, &found);
        if (!status && found)
            status = vw_fail(VW_ERROR_MISMATCH,
                             "%s: has %s, but a status that excludes them: the status was edited, or "
                             "rows were added",
                             database->path, refused[i].rows);
    }
    return status;
}

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
    enum vw_status status = vw_ledger_hash_run(verification->database, verification->run_hash);
    if (!status)
        status = compare_with_run(verification->database, "row_hash", verification->run_hash,
                                  "the run row was edited, or an image row was edited, removed or added");
    memcpy(verification->head, verification->run_hash, sizeof verification->head);
    return status;
}

static enum vw_status verify_final_hash(struct verification *verification) {
    char final_hash[VW_HASH_HEX_BYTES];
    enum vw_status status =
        vw_ledger_hash_final(verification->database, verification->run_hash, verification->head, final_hash);
    return status ? status
                  : compare_with_run(
                        verification->database, "final_hash", final_hash,
                        "the run row was edited, a score row was edited, removed, added or moved, a retraining row "
                        "likewise, that of payout_request likewise, or the last step rows were removed");
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

// The values that the view rows of a step allow it.
struct view_sums {
    uint32_t count;
    double psnr_db, weight; // summed
    double mse[2], l1[2];   // least and largest, of the views that count
};

static void widen(double range[2], double value, bool first) {
    if (first || !(value >= range[0])) range[0] = value;
    if (first || !(value <= range[1])) range[1] = value;
}

static void add_view(const struct vw_ledger *ledger, sqlite3_stmt *view, struct view_sums *sums) {
    enum { IMAGE_ID = 2, MSE, L1 };
    int64_t id = sqlite3_column_int64(view, IMAGE_ID);
    const struct vw_ledger_image *image = vw_ledger_find_image(ledger->images, ledger->image_count, (uint32_t)id);
    double mse = vw_row_read_real(view, MSE), weight = image ? image->weight : 1;
    sums->count++;
    if (!(weight > 0)) return;
    widen(sums->mse, mse, !(sums->weight > 0));
    widen(sums->l1, vw_row_read_real(view, L1), !(sums->weight > 0));
    sums->psnr_db += weight * vw_psnr_db(mse);
    sums->weight += weight;
}

static bool lies_within(double value, double least, double largest) {
    static const double ROUNDING = 1e-9; // share of the value: other C libraries round logarithms differently
    double rounding = ROUNDING * fmax(1, fabs(value));
    return value >= least - rounding && value <= largest + rounding;
}

// Returns whether the values of a step are what its view rows say: their weighted mean PSNR; and a pooled PSNR and a
// mean L1 that lie between those of the views, since the ledger does not have the pixels of a view, by which these two
// are weighted. Only the steps of an imported log have neither view rows nor a pooled PSNR.
static bool is_of_views(sqlite3_stmt *step, const struct view_sums *sums) {
    enum { PSNR = 5, POOLED, L1 };
    double psnr = vw_row_read_real(step, PSNR), pooled = vw_row_read_real(step, POOLED);
    if (isnan(psnr) || (!sums->count && isnan(pooled))) return true;
    double mean = sums->psnr_db / sums->weight;
    return lies_within(psnr, mean, mean) && lies_within(pooled, vw_psnr_db(sums->mse[1]), vw_psnr_db(sums->mse[0])) &&
           lies_within(vw_row_read_real(step, L1), sums->l1[0], sums->l1[1]);
}

// Adds the view rows of this step.
static enum vw_status hash_views(struct verification *verification, struct view_rows *views, int64_t step,
                                 struct vw_hasher *hasher, struct view_sums *sums) {
    enum vw_status status = VW_OK;
    while (!status && views->found) {
        int64_t its_step = sqlite3_column_int64(views->statement, 1);
        if (its_step < step) return fail_orphan(verification, views);
        if (its_step > step) return VW_OK;
        vw_row_hash(views->statement, vw_view_table.column_count, hasher);
        add_view(verification->ledger, views->statement, sums);
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
    struct view_sums sums = {0};
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, verification->head);
    vw_row_hash(steps, hash_column, &hasher);
    enum vw_status status = hash_views(verification, views, step, &hasher, &sums);
    if (status) return status;
    vw_row_end_hash(&hasher, verification->head);
    vw_row_copy_hash(steps, hash_column, stored);
    if (strcmp(stored, verification->head) != 0)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: step %" PRId64 " or one of its view rows was edited or moved: its row_hash does not match",
                       path, step);
    if (is_of_views(steps, &sums)) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: step %" PRId64
                   " or one of its view rows was edited: its val_psnr, val_psnr_pooled or val_l1 is "
                   "not what its view rows in table view give",
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

enum vw_status vw_ledger_verify(struct vw_ledger *ledger) {
    struct verification verification = {.database = &ledger->database, .ledger = ledger};
    enum vw_status status = vw_database_begin_reading(verification.database);
    if (status) return status;
    status = verify_belonging(verification.database);
    if (!status) status = verify_run(&verification);
    if (!status) status = vw_ledger_load_images(ledger); // verify_steps needs their weights
    if (!status) status = verify_steps(&verification);
    if (!status) status = vw_ledger_verify_lasting(verification.database, verification.head);
    if (!status) status = verify_final_hash(&verification);
    if (!status) status = verify_status(verification.database);
    return vw_database_end(verification.database, status);
}
