#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "ledger/ledger_private.h"
#include "viewworth/memory.h"

// A copy of a text column that lives as long as the ledger, NULL for a NULL column. When memory is short `*status` says so.
static const char *keep_text(struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    if (*status || sqlite3_column_type(statement, column) == SQLITE_NULL) return NULL;
    const char *text = (const char *)sqlite3_column_text(statement, column);
    *status = vw_grow((void **)&ledger->texts, &ledger->text_capacity, ledger->text_count + 1, sizeof *ledger->texts);
    char *kept = *status || !text ? NULL : vw_copy_text(text);
    if (kept) ledger->texts[ledger->text_count++] = kept;
    else if (!*status) *status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory", ledger->database.path);
    return kept;
}

// No row, or a second one, means that this is not the ledger of one run.
static enum vw_status load_run(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database,
        "SELECT run_id, scene_hash, scene_path, seed, config_json, subset_hash, device, driver, shader_hash, version, started_utc,"
        " scene_options_json, row_hash, final_hash IS NOT NULL FROM run",
        &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && !found) status = vw_fail(VW_ERROR_INPUT, "%s: has no run; check the path", ledger->database.path);
    if (!status) {
        ledger->run = (struct vw_ledger_run){
            .run_id = keep_text(ledger, statement, 0, &status),
            .scene_hash = keep_text(ledger, statement, 1, &status),
            .scene_path = keep_text(ledger, statement, 2, &status),
            .seed = sqlite3_column_int64(statement, 3),
            .config_json = keep_text(ledger, statement, 4, &status),
            .subset_hash = keep_text(ledger, statement, 5, &status),
            .device = keep_text(ledger, statement, 6, &status),
            .driver = keep_text(ledger, statement, 7, &status),
            .shader_hash = keep_text(ledger, statement, 8, &status),
            .version = keep_text(ledger, statement, 9, &status),
            .started_utc = keep_text(ledger, statement, 10, &status),
            .scene_options_json = keep_text(ledger, statement, 11, &status),
        };
        snprintf(ledger->head, sizeof ledger->head, "%s", (const char *)sqlite3_column_text(statement, 12));
        ledger->finished = sqlite3_column_int(statement, 13);
    }
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) status = vw_fail(VW_ERROR_INPUT, "%s: has more than one run; use the ledger of one run", ledger->database.path);
    sqlite3_finalize(statement);
    return status;
}

static enum vw_status load_last_step(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status =
        vw_database_prepare(&ledger->database, "SELECT step, row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) {
        ledger->next_step = (uint64_t)sqlite3_column_int64(statement, 0) + 1;
        snprintf(ledger->head, sizeof ledger->head, "%s", (const char *)sqlite3_column_text(statement, 1));
    }
    sqlite3_finalize(statement);
    return status;
}

enum vw_status vw_ledger_load(struct vw_ledger *ledger) {
    enum vw_status status = load_run(ledger);
    return status ? status : load_last_step(ledger);
}

enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run) {
    *run = ledger->run;
    return VW_OK;
}

static enum vw_status load_images(struct vw_ledger *ledger, struct vw_ledger_image **images, uint32_t *count) {
    sqlite3_stmt *statement = NULL;
    size_t capacity = 0;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT image_id, name, split, provider, sha256, truth FROM image ORDER BY scene_hash, image_id", &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        status = vw_grow((void **)images, &capacity, (size_t)*count + 1, sizeof **images);
        if (status) break;
        (*images)[(*count)++] = (struct vw_ledger_image){
            .image_id = (uint32_t)sqlite3_column_int64(statement, 0),
            .name = keep_text(ledger, statement, 1, &status),
            .split = keep_text(ledger, statement, 2, &status),
            .provider = keep_text(ledger, statement, 3, &status),
            .sha256 = keep_text(ledger, statement, 4, &status),
            .truth = keep_text(ledger, statement, 5, &status),
        };
    }
    sqlite3_finalize(statement);
    return status;
}

enum vw_status vw_ledger_get_images(struct vw_ledger *ledger, const struct vw_ledger_image **images, uint32_t *count) {
    if (!ledger->images) {
        struct vw_ledger_image *loaded = NULL;
        uint32_t loaded_count = 0;
        enum vw_status status = load_images(ledger, &loaded, &loaded_count);
        if (status) {
            free(loaded);
            return status;
        }
        ledger->images = loaded;
        ledger->image_count = loaded_count;
    }
    *images = ledger->images;
    *count = ledger->image_count;
    return VW_OK;
}

static double real_or_nan(sqlite3_stmt *statement, int column) {
    return sqlite3_column_type(statement, column) == SQLITE_NULL ? NAN : sqlite3_column_double(statement, column);
}

static struct vw_step_record read_step(sqlite3_stmt *statement) {
    bool untrained = sqlite3_column_type(statement, 2) == SQLITE_NULL;
    return (struct vw_step_record){
        .step = (uint64_t)sqlite3_column_int64(statement, 0),
        .epoch = (uint32_t)sqlite3_column_int64(statement, 1),
        .view = untrained ? (uint32_t)VW_RECORD_UNTRAINED : (uint32_t)sqlite3_column_int64(statement, 2),
        .train_loss = real_or_nan(statement, 3),
        .validated = sqlite3_column_type(statement, 4) != SQLITE_NULL,
        .val_psnr = real_or_nan(statement, 4),
        .val_psnr_pooled = real_or_nan(statement, 5),
        .val_l1 = real_or_nan(statement, 6),
        .nonfinite = sqlite3_column_int(statement, 7),
        .clamped_count = (uint64_t)sqlite3_column_int64(statement, 8),
        .floored_views = (uint32_t)sqlite3_column_int64(statement, 9),
    };
}

enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count) {
    sqlite3_stmt *statement = NULL;
    struct vw_step_record *read = NULL;
    size_t capacity = 0, used = 0;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database,
        "SELECT step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1, nonfinite, clamped, floored FROM step"
        " ORDER BY run_id, step",
        &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        status = vw_grow((void **)&read, &capacity, used + 1, sizeof *read);
        if (!status) read[used++] = read_step(statement);
    }
    sqlite3_finalize(statement);
    if (status) {
        free(read);
        return status;
    }
    *records = read;
    *count = used;
    return VW_OK;
}
