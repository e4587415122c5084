// The hash chain of a ledger, written a second time from its description in viewworth/ledger.h, and without our code.
#ifndef VIEWWORTH_TESTS_SUPPORT_LEDGER_CHAIN_H
#define VIEWWORTH_TESTS_SUPPORT_LEDGER_CHAIN_H

#include <sodium.h>

#include "support/ledger_sql.h"

static inline void feed(crypto_generichash_state *state, char tag, uint64_t word, const char *text) {
    unsigned char bytes[9] = {(unsigned char)tag};
    for (int i = 0; i < 8; i++) bytes[1 + i] = (unsigned char)(word >> 8 * i);
    crypto_generichash_update(state, bytes, tag == 'n' ? 1 : 9);
    if (text) crypto_generichash_update(state, (const unsigned char *)text, strlen(text));
}

static inline void feed_text(crypto_generichash_state *state, const char *text) {
    feed(state, 't', strlen(text), text);
}

static inline void feed_rows(crypto_generichash_state *state, sqlite3 *raw, const char *sql, int64_t value) {
    sqlite3_stmt *statement = sql_query(raw, sql, value);
    while (sqlite3_step(statement) == SQLITE_ROW)
        for (int i = 0; i < sqlite3_column_count(statement); i++) {
            double real = sqlite3_column_double(statement, i);
            uint64_t bits;
            memcpy(&bits, &real, sizeof bits);
            switch (sqlite3_column_type(statement, i)) {
            case SQLITE_INTEGER: feed(state, 'i', (uint64_t)sqlite3_column_int64(statement, i), NULL); break;
            case SQLITE_FLOAT: feed(state, 'r', bits, NULL); break;
            case SQLITE_TEXT: feed_text(state, (const char *)sqlite3_column_text(statement, i)); break;
            default: feed(state, 'n', 0, NULL);
            }
        }
    sqlite3_finalize(statement);
}

enum { OF_RUN = -1, OF_SWEEP = -2 };

// Ends a hash into `hex` and tells whether run.COLUMN, or with `step` not OF_RUN that of the step or of the sweep, is
// the same. With `rewrite`, makes it the same.
static inline bool hash_is(crypto_generichash_state *state, sqlite3 *raw, const char *column, int64_t step,
                           bool rewrite, char hex[VW_HASH_HEX_BYTES]) {
    unsigned char hash[VW_HASH_BYTES];
    crypto_generichash_final(state, hash, sizeof hash);
    sodium_bin2hex(hex, 65, hash, sizeof hash);
    const char *table = step == OF_RUN     ? "run"
                        : step == OF_SWEEP ? "lasting"
                                           : "step",
               *which = step < 0 ? "" : " WHERE step = ?";
    char *change = vw_format_text("UPDATE %s SET %s = '%s'%s", table, column, hex, which);
    char *ask = vw_format_text("SELECT %s FROM %s%s", column, table, which);
    sqlite3_stmt *statement = sql_query(raw, rewrite ? change : ask, step);
    bool row = sqlite3_step(statement) == SQLITE_ROW;
    bool same = rewrite || (row && strcmp((const char *)sqlite3_column_text(statement, 0), hex) == 0);
    sqlite3_finalize(statement);
    free(change);
    free(ask);
    return same;
}

static inline int64_t count_steps(sqlite3 *raw) {
    sqlite3_stmt *statement = sql_query(raw, "SELECT count(*) FROM step", 0);
    sqlite3_step(statement);
    int64_t count = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return count;
}

static inline bool is_running(sqlite3 *raw) {
    sqlite3_stmt *statement = sql_query(raw, "SELECT 1 FROM run WHERE status = 'running'", 0);
    bool running = sqlite3_step(statement) == SQLITE_ROW;
    sqlite3_finalize(statement);
    return running;
}

static inline bool has_sweep(sqlite3 *raw) {
    sqlite3_stmt *statement = sql_query(raw, "SELECT 1 FROM lasting", 0);
    bool found = sqlite3_step(statement) == SQLITE_ROW;
    sqlite3_finalize(statement);
    return found;
}

static inline bool follow_sweep(sqlite3 *raw, const char *last_row_hash, bool rewrite) {
    crypto_generichash_state state;
    char hash[VW_HASH_HEX_BYTES];
    crypto_generichash_init(&state, NULL, 0, 32);
    feed_text(&state, last_row_hash);
    feed_rows(&state, raw, "SELECT run_id, rays, epochs, states FROM lasting", 0);
    feed_rows(&state, raw, "SELECT run_id, step, psnr, loss, size_psnr, size_loss FROM lasting_step ORDER BY step", 0);
    feed_rows(&state, raw,
              "SELECT run_id, image_id, from_step, predicted_psnr, measured_psnr, predicted_loss, measured_loss"
              " FROM lasting_check ORDER BY image_id",
              0);
    feed_rows(&state, raw, "SELECT run_id, step, image_id, psnr FROM lasting_view ORDER BY step, image_id", 0);
    return hash_is(&state, raw, "row_hash", OF_SWEEP, rewrite, hash);
}

// Goes along the chain; with `rewrite`, as whoever forges a ledger does, writing every hash.
static inline bool follow_chain(const char *path, bool rewrite) {
    sqlite3 *raw = sql_open(path);
    crypto_generichash_state state;
    char head[VW_HASH_HEX_BYTES];
    crypto_generichash_init(&state, NULL, 0, 32);
    feed_rows(&state, raw,
              "SELECT run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version FROM run", 0);
    feed_rows(&state, raw,
              "SELECT image_id, scene_hash, name, split, provider, sha256, ground_truth FROM image ORDER BY image_id",
              0);
    bool holds = hash_is(&state, raw, "row_hash", OF_RUN, rewrite, head);
    int64_t count = count_steps(raw);
    for (int64_t step = 0; step < count; step++) {
        crypto_generichash_init(&state, NULL, 0, 32);
        feed_text(&state, head);
        feed_rows(&state, raw,
                  "SELECT run_id, step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1, nonfinite, "
                  "clamped, floored"
                  " FROM step WHERE step = ?",
                  step);
        feed_rows(&state, raw, "SELECT run_id, step, image_id, mse, l1 FROM view WHERE step = ? ORDER BY image_id",
                  step);
        holds = hash_is(&state, raw, "row_hash", step, rewrite, head) && holds;
    }
    bool swept = has_sweep(raw);
    if (swept) holds = follow_sweep(raw, head, rewrite) && holds;
    crypto_generichash_init(&state, NULL, 0, 32);
    if (is_running(raw)) feed_rows(&state, raw, "SELECT row_hash FROM run", 0);
    else feed_text(&state, head);
    feed_rows(&state, raw,
              "SELECT scene_path, config_json, scene_options_json, effects_json, plan_json, started_utc, finished_utc, "
              "status, field_sha256 FROM run",
              0);
    feed_rows(&state, raw,
              "SELECT run_id, image_id, method, value, unit, stderr, visits, ci_low, ci_high, "
              "rank_ci_low, rank_ci_high FROM score"
              " ORDER BY rowid",
              0);
    feed_rows(&state, raw,
              "SELECT run_id, retraining, seed, epochs, image_ids, val_psnr FROM retraining"
              " ORDER BY retraining",
              0);
    if (swept) feed_rows(&state, raw, "SELECT run_id, rays, epochs, states, row_hash FROM lasting", 0);
    feed_rows(&state, raw, "SELECT run_id, cents FROM payout_request", 0);
    holds = hash_is(&state, raw, "final_hash", OF_RUN, rewrite, head) && holds;
    sqlite3_close(raw);
    return holds;
}

// Returns whether all hashes of a ledger are those of its rows.
static inline bool chain_holds(const char *path) { return follow_chain(path, false); }
// Computes all of them anew.
static inline void chain_rewrite(const char *path) { assert_true(follow_chain(path, true)); }

#endif
