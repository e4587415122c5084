#include "ledger/retraining.h"

#include <inttypes.h>
#include <stdlib.h>

#include "base/memory.h"
#include "ledger/table.h"

// In a series of its own: see vw_database_format.
enum { RETRAININGS_VERSION = 1002 };

static const char schema_sql[] =
    "CREATE TABLE retraining ("
    " retraining_id TEXT PRIMARY KEY NOT NULL, scene_hash TEXT NOT NULL, views TEXT NOT NULL,"
    " view_count INTEGER NOT NULL, seed INTEGER NOT NULL, epochs INTEGER NOT NULL, val_psnr REAL, val_ssim REAL,"
    " val_l1 REAL, test_psnr REAL, test_ssim REAL, test_l1 REAL, seconds REAL, row_hash TEXT NOT NULL);"
    "CREATE TABLE view ("
    " retraining_id TEXT NOT NULL, image_id INTEGER NOT NULL, psnr REAL, row_hash TEXT NOT NULL,"
    " PRIMARY KEY (retraining_id, image_id));"
    "PRAGMA user_version = 1002;";
_Static_assert(RETRAININGS_VERSION == 1002, "write it into schema_sql, too");

static const struct vw_database_format format = {
    .schema_sql = schema_sql, .version = RETRAININGS_VERSION, .what = "the retrainings of a benchmark or comparison"};

struct vw_retraining_store {
    struct vw_database database;
};

const char *vw_equal_name(enum vw_equal equal) { return equal == VW_EQUAL_STEPS ? "steps" : "epochs"; }

static enum vw_status open_store(const char *path, enum vw_database_access access,
                                 struct vw_retraining_store **retrainings) {
    struct vw_retraining_store *opened = vw_allocate(1, sizeof *opened);
    if (!opened) return VW_ERROR_MEMORY;
    struct vw_database *database = &opened->database;
    enum vw_status status = !path                        ? vw_database_open_memory("retrainings", &format, database)
                            : access == VW_DATABASE_READ ? vw_database_open(path, &format, access, database)
                                                         : vw_database_open_or_create(path, &format, database);
    if (status) vw_retraining_store_close(&opened);
    else *retrainings = opened;
    return status;
}

enum vw_status vw_retraining_store_open(const char *path, struct vw_retraining_store **retrainings) {
    return open_store(path, VW_DATABASE_APPEND, retrainings);
}

enum vw_status vw_retraining_store_open_to_read(const char *path, struct vw_retraining_store **retrainings) {
    return open_store(path, VW_DATABASE_READ, retrainings);
}

void vw_retraining_store_close(struct vw_retraining_store **retrainings) {
    if (!*retrainings) return;
    vw_database_close(&(*retrainings)->database);
    free(*retrainings);
    *retrainings = NULL;
}

// ---- Retrainings ---------------------------------------------------------------------------------------------------

struct retraining_row {
    const char *scene_hash, *views;
    uint32_t view_count, epochs;
    uint64_t seed;
    struct vw_retrain_result result;
};
static const struct vw_column retraining_columns[] = {
    VW_COLUMN_OF_OWNER("retraining_id"),
    VW_COLUMN(struct retraining_row, TEXT, scene_hash),
    VW_COLUMN(struct retraining_row, TEXT, views),
    VW_COLUMN(struct retraining_row, COUNT, view_count),
    VW_COLUMN(struct retraining_row, COUNT64, seed),
    VW_COLUMN(struct retraining_row, COUNT, epochs),
    VW_COLUMN_AS("val_psnr", struct retraining_row, REAL_OR_NULL, result.val_psnr),
    VW_COLUMN_AS("val_ssim", struct retraining_row, REAL_OR_NULL, result.val_ssim),
    VW_COLUMN_AS("val_l1", struct retraining_row, REAL_OR_NULL, result.val_l1),
    VW_COLUMN_AS("test_psnr", struct retraining_row, REAL_OR_NULL, result.test_psnr),
    VW_COLUMN_AS("test_ssim", struct retraining_row, REAL_OR_NULL, result.test_ssim),
    VW_COLUMN_AS("test_l1", struct retraining_row, REAL_OR_NULL, result.test_l1),
    VW_COLUMN_AS("seconds", struct retraining_row, REAL_OR_NULL, result.seconds),
};
static const struct vw_table retraining_table = {VW_TABLE("retraining", struct retraining_row, retraining_columns),
                                                 .doing = "record a retraining",
                                                 .has_hash = true,
                                                 .hashed_as = "viewworth retraining row 2",
                                                 .key_count = 1,
                                                 .insert = "INSERT OR IGNORE"};

static const struct vw_column view_columns[] = {
    VW_COLUMN_OF_OWNER("retraining_id"),
    VW_COLUMN(struct vw_retrain_view, COUNT, image_id),
    VW_COLUMN_AS("psnr", struct vw_retrain_view, REAL_OR_NULL, psnr_db),
};
static const struct vw_table view_table = {VW_TABLE("view", struct vw_retrain_view, view_columns),
                                           .doing = "record a photo of a retraining",
                                           .has_hash = true,
                                           .hashed_as = "viewworth retraining view row 1",
                                           .key_count = 2,
                                           .insert = "INSERT OR REPLACE"};

enum vw_status vw_retraining_store_find(struct vw_retraining_store *retrainings, const char *retraining_id, bool *found,
                                        struct vw_retrain_result *result) {
    struct retraining_row row = {0};
    enum vw_found there = VW_ROW_ABSENT;
    enum vw_status status = vw_table_find(&retrainings->database, &retraining_table, retraining_id, &row, &there);
    if (status) return status;
    if (there == VW_ROW_EDITED)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: retraining %s was edited: its row_hash does not match; delete the row to train it again",
                       retrainings->database.path, retraining_id);
    *found = there == VW_ROW_FOUND;
    if (*found) *result = row.result;
    return VW_OK;
}

static enum vw_status fail_at_view(const struct vw_database *database, const char *retraining_id,
                                   const struct vw_retrain_view *view, const char *why) {
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: retraining %s: its row of photo %" PRIu32
                   " in table view %s; delete the retraining's rows to train it again",
                   database->path, retraining_id, view->image_id, why);
}

// Ends at the first view that is missing; `*found` is how many come before it.
static enum vw_status find_views(struct vw_retraining_store *retrainings, const char *retraining_id,
                                 struct vw_retrain_view *views, uint32_t view_count, uint32_t *found) {
    struct vw_database *database = &retrainings->database;
    enum vw_found there = VW_ROW_FOUND;
    enum vw_status status = VW_OK;
    for (*found = 0; *found < view_count; (*found)++) {
        status = vw_table_find(database, &view_table, retraining_id, &views[*found], &there);
        if (!status && there == VW_ROW_EDITED)
            status = fail_at_view(database, retraining_id, &views[*found], "was edited: its row_hash does not match");
        if (status || there == VW_ROW_ABSENT) return status;
    }
    return VW_OK;
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

enum vw_status vw_retraining_store_add(struct vw_retraining_store *retrainings, const char *retraining_id,
                                       const char *scene_hash, const struct vw_retrain_params *retraining,
                                       const struct vw_retrain_result *result, const struct vw_retrain_view *views,
                                       uint32_t view_count) {
    struct vw_database *database = &retrainings->database;
    char *list = vw_table_list_ids(retraining->views, retraining->view_count);
    if (!list) return VW_ERROR_MEMORY;
    const struct retraining_row row = {.scene_hash = scene_hash,
                                       .views = list,
                                       .view_count = retraining->view_count,
                                       .seed = retraining->seed,
                                       .epochs = retraining->epochs,
                                       .result = *result};
    enum vw_status status = vw_database_begin(database);
    if (!status) {
        status = vw_table_insert(database, &retraining_table, retraining_id, &row, 1, NULL);
        if (!status) status = vw_table_insert(database, &view_table, retraining_id, views, view_count, NULL);
        status = vw_database_end(database, status);
    }
    free(list);
    return status;
}
