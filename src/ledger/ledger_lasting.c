#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "ledger/ledger_private.h"

// ---- Its tables ----------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_remove_lasting(struct vw_database *database) {
    return vw_database_run(database, "DELETE FROM lasting_view; DELETE FROM lasting_check;"
                                     "DELETE FROM lasting_step; DELETE FROM lasting;");
}

// ---- Its hash ------------------------------------------------------------------------------------------------------

static enum vw_status hash_pass(struct vw_database *database, const char *head, char hash[VW_HASH_HEX_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, head);
    enum vw_status status =
        vw_ledger_hash_rows(database, "SELECT run_id, rays, epochs, states FROM lasting ORDER BY run_id", &hasher);
    if (!status)
        status = vw_ledger_hash_rows(database,
                                     "SELECT run_id, step, psnr, loss, size_psnr, size_loss FROM lasting_step"
                                     " ORDER BY run_id, step",
                                     &hasher);
    if (!status)
        status = vw_ledger_hash_rows(database,
                                     "SELECT run_id, image_id, from_step, predicted_psnr, measured_psnr,"
                                     " predicted_loss, measured_loss FROM lasting_check ORDER BY run_id, image_id",
                                     &hasher);
    if (!status)
        status = vw_ledger_hash_rows(
            database, "SELECT run_id, step, image_id, psnr FROM lasting_view ORDER BY run_id, step, image_id", &hasher);
    vw_row_end_hash(&hasher, hash);
    return status;
}

static const char stray_rows[] =
    "SELECT (SELECT count(*) FROM lasting_step WHERE run_id NOT IN (SELECT run_id FROM "
    "lasting)) + (SELECT count(*) FROM lasting_check WHERE run_id NOT IN (SELECT run_id "
    "FROM lasting)) + (SELECT count(*) FROM lasting_view WHERE run_id NOT IN (SELECT run_id "
    "FROM lasting)) + (SELECT count(*) FROM lasting WHERE run_id NOT IN (SELECT run_id "
    "FROM run))";

enum vw_status vw_ledger_verify_lasting(struct vw_database *database, const char *head) {
    char hash[VW_HASH_HEX_BYTES], stored[VW_HASH_HEX_BYTES] = "";
    sqlite3_stmt *statement = NULL;
    bool found = false;
    int64_t stray_count = 0;
    enum vw_status status = vw_database_read_number(database, stray_rows, &stray_count);
    if (!status && stray_count)
        return vw_fail(VW_ERROR_MISMATCH,
                       "%s: lasting credit has rows without a row in the table lasting: a row was edited or removed",
                       database->path);
    if (!status) status = vw_database_prepare(database, "SELECT row_hash FROM lasting", &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    if (!status && found) vw_row_copy_hash(statement, 0, stored);
    sqlite3_finalize(statement);
    if (!status && found) status = hash_pass(database, head, hash);
    if (status || !found || strcmp(stored, hash) == 0) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: a row of lasting credit (lasting, lasting_step, lasting_check or"
                   " lasting_view) was edited, "
                   "removed or added: its row_hash does not match",
                   database->path);
}

// ---- Writing -------------------------------------------------------------------------------------------------------

static enum vw_status write_settings(struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        &ledger->database, "INSERT INTO lasting (run_id, rays, epochs, states, row_hash) VALUES (?, ?, ?, ?, '')",
        &row.statement);
    if (status) return status;
    vw_row_add_text(&row, ledger->run.run_id);
    vw_row_add_integer(&row, pass->rays);
    vw_row_add_integer(&row, pass->epochs);
    vw_row_add_integer(&row, pass->states);
    status = vw_row_write(&row, &ledger->database, "record the settings of lasting credit");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_steps(struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    struct vw_row row = {0};
    enum vw_status status =
        vw_database_prepare(&ledger->database,
                            "INSERT INTO lasting_step (run_id, step, psnr, loss, size_psnr, size_loss)"
                            " VALUES (?, ?, ?, ?, ?, ?)",
                            &row.statement);
    for (uint64_t i = 0; !status && i < pass->step_count; i++) {
        const struct vw_lasting_step *step = &pass->steps[i];
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, (int64_t)step->step);
        vw_row_add_real(&row, step->psnr);
        vw_row_add_real(&row, step->loss);
        vw_row_add_real(&row, step->size_psnr);
        vw_row_add_real(&row, step->size_loss);
        status = vw_row_write(&row, &ledger->database, "record the lasting credit of a step");
    }
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_checks(struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    struct vw_row row = {0};
    enum vw_status status =
        vw_database_prepare(&ledger->database,
                            "INSERT INTO lasting_check (run_id, image_id, from_step, predicted_psnr, measured_psnr,"
                            " predicted_loss, measured_loss) VALUES (?, ?, ?, ?, ?, ?, ?)",
                            &row.statement);
    for (uint32_t i = 0; !status && i < pass->check_count; i++) {
        const struct vw_gate_check *check = &pass->checks[i];
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, check->image_id);
        vw_row_add_integer(&row, (int64_t)check->from_step);
        vw_row_add_real(&row, check->predicted_psnr);
        vw_row_add_real(&row, check->measured_psnr);
        vw_row_add_real(&row, check->predicted_loss);
        vw_row_add_real(&row, check->measured_loss);
        status = vw_row_write(&row, &ledger->database, "record a photo of the gate");
    }
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_views(struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    struct vw_row row = {0};
    const double *psnr = pass->view_psnr;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "INSERT INTO lasting_view (run_id, step, image_id, psnr) VALUES (?, ?, ?, ?)",
        &row.statement);
    for (uint64_t i = 0; !status && i < pass->step_count; i++)
        for (uint32_t v = 0; !status && v < pass->view_count; v++) {
            vw_row_add_text(&row, ledger->run.run_id);
            vw_row_add_integer(&row, (int64_t)pass->steps[i].step);
            vw_row_add_integer(&row, pass->views[v]);
            vw_row_add_real(&row, *psnr++);
            status = vw_row_write(&row, &ledger->database, "record the lasting credit of a validation photo");
        }
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_hash(struct vw_ledger *ledger) {
    char hash[VW_HASH_HEX_BYTES];
    struct vw_row row = {0};
    enum vw_status status = hash_pass(&ledger->database, ledger->head, hash);
    if (!status) status = vw_database_prepare(&ledger->database, "UPDATE lasting SET row_hash = ?", &row.statement);
    if (status) return status;
    vw_row_add_text(&row, hash);
    status = vw_row_write(&row, &ledger->database, "record the hash of lasting credit");
    sqlite3_finalize(row.statement);
    return status;
}

static enum vw_status write_pass(struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    enum vw_status status = vw_ledger_remove_lasting(&ledger->database);
    if (!status) status = write_settings(ledger, pass);
    if (!status) status = write_steps(ledger, pass);
    if (!status) status = write_checks(ledger, pass);
    if (!status && pass->view_count) status = write_views(ledger, pass);
    return status ? status : write_hash(ledger);
}

// Returns true if the views are all validation photos, sorted by image_id. Load the images first.
static bool are_views(const struct vw_ledger *ledger, const uint32_t *views, uint32_t view_count) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < ledger->image_count; i++) {
        if (strcmp(ledger->images[i].split, "val") != 0) continue;
        if (next == view_count || views[next] != ledger->images[i].image_id) return false;
        next++;
    }
    return next == view_count;
}

static bool is_whole(const struct vw_ledger *ledger, const struct vw_lasting_pass *pass) {
    bool whole = pass->step_count > 0 && pass->step_count + 1 == ledger->next_step;
    for (uint64_t i = 0; whole && i < pass->step_count; i++) {
        const struct vw_lasting_step *step = &pass->steps[i];
        whole = step->step == i + 1 && isfinite(step->psnr) && isfinite(step->loss) && isfinite(step->size_psnr) &&
                isfinite(step->size_loss);
    }
    for (uint32_t i = 0; whole && i < pass->check_count; i++) {
        const struct vw_gate_check *check = &pass->checks[i];
        whole = isfinite(check->predicted_psnr) && !isinf(check->measured_psnr) && isfinite(check->predicted_loss) &&
                !isinf(check->measured_loss);
    }
    for (uint64_t i = 0; whole && i < pass->step_count * pass->view_count; i++) whole = isfinite(pass->view_psnr[i]);
    return whole && (!pass->view_count || are_views(ledger, pass->views, pass->view_count));
}

enum vw_status vw_ledger_set_lasting(struct vw_ledger *ledger, const struct vw_lasting_pass *pass,
                                     const struct vw_ledger_score *scores, uint32_t score_count) {
    enum vw_status status = vw_ledger_load_images(ledger);
    if (status) return status;
    if (!vw_ledger_has_ended(ledger) || !is_whole(ledger, pass))
        return vw_fail(VW_ERROR_USAGE,
                       "%s: lasting credit needs a finite row for each step of a run that has ended; "
                       "run viewworth lasting on the finished run",
                       ledger->database.path);
    struct vw_ledger_state state = {.status = ledger->run.status,
                                    .finished_utc = ledger->run.finished_utc,
                                    .field_sha256 = ledger->run.field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
    status = vw_database_begin(&ledger->database);
    if (status) return status;
    status = vw_ledger_check_current(ledger);
    if (!status) status = write_pass(ledger, pass);
    if (!status) status = vw_ledger_write_state(ledger, &state);
    status = vw_database_end(&ledger->database, status);
    if (!status) vw_ledger_take_state(ledger, &state);
    return status;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static void refuse(const struct vw_ledger *ledger, const char *what, enum vw_status *status) {
    if (!*status)
        *status = vw_fail(VW_ERROR_INPUT, "%s: damaged: lasting credit %s; restore the file from a copy",
                          ledger->database.path, what);
}

// Reads a column that is never NULL in a valid ledger.
static double read_real(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    double value = vw_ledger_read_real(ledger, statement, column, status);
    if (isnan(value)) refuse(ledger, "lacks a value", status);
    return value;
}

static enum vw_status read_settings(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    enum vw_status status = VW_OK;
    *(struct vw_lasting_pass *)item = (struct vw_lasting_pass){
        .rays = (uint32_t)vw_ledger_read_count(ledger, statement, 0, UINT32_MAX, &status),
        .epochs = (uint32_t)vw_ledger_read_count(ledger, statement, 1, UINT32_MAX, &status),
        .states = (uint32_t)vw_ledger_read_count(ledger, statement, 2, UINT32_MAX, &status),
    };
    if (index > 0) refuse(ledger, "has more than one row of settings", &status);
    return status;
}

static enum vw_status read_step(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    enum vw_status status = VW_OK;
    struct vw_lasting_step *step = item;
    *step = (struct vw_lasting_step){
        .step = vw_ledger_read_count(ledger, statement, 0, INT64_MAX, &status),
        .psnr = read_real(ledger, statement, 1, &status),
        .loss = read_real(ledger, statement, 2, &status),
        .size_psnr = read_real(ledger, statement, 3, &status),
        .size_loss = read_real(ledger, statement, 4, &status),
    };
    if (step->step != index + 1) refuse(ledger, "lacks a step", &status);
    if (step->size_psnr < 0 || step->size_loss < 0) refuse(ledger, "has a size below 0", &status);
    return status;
}

static enum vw_status read_check(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    enum vw_status status = VW_OK;
    struct vw_gate_check *check = item;
    *check = (struct vw_gate_check){
        .image_id = vw_ledger_read_image_id(ledger, statement, 0, &status),
        .from_step = vw_ledger_read_count(ledger, statement, 1, ledger->next_step, &status),
        .predicted_psnr = read_real(ledger, statement, 2, &status),
        .measured_psnr = vw_ledger_read_real(ledger, statement, 3, &status),
        .predicted_loss = read_real(ledger, statement, 4, &status),
        .measured_loss = vw_ledger_read_real(ledger, statement, 5, &status),
    };
    if (index > 0 && check[-1].image_id >= check->image_id) refuse(ledger, "checks a photo twice", &status);
    return status;
}

struct view_row {
    uint64_t step;
    uint32_t image_id;
    double psnr;
};

static enum vw_status read_view(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    (void)index;
    enum vw_status status = VW_OK;
    *(struct view_row *)item = (struct view_row){.step = vw_ledger_read_count(ledger, statement, 0, INT64_MAX, &status),
                                                 .image_id = vw_ledger_read_image_id(ledger, statement, 1, &status),
                                                 .psnr = read_real(ledger, statement, 2, &status)};
    return status;
}

// Reads the PSNR of every validation photo after every step; the ledger may also have none of these rows.
static enum vw_status take_views(struct vw_ledger *ledger, const struct view_row *rows, uint64_t row_count,
                                 struct vw_lasting_pass *pass) {
    enum vw_status status = VW_OK;
    uint64_t count = 0;
    if (!row_count) return VW_OK;
    while (count < row_count && rows[count].step == 1) count++;
    uint32_t *views = vw_allocate(count, sizeof *views);
    double *psnr = vw_allocate(row_count, sizeof *psnr);
    pass->views = views;
    pass->view_psnr = psnr;
    if (!views || !psnr) return VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < count; i++) views[i] = rows[i].image_id;
    if (!count || row_count != count * pass->step_count || !are_views(ledger, views, (uint32_t)count))
        refuse(ledger, "lacks a validation photo, or has too many", &status);
    for (uint64_t i = 0; !status && i < row_count; i++) {
        psnr[i] = rows[i].psnr;
        if (rows[i].step != i / count + 1 || rows[i].image_id != views[i % count])
            refuse(ledger, "lacks a step of a validation photo", &status);
    }
    pass->view_count = (uint32_t)count;
    return status;
}

static enum vw_status read_views(struct vw_ledger *ledger, struct vw_lasting_pass *pass) {
    static const struct vw_row_reader reader = {
        "SELECT step, image_id, psnr FROM lasting_view ORDER BY run_id, step, image_id", sizeof(struct view_row),
        read_view};
    struct view_row *rows = NULL;
    uint64_t row_count = 0;
    enum vw_status status = vw_ledger_read_rows(ledger, &reader, (void **)&rows, &row_count);
    if (!status) status = take_views(ledger, rows, row_count, pass);
    free(rows);
    return status;
}

static enum vw_status read_pass(struct vw_ledger *ledger, struct vw_lasting_pass *pass) {
    static const struct vw_row_reader settings = {"SELECT rays, epochs, states FROM lasting", sizeof *pass,
                                                  read_settings},
                                      steps = {"SELECT step, psnr, loss, size_psnr, size_loss FROM lasting_step"
                                               " ORDER BY run_id, step",
                                               sizeof *pass->steps, read_step},
                                      checks = {"SELECT image_id, from_step, predicted_psnr, measured_psnr,"
                                                " predicted_loss, measured_loss FROM lasting_check"
                                                " ORDER BY run_id, image_id",
                                                sizeof *pass->checks, read_check};
    uint64_t pass_count = 0, check_count = 0;
    void *found = NULL;
    enum vw_status status = vw_ledger_read_rows(ledger, &settings, &found, &pass_count);
    if (!status && pass_count) *pass = *(struct vw_lasting_pass *)found;
    free(found);
    if (!status) status = vw_ledger_read_rows(ledger, &steps, (void **)&pass->steps, &pass->step_count);
    if (!status) status = vw_ledger_read_rows(ledger, &checks, (void **)&pass->checks, &check_count);
    pass->check_count = (uint32_t)check_count; // as many as images at most
    uint64_t wanted = pass_count ? ledger->next_step - 1 : 0;
    if (pass_count && !ledger->next_step) wanted = UINT64_MAX;
    if (pass->step_count != wanted || (!pass_count && check_count)) refuse(ledger, "lacks a step", &status);
    return status;
}

enum vw_status vw_ledger_get_lasting(struct vw_ledger *ledger, struct vw_lasting_pass *pass) {
    struct vw_lasting_pass read = {0};
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = read_pass(ledger, &read);
    if (!status) status = read_views(ledger, &read);
    if (status) vw_lasting_pass_free(&read);
    else *pass = read;
    return status;
}

void vw_lasting_pass_free(struct vw_lasting_pass *pass) {
    free((void *)pass->steps);
    free((void *)pass->checks);
    free((void *)pass->views);
    free((void *)pass->view_psnr);
    *pass = (struct vw_lasting_pass){0};
}
