#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "ledger/database_file.h"
#include "ledger/ledger_private.h"
#include "ledger/schema.h"
#include "viewworth/ledger.h"

// Inserts the row of the run with empty hashes. The hashes cover this row, so they are computed after it is written.
static enum vw_status insert_run(struct vw_database *database, const struct vw_ledger_run *run) {
    struct vw_sealed_run row = {.run = *run, .row_hash = "", .final_hash = ""};
    if (!run->plan_json) row.run.plan_json = "{}";
    row.run.status = VW_LEDGER_RUNNING;
    row.run.finished_utc = row.run.field_sha256 = NULL;
    return vw_table_insert(database, &vw_run_table, NULL, &row, 1, NULL);
}

static enum vw_status write_first_rows(struct vw_database *database, const struct vw_ledger_run *run,
                                       const struct vw_ledger_image *images, uint32_t image_count) {
    char run_hash[VW_HASH_HEX_BYTES], final_hash[VW_HASH_HEX_BYTES];
    enum vw_status status = insert_run(database, run);
    if (!status) status = vw_table_insert(database, &vw_image_table, run->scene_hash, images, image_count, NULL);
    if (!status) status = vw_ledger_write_run_hash(database, run_hash);
    if (!status) status = vw_ledger_write_final_hash(database, run_hash, run_hash, final_hash);
    return status;
}

// Builds the ledger in memory and then writes the file, so that every existing ledger has its run and image rows, and
// no temporary file is needed.
static enum vw_status build_file(const char *path, const struct vw_ledger_run *run,
                                 const struct vw_ledger_image *images, uint32_t image_count) {
    struct vw_database database;
    enum vw_status status = vw_database_open_memory(path, &vw_ledger_format, &database);
    if (!status) status = vw_database_begin(&database);
    if (!status) status = vw_database_end(&database, write_first_rows(&database, run, images, image_count));
    if (!status) status = vw_database_create_file(&database);
    vw_database_close(&database);
    return status;
}

enum vw_status vw_ledger_create(const char *path, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                uint32_t image_count, struct vw_ledger **ledger) {
    if (vw_file_exists(path)) return vw_fail(VW_ERROR_USAGE, "%s: already contains a run; name another folder", path);
    enum vw_status status = build_file(path, run, images, image_count);
    return status ? status : vw_ledger_open_to_append(path, ledger);
}

static enum vw_status open_ledger(const char *path, enum vw_database_access access, struct vw_ledger **ledger) {
    if (!vw_file_exists(path))
        return vw_fail(VW_ERROR_INPUT, "%s: no ledger here; make one with viewworth value", path);
    struct vw_ledger *opened = vw_allocate(1, sizeof *opened);
    if (!opened) return VW_ERROR_MEMORY;
    enum vw_status status = vw_database_open(path, &vw_ledger_format, access, &opened->database);
    if (!status) status = vw_ledger_load(opened);
    if (status) vw_ledger_close(&opened);
    else *ledger = opened;
    return status;
}

enum vw_status vw_ledger_open(const char *path, struct vw_ledger **ledger) {
    return open_ledger(path, VW_DATABASE_READ, ledger);
}

enum vw_status vw_ledger_open_to_append(const char *path, struct vw_ledger **ledger) {
    struct vw_ledger *opened = NULL;
    enum vw_status status = open_ledger(path, VW_DATABASE_APPEND, &opened);
    if (!status) status = vw_ledger_verify(opened); // a new hash would vouch for what was edited
    if (status == VW_ERROR_MISMATCH && opened)
        status = vw_fail(status, "%s; nothing is written to it: restore the file from a copy", vw_error_message());
    if (status) vw_ledger_close(&opened);
    else *ledger = opened;
    return status;
}

void vw_ledger_close(struct vw_ledger **ledger) {
    struct vw_ledger *closed = *ledger;
    if (!closed) return;
    vw_insertion_end(&closed->inserts.step);
    vw_insertion_end(&closed->inserts.view);
    vw_database_close(&closed->database);
    for (size_t i = 0; i < closed->text_count; i++) free(closed->texts[i]);
    free(closed->texts);
    free(closed->images);
    free(closed);
    *ledger = NULL;
}

uint64_t vw_ledger_next_step(const struct vw_ledger *ledger) { return ledger->next_step; }

void vw_ledger_chain_head(const struct vw_ledger *ledger, char head[VW_HASH_HEX_BYTES]) {
    memcpy(head, vw_ledger_has_ended(ledger) ? ledger->final_hash : ledger->head, VW_HASH_HEX_BYTES);
}

bool vw_ledger_has_ended(const struct vw_ledger *ledger) { return strcmp(ledger->run.status, VW_LEDGER_RUNNING) != 0; }

bool vw_ledger_has_finished(const struct vw_ledger *ledger) {
    return strcmp(ledger->run.status, VW_LEDGER_FINISHED) == 0;
}

struct vw_ledger_state vw_ledger_state_with(const struct vw_ledger *ledger, const struct vw_ledger_score *scores,
                                            uint32_t score_count) {
    return (struct vw_ledger_state){.status = ledger->run.status,
                                    .finished_utc = ledger->run.finished_utc,
                                    .field_sha256 = ledger->run.field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
}

// ---- Writing -------------------------------------------------------------------------------------------------------

static enum vw_status update_run(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        &ledger->database, "UPDATE run SET config_json = ?, finished_utc = ?, status = ?, field_sha256 = ?",
        &row.statement);
    if (status) return status;
    vw_row_add_text(&row, ledger->extended_config_json ? ledger->extended_config_json : ledger->run.config_json);
    vw_row_add_text(&row, state->finished_utc);
    vw_row_add_text(&row, state->status);
    vw_row_add_text(&row, state->field_sha256);
    status = vw_row_write(&row, &ledger->database, "record the state of the run");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_state(struct vw_ledger *ledger, struct vw_ledger_state *state) {
    struct vw_database *database = &ledger->database;
    enum vw_status status = vw_database_run(database, "DELETE FROM score");
    if (!status)
        status =
            vw_table_insert(database, &vw_score_table, ledger->run.run_id, state->scores, state->score_count, NULL);
    // A run that continues loses its retrainings: they trained for as many steps as the run had until now.
    if (!status && strcmp(state->status, VW_LEDGER_RUNNING) == 0)
        status = vw_database_run(database, "DELETE FROM retraining; DELETE FROM payout_request;");
    if (!status) status = update_run(ledger, state);
    return status ? status : vw_ledger_write_final_hash(database, ledger->run_hash, ledger->head, state->final_hash);
}

static void take_state(struct vw_ledger *ledger, const struct vw_ledger_state *state) {
    ledger->run.status = state->status;
    ledger->run.finished_utc = state->finished_utc;
    ledger->run.field_sha256 = state->field_sha256;
    ledger->new_field_sha256 = NULL;
    if (ledger->extended_config_json) ledger->run.config_json = ledger->extended_config_json;
    ledger->extended_config_json = NULL;
    memcpy(ledger->final_hash, state->final_hash, sizeof ledger->final_hash);
}

static enum vw_status check_current(struct vw_ledger *ledger) {
    char final_hash[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    struct vw_database *database = &ledger->database;
    enum vw_status status = vw_database_read_hash(database, "SELECT final_hash FROM run", final_hash);
    if (!status)
        status =
            vw_database_read_hash(database, "SELECT row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", head);
    if (status) return status;
    if (strcmp(final_hash, ledger->final_hash) == 0 && strcmp(head, ledger->next_step ? ledger->head : "") == 0)
        return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: another process has written to it; use each folder for one run at a time, then --resume",
                   database->path);
}

enum vw_status vw_ledger_change(struct vw_ledger *ledger, struct vw_ledger_state *state, vw_ledger_writer *write,
                                void *context) {
    enum vw_status status = vw_database_begin(&ledger->database);
    if (status) return status;
    status = check_current(ledger);
    if (!status && write) status = write(ledger, context);
    if (!status && state) status = write_state(ledger, state);
    status = vw_database_end(&ledger->database, status);
    if (!status && state) take_state(ledger, state);
    return status;
}

// ---- How a run ends ------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_ledger_state state = {.status = vw_ledger_keep_text(ledger, status),
                                    .finished_utc = vw_ledger_keep_text(ledger, finished_utc),
                                    .field_sha256 = ledger->new_field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
    if (!state.status || !state.finished_utc) return VW_ERROR_MEMORY;
    return vw_ledger_change(ledger, &state, NULL, NULL);
}

enum vw_status vw_ledger_set_field(struct vw_ledger *ledger, const char *sha256) {
    const char *kept = vw_ledger_keep_text(ledger, sha256);
    if (!kept) return VW_ERROR_MEMORY;
    ledger->new_field_sha256 = kept;
    return VW_OK;
}

enum vw_status vw_ledger_extend(struct vw_ledger *ledger, const char *config_json) {
    const char *kept = vw_ledger_keep_text(ledger, config_json);
    if (!kept) return VW_ERROR_MEMORY;
    ledger->extended_config_json = strcmp(kept, ledger->run.config_json) == 0 ? NULL : kept;
    return VW_OK;
}
