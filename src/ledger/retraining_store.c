#include "ledger/retraining_store.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "ledger/database_open.h"

// In a series of its own: see vw_database_format.
enum { RETRAININGS_VERSION = 1001 };

static const char schema_sql[] =
    "CREATE TABLE retraining ("
    " retraining_id TEXT PRIMARY KEY NOT NULL, scene_hash TEXT NOT NULL, views TEXT NOT NULL,"
    " view_count INTEGER NOT NULL, seed INTEGER NOT NULL, epochs INTEGER NOT NULL, val_psnr REAL, val_ssim REAL,"
    " val_l1 REAL, test_psnr REAL, test_ssim REAL, test_l1 REAL, seconds REAL, row_hash TEXT NOT NULL);"
    "CREATE TABLE view ("
    " retraining_id TEXT NOT NULL, image_id INTEGER NOT NULL, psnr REAL, row_hash TEXT NOT NULL,"
    " PRIMARY KEY (retraining_id, image_id));"
    "CREATE TABLE metric ("
    " scene_hash TEXT NOT NULL, config_hash TEXT NOT NULL, place INTEGER NOT NULL, metric TEXT NOT NULL,"
    " method TEXT NOT NULL, value REAL, ci_low REAL, ci_high REAL, count INTEGER NOT NULL, PRIMARY KEY (scene_hash, "
    "config_hash, place));"
    "PRAGMA user_version = 1001;";
_Static_assert(RETRAININGS_VERSION == 1001, "write it into schema_sql, too");

static const struct vw_database_format format = {
    .schema_sql = schema_sql, .version = RETRAININGS_VERSION, .what = "the retrainings of a benchmark or comparison"};

struct vw_retraining_store {
    struct vw_database database;
};

const char *vw_equal_name(enum vw_equal equal) { return equal == VW_EQUAL_STEPS ? "steps" : "epochs"; }

enum vw_status vw_retraining_store_open(const char *path, struct vw_retraining_store **retrainings) {
    struct vw_retraining_store *opened = vw_allocate(1, sizeof *opened);
    if (!opened) return VW_ERROR_MEMORY;
    enum vw_status status = vw_database_open_or_create(path, &format, &opened->database);
    if (status) vw_retraining_store_close(&opened);
    else *retrainings = opened;
    return status;
}

void vw_retraining_store_close(struct vw_retraining_store **retrainings) {
    if (!*retrainings) return;
    vw_database_close(&(*retrainings)->database);
    free(*retrainings);
    *retrainings = NULL;
}

// In this order they are hashed.
#define RETRAINING_COLUMNS                                                                                             \
    "retraining_id, scene_hash, views, view_count, seed, epochs, val_psnr, val_ssim, val_l1, test_psnr, test_ssim, "   \
    "test_l1, seconds"
enum { VAL_PSNR = 6, ROW_HASH = 13 };

static const char hashed_as[] = "viewworth retraining row 2";

enum vw_status vw_retraining_store_find(struct vw_retraining_store *retrainings, const char *retraining_id, bool *found,
                                        struct vw_retrain_result *result) {
    struct vw_database *database = &retrainings->database;
    sqlite3_stmt *statement = NULL;
    bool there = false;
    enum vw_status status = vw_database_prepare(
        database, "SELECT " RETRAINING_COLUMNS ", row_hash FROM retraining WHERE retraining_id = ?", &statement);
    if (!status && sqlite3_bind_text(statement, 1, retraining_id, -1, SQLITE_STATIC) != SQLITE_OK)
        status = vw_database_fail(database, "find a retraining");
    if (!status) status = vw_database_next(database, statement, &there);
    if (!status && there && !vw_row_fits_hash(statement, ROW_HASH, hashed_as))
        status = vw_fail(VW_ERROR_MISMATCH,
                         "%s: retraining %s was edited: its row_hash does not match; delete the row to train it again",
                         database->path, retraining_id);
    if (!status) *found = there;
    if (!status && there)
        *result = (struct vw_retrain_result){.val_psnr = vw_row_read_real(statement, VAL_PSNR),
                                             .val_ssim = vw_row_read_real(statement, VAL_PSNR + 1),
                                             .val_l1 = vw_row_read_real(statement, VAL_PSNR + 2),
                                             .test_psnr = vw_row_read_real(statement, VAL_PSNR + 3),
                                             .test_ssim = vw_row_read_real(statement, VAL_PSNR + 4),
                                             .test_l1 = vw_row_read_real(statement, VAL_PSNR + 5),
                                             .seconds = vw_row_read_real(statement, VAL_PSNR + 6)};
    sqlite3_finalize(statement);
    return status;
}

// In this order they are hashed.
#define VIEW_COLUMNS "retraining_id, image_id, psnr"
enum { PSNR = 2, VIEW_HASH = 3 };

static const char view_hashed_as[] = "viewworth retraining view row 1";

static enum vw_status fail_at_view(const struct vw_database *database, const char *retraining_id,
                                   const struct vw_retrain_view *view, const char *why) {
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: retraining %s: its row of photo %" PRIu32
                   " in table view %s; delete the retraining's rows to train it again",
                   database->path, retraining_id, view->image_id, why);
}

static enum vw_status find_view(struct vw_database *database, sqlite3_stmt *statement, const char *retraining_id,
                                struct vw_retrain_view *view, bool *found) {
    bool there = false;
    sqlite3_reset(statement);
    if (sqlite3_bind_text(statement, 1, retraining_id, -1, SQLITE_STATIC) != SQLITE_OK ||
        sqlite3_bind_int64(statement, 2, view->image_id) != SQLITE_OK)
        return vw_database_fail(database, "find a photo of a retraining");
    enum vw_status status = vw_database_next(database, statement, &there);
    if (status) return status;
    if (there && !vw_row_fits_hash(statement, VIEW_HASH, view_hashed_as))
        return fail_at_view(database, retraining_id, view, "was edited: its row_hash does not match");
    if (there) view->psnr_db = vw_row_read_real(statement, PSNR);
    *found = there;
    return VW_OK;
}

// Ends at the first view that is missing; `*found` is how many come before it.
static enum vw_status find_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                 struct vw_retrain_view *views, uint32_t view_count, uint32_t *found) {
    sqlite3_stmt *statement = NULL;
    bool there = true;
    enum vw_status status = vw_database_prepare(
        &retrainings->database, "SELECT " VIEW_COLUMNS ", row_hash FROM view WHERE retraining_id = ? AND image_id = ?",
        &statement);
    for (*found = 0; !status && there && *found < view_count; *found += there)
        status = find_view(&retrainings->database, statement, retraining_id, &views[*found], &there);
    sqlite3_finalize(statement);
    return status;
}

enum vw_status vw_retraining_store_find_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                              struct vw_retrain_view *views, uint32_t view_count) {
    uint32_t found = 0;
    enum vw_status status = find_views(retrainings, retraining_id, views, view_count, &found);
    return !status && found < view_count
               ? fail_at_view(&retrainings->database, retraining_id, &views[found], "is missing")
               : status;
}

enum vw_status vw_retraining_store_recall_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                                struct vw_retrain_view *views, uint32_t view_count, bool *found) {
    uint32_t there = 0;
    enum vw_status status = find_views(retrainings, retraining_id, views, view_count, &there);
    if (!status) *found = there == view_count;
    return status;
}

static enum vw_status add_views(struct vw_database *database, const char *retraining_id,
                                const struct vw_retrain_view *views, uint32_t view_count) {
    struct vw_hasher hasher;
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        database, "INSERT OR REPLACE INTO view (" VIEW_COLUMNS ", row_hash) VALUES (?, ?, ?, ?)", &row.statement);
    for (uint32_t i = 0; !status && i < view_count; i++) {
        char hash[VW_HASH_HEX_BYTES];
        row.hasher = &hasher;
        vw_row_begin_hash(&hasher, view_hashed_as);
        vw_row_add_text(&row, retraining_id);
        vw_row_add_integer(&row, views[i].image_id);
        vw_row_add_real(&row, views[i].psnr_db);
        vw_row_end_hash(&hasher, hash);
        row.hasher = NULL;
        vw_row_add_text(&row, hash);
        status = vw_row_write(&row, database, "record a photo of a retraining");
    }
    sqlite3_finalize(row.statement);
    return status;
}

static char *list_views(const struct vw_retrain_params *retraining) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream list;
    FILE *stream = vw_text_stream_open(&list);
    for (uint32_t i = 0; stream && i < retraining->view_count; i++)
        fprintf(stream, "%s%" PRIu32, i ? " " : "", retraining->views[i]);
    return vw_text_stream_close(&list, "photos of a retraining", &text, &size_bytes) ? NULL : text;
}

enum vw_status vw_retraining_store_add(struct vw_retraining_store *retrainings, const char *retraining_id,
                                       const char *scene_hash, const struct vw_retrain_params *retraining,
                                       const struct vw_retrain_result *result, const struct vw_retrain_view *views,
                                       uint32_t view_count) {
    struct vw_database *database = &retrainings->database;
    struct vw_hasher hasher;
    struct vw_row row = {.hasher = &hasher};
    char hash[VW_HASH_HEX_BYTES];
    char *list = list_views(retraining);
    if (!list) return VW_ERROR_MEMORY;
    enum vw_status status = vw_database_begin(database);
    if (status) goto done;
    status = vw_database_prepare(database,
                                 "INSERT INTO retraining (" RETRAINING_COLUMNS
                                 ", row_hash) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
                                 " ON CONFLICT DO NOTHING",
                                 &row.statement);
    vw_row_begin_hash(&hasher, hashed_as);
    vw_row_add_text(&row, retraining_id);
    vw_row_add_text(&row, scene_hash);
    vw_row_add_text(&row, list);
    vw_row_add_integer(&row, retraining->view_count);
    vw_row_add_integer(&row, (int64_t)retraining->seed);
    vw_row_add_integer(&row, retraining->epochs);
    vw_row_add_real(&row, result->val_psnr);
    vw_row_add_real(&row, result->val_ssim);
    vw_row_add_real(&row, result->val_l1);
    vw_row_add_real(&row, result->test_psnr);
    vw_row_add_real(&row, result->test_ssim);
    vw_row_add_real(&row, result->test_l1);
    vw_row_add_real(&row, result->seconds);
    vw_row_end_hash(&hasher, hash);
    row.hasher = NULL;
    vw_row_add_text(&row, hash);
    if (!status) status = vw_row_write(&row, database, "record a retraining");
    sqlite3_finalize(row.statement);
    if (!status) status = add_views(database, retraining_id, views, view_count);
    status = vw_database_end(database, status);
done:
    free(list);
    return status;
}

static enum vw_status remove_metrics(struct vw_database *database, const char *scene_hash, const char *config_hash) {
    struct vw_row row = {0};
    enum vw_status status =
        vw_database_prepare(database, "DELETE FROM metric WHERE scene_hash = ? AND config_hash = ?", &row.statement);
    vw_row_add_text(&row, scene_hash);
    vw_row_add_text(&row, config_hash);
    if (!status) status = vw_row_write(&row, database, "remove old metrics");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status insert_metrics(struct vw_database *database, const char *scene_hash, const char *config_hash,
                                     const struct vw_metric *metrics, uint32_t count) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        database,
        "INSERT INTO metric (scene_hash, config_hash, place, metric, method, value, ci_low, ci_high, count)"
        " VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
        &row.statement);
    for (uint32_t i = 0; !status && i < count; i++) {
        vw_row_add_text(&row, scene_hash);
        vw_row_add_text(&row, config_hash);
        vw_row_add_integer(&row, i);
        vw_row_add_text(&row, metrics[i].metric);
        vw_row_add_text(&row, metrics[i].method);
        vw_row_add_real(&row, metrics[i].value);
        vw_row_add_real(&row, metrics[i].ci_low);
        vw_row_add_real(&row, metrics[i].ci_high);
        vw_row_add_integer(&row, metrics[i].count);
        status = vw_row_write(&row, database, "record a metric");
    }
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_retraining_store_set_metrics(struct vw_retraining_store *retrainings, const char *scene_hash,
                                               const char *config_hash, const struct vw_metric *metrics,
                                               uint32_t count) {
    struct vw_database *database = &retrainings->database;
    enum vw_status status = vw_database_begin(database);
    if (status) return status;
    status = remove_metrics(database, scene_hash, config_hash);
    if (!status) status = insert_metrics(database, scene_hash, config_hash, metrics, count);
    return vw_database_end(database, status);
}
