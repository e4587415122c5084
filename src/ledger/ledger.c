#include "viewworth/ledger.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ledger/ledger_private.h"
#include "ledger/schema.h"
#include "viewworth/file.h"
#include "viewworth/memory.h"

static void end_hash(struct vw_hasher *hasher, char hex[VW_HASH_HEX_BYTES]) {
    uint8_t hash[32];
    vw_hasher_end(hasher, hash);
    vw_hash_to_hex(hash, hex);
}

static enum vw_status insert_images(struct vw_database *database, const char *scene_hash, const struct vw_ledger_image *images,
                                    uint32_t image_count, struct vw_hasher *hasher) {
    struct vw_row row = {.hasher = hasher};
    enum vw_status status = vw_database_prepare(
        database, "INSERT INTO image (image_id, scene_hash, name, split, provider, sha256, truth) VALUES (?, ?, ?, ?, ?, ?, ?)",
        &row.statement);
    for (uint32_t i = 0; !status && i < image_count; i++) {
        const struct vw_ledger_image *image = &images[i];
        assert(i == 0 || images[i - 1].image_id < image->image_id); // rows are hashed in key order
        vw_row_add_integer(&row, image->image_id);
        vw_row_add_text(&row, scene_hash);
        vw_row_add_text(&row, image->name);
        vw_row_add_text(&row, image->split);
        vw_row_add_text(&row, image->provider);
        vw_row_add_text(&row, image->sha256);
        vw_row_add_text(&row, image->truth);
        status = vw_row_write(&row, database, "record the images");
    }
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status insert_run(struct vw_database *database, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                 uint32_t image_count) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    struct vw_row row = {.hasher = &hasher};
    enum vw_status status = vw_database_prepare(
        database,
        "INSERT INTO run (run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version, row_hash, scene_path,"
        " config_json, scene_options_json, started_utc, status) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'running')",
        &row.statement);
    if (status) return status;
    vw_row_add_text(&row, run->run_id);
    vw_row_add_text(&row, run->scene_hash);
    vw_row_add_integer(&row, run->seed);
    vw_row_add_text(&row, run->subset_hash);
    vw_row_add_text(&row, run->device);
    vw_row_add_text(&row, run->driver);
    vw_row_add_text(&row, run->shader_hash);
    vw_row_add_text(&row, run->version);
    status = insert_images(database, run->scene_hash, images, image_count, &hasher);
    char row_hash[VW_HASH_HEX_BYTES];
    end_hash(&hasher, row_hash);
    row.hasher = NULL;
    vw_row_add_text(&row, row_hash);
    vw_row_add_text(&row, run->scene_path); // this and the rest are final_hash's to cover
    vw_row_add_text(&row, run->config_json);
    vw_row_add_text(&row, run->scene_options_json);
    vw_row_add_text(&row, run->started_utc);
    if (!status) status = vw_row_write(&row, database, "record the run");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status build_file(const char *path, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                 uint32_t image_count) {
    struct vw_database database;
    enum vw_status status = vw_database_open(path, true, &database);
    if (!status) status = vw_database_begin(&database);
    if (!status) {
        status = vw_schema_create(&database);
        if (!status) status = insert_run(&database, run, images, image_count);
        status = vw_database_end(&database, status);
    }
    vw_database_close(&database);
    return status;
}

enum vw_status vw_ledger_create(const char *path, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                uint32_t image_count, struct vw_ledger **ledger) {
    if (vw_file_exists(path)) return vw_fail(VW_ERROR_USAGE, "%s: holds a run already; choose another --out", path);
    // Built beside its place and moved there whole, so that a ledger that exists has its run and image rows.
    char *temporary = vw_format_text("%s.part-%ld", path, (long)getpid());
    if (!temporary) return VW_ERROR_MEMORY;
    unlink(temporary); // of a run that was killed here and had the same process id
    enum vw_status status = build_file(temporary, run, images, image_count);
    if (!status && rename(temporary, path))
        status = vw_fail(VW_ERROR_IO, "%s: cannot create: %s; check the folder and its permissions", path, strerror(errno));
    if (status) unlink(temporary);
    free(temporary);
    return status ? status : vw_ledger_open(path, ledger);
}

enum vw_status vw_ledger_open(const char *path, struct vw_ledger **ledger) {
    if (!vw_file_exists(path)) return vw_fail(VW_ERROR_INPUT, "%s: no ledger here; make one with viewworth value", path);
    struct vw_ledger *opened = vw_allocate(1, sizeof *opened);
    if (!opened) return VW_ERROR_MEMORY;
    enum vw_status status = vw_database_open(path, false, &opened->database);
    if (!status) status = vw_schema_check(&opened->database);
    if (!status) status = vw_ledger_load(opened);
    if (status) vw_ledger_close(&opened);
    else *ledger = opened;
    return status;
}

void vw_ledger_close(struct vw_ledger **ledger) {
    struct vw_ledger *closed = *ledger;
    if (!closed) return;
    sqlite3_finalize(closed->insert_step);
    sqlite3_finalize(closed->insert_view);
    vw_database_close(&closed->database);
    for (size_t i = 0; i < closed->text_count; i++) free(closed->texts[i]);
    free(closed->texts);
    free(closed->images);
    free(closed);
    *ledger = NULL;
}

static enum vw_status prepare_append(struct vw_ledger *ledger) {
    enum vw_status status = VW_OK;
    if (!ledger->insert_step)
        status = vw_database_prepare(&ledger->database,
                                     "INSERT INTO step (run_id, step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1,"
                                     " nonfinite, clamped, floored, row_hash) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                                     &ledger->insert_step);
    if (!status && !ledger->insert_view)
        status = vw_database_prepare(&ledger->database, "INSERT INTO view (run_id, step, image_id, mse, l1) VALUES (?, ?, ?, ?, ?)",
                                     &ledger->insert_view);
    return status;
}

// A value is flagged when the trainer says so, or when a value that it vouches for is not finite.
static bool is_nonfinite(const struct vw_step_record *record) {
    if (record->nonfinite || !record->validated) return record->nonfinite;
    bool finite = isfinite(record->val_psnr) && isfinite(record->val_psnr_pooled) && isfinite(record->val_l1);
    for (uint32_t i = 0; finite && i < record->view_count; i++) finite = isfinite(record->views[i].mse) && isfinite(record->views[i].l1);
    return !finite;
}

static void add_step_columns(struct vw_row *row, const char *run_id, const struct vw_step_record *record, bool nonfinite) {
    bool valued = record->validated && !nonfinite;
    vw_row_add_text(row, run_id);
    vw_row_add_integer(row, (int64_t)record->step);
    vw_row_add_integer(row, record->epoch);
    if (record->view == VW_RECORD_UNTRAINED) vw_row_add_null(row);
    else vw_row_add_integer(row, record->view);
    vw_row_add_real(row, nonfinite ? NAN : record->train_loss);
    vw_row_add_real(row, valued ? record->val_psnr : NAN);
    vw_row_add_real(row, valued ? record->val_psnr_pooled : NAN);
    vw_row_add_real(row, valued ? record->val_l1 : NAN);
    vw_row_add_integer(row, nonfinite);
    vw_row_add_integer(row, (int64_t)record->clamped_count);
    vw_row_add_integer(row, valued ? record->floored_views : 0);
}

static enum vw_status insert_views(struct vw_ledger *ledger, const struct vw_step_record *record, const uint32_t *validation_views,
                                   struct vw_hasher *hasher) {
    struct vw_row row = {.statement = ledger->insert_view, .hasher = hasher};
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < record->view_count; i++) {
        assert(i == 0 || validation_views[i - 1] < validation_views[i]); // rows are hashed in key order
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, (int64_t)record->step);
        vw_row_add_integer(&row, validation_views[i]);
        vw_row_add_real(&row, record->views[i].mse);
        vw_row_add_real(&row, record->views[i].l1);
        status = vw_row_write(&row, &ledger->database, "record a validation view");
    }
    return status;
}

// Writes one step after `head` in the chain, and moves `head` on to it.
static enum vw_status insert_step(struct vw_ledger *ledger, const struct vw_step_record *record, const uint32_t *validation_views,
                                  char head[VW_HASH_HEX_BYTES]) {
    bool nonfinite = is_nonfinite(record);
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, head);
    struct vw_row row = {.statement = ledger->insert_step, .hasher = &hasher};
    add_step_columns(&row, ledger->run.run_id, record, nonfinite);
    if (record->validated && !nonfinite) {
        enum vw_status status = insert_views(ledger, record, validation_views, &hasher);
        if (status) return status;
    }
    end_hash(&hasher, head);
    row.hasher = NULL;
    vw_row_add_text(&row, head);
    return vw_row_write(&row, &ledger->database, "record a step");
}

// A run that goes on is no longer finished, and its scores are no longer its scores.
static enum vw_status reopen_run(struct vw_ledger *ledger) {
    if (!ledger->finished) return VW_OK;
    return vw_database_run(&ledger->database, "DELETE FROM score;"
                                              "UPDATE run SET finished_utc = NULL, status = 'running', final_hash = NULL;");
}

enum vw_status vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                const uint32_t *validation_views) {
    for (uint32_t i = 0; i < count; i++)
        if (records[i].step != ledger->next_step + i)
            return vw_fail(VW_ERROR_USAGE, "%s: step %" PRIu64 " was offered where step %" PRIu64 " follows; resume from the ledger's end",
                           ledger->database.path, records[i].step, ledger->next_step + i);
    enum vw_status status = prepare_append(ledger);
    if (!status) status = vw_database_begin(&ledger->database);
    if (status) return status;
    char head[VW_HASH_HEX_BYTES];
    memcpy(head, ledger->head, sizeof head);
    status = reopen_run(ledger);
    for (uint32_t i = 0; !status && i < count; i++) status = insert_step(ledger, &records[i], validation_views, head);
    status = vw_database_end(&ledger->database, status);
    if (status) return status; // the ledger, and what this object knows of it, are as before
    memcpy(ledger->head, head, sizeof head);
    ledger->next_step += count;
    ledger->finished = false;
    return VW_OK;
}

static enum vw_status replace_scores(struct vw_ledger *ledger, const struct vw_ledger_score *scores, uint32_t score_count) {
    enum vw_status status = vw_database_run(&ledger->database, "DELETE FROM score");
    if (status) return status;
    struct vw_row row = {0};
    status = vw_database_prepare(&ledger->database,
                                 "INSERT INTO score (run_id, image_id, method, value, unit, stderr, visits) VALUES (?, ?, ?, ?, ?, ?, ?)",
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
        status = vw_row_write(&row, &ledger->database, "record a score");
    }
    sqlite3_finalize(row.statement);
    return status;
}

// Hashes the score rows in key order, whatever the order they came in.
static enum vw_status hash_scores(struct vw_ledger *ledger, struct vw_hasher *hasher) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT run_id, image_id, method, value, unit, stderr, visits FROM score ORDER BY run_id, image_id, method",
        &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) vw_row_hash(statement, hasher);
    sqlite3_finalize(statement);
    return status;
}

static enum vw_status update_run(struct vw_ledger *ledger, const char *run_status, const char *finished_utc) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, ledger->head);
    vw_hasher_add_text(&hasher, ledger->run.scene_path);
    vw_hasher_add_text(&hasher, ledger->run.config_json);
    vw_hasher_add_text(&hasher, ledger->run.scene_options_json);
    vw_hasher_add_text(&hasher, ledger->run.started_utc);
    struct vw_row row = {.hasher = &hasher};
    enum vw_status status =
        vw_database_prepare(&ledger->database, "UPDATE run SET finished_utc = ?, status = ?, final_hash = ?", &row.statement);
    if (status) return status;
    vw_row_add_text(&row, finished_utc);
    vw_row_add_text(&row, run_status);
    status = hash_scores(ledger, &hasher);
    char final_hash[VW_HASH_HEX_BYTES];
    end_hash(&hasher, final_hash);
    row.hasher = NULL;
    vw_row_add_text(&row, final_hash);
    if (!status) status = vw_row_write(&row, &ledger->database, "record the end of the run");
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count) {
    enum vw_status result = vw_database_begin(&ledger->database);
    if (result) return result;
    result = replace_scores(ledger, scores, score_count);
    if (!result) result = update_run(ledger, status, finished_utc);
    result = vw_database_end(&ledger->database, result);
    if (!result) ledger->finished = true;
    return result;
}
