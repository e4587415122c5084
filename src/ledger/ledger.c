#include "viewworth/ledger.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "ledger/database_file.h"
#include "ledger/ledger_private.h"
#include "ledger/schema.h"

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
