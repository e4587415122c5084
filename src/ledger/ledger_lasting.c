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

// ---- Writing -------------------------------------------------------------------------------------------------------

static enum vw_status insert_views(struct vw_ledger *ledger, const struct vw_lasting_pass *pass,
                                   struct vw_hasher *hasher) {
    struct vw_insertion insertion;
    enum vw_status status =
        vw_insertion_begin(&ledger->database, &vw_lasting_view_table, ledger->run.run_id, &insertion);
    insertion.row.hasher = hasher;
    for (uint64_t i = 0; !status && i < pass->step_count * pass->view_count; i++) {
        const struct vw_lasting_view_row row = {.step = pass->steps[i / pass->view_count].step,
                                                .image_id = pass->views[i % pass->view_count],
                                                .psnr = pass->view_psnr[i]};
        status = vw_insertion_add(&insertion, &row);
    }
    vw_insertion_end(&insertion);
    return status;
}

// Inserts the settings last, with the hash of all rows.
static enum vw_status write_pass(struct vw_ledger *ledger, void *context) {
    const struct vw_lasting_pass *pass = context;
    const char *run_id = ledger->run.run_id;
    struct vw_database *database = &ledger->database;
    struct vw_insertion settings;
    struct vw_hasher hasher;
    char hash[VW_HASH_HEX_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, ledger->head);
    enum vw_status status = vw_insertion_begin(database, &vw_lasting_table, run_id, &settings);
    settings.row.hasher = &hasher;
    vw_insertion_add_columns(&settings, pass);
    if (!status) status = vw_ledger_remove_lasting(database);
    if (!status)
        status = vw_table_insert(database, &vw_lasting_step_table, run_id, pass->steps, pass->step_count, &hasher);
    if (!status)
        status = vw_table_insert(database, &vw_lasting_check_table, run_id, pass->checks, pass->check_count, &hasher);
    if (!status) status = insert_views(ledger, pass, &hasher);
    vw_row_end_hash(&hasher, hash);
    if (!status) status = vw_insertion_write(&settings, hash);
    vw_insertion_end(&settings);
    return status;
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
    bool whole = pass->step_count > 0 && pass->step_count + 1 == ledger->next_step &&
                 vw_table_accepts(&vw_lasting_step_table, pass->steps, pass->step_count) &&
                 vw_table_accepts(&vw_lasting_check_table, pass->checks, pass->check_count);
    for (uint64_t i = 0; whole && i < pass->step_count; i++) whole = pass->steps[i].step == i + 1;
    for (uint32_t i = 1; whole && i < pass->check_count; i++)
        whole = pass->checks[i - 1].image_id < pass->checks[i].image_id; // rows are hashed in key order
    for (uint64_t i = 0; whole && i < pass->step_count * pass->view_count; i++) whole = isfinite(pass->view_psnr[i]);
    return whole && (!pass->view_count || are_views(ledger, pass->views, pass->view_count));
}

enum vw_status vw_ledger_set_lasting(struct vw_ledger *ledger, const struct vw_lasting_pass *pass,
                                     const struct vw_ledger_score *scores, uint32_t score_count) {
    enum vw_status status = vw_ledger_load_images(ledger);
    if (status) return status;
    if (!vw_ledger_has_finished(ledger) || !is_whole(ledger, pass))
        return vw_fail(VW_ERROR_USAGE,
                       "%s: lasting credit needs a finite row for each step of a finished run; "
                       "run viewworth lasting on the finished run",
                       ledger->database.path);
    struct vw_ledger_state state = vw_ledger_state_with(ledger, scores, score_count);
    return vw_ledger_change(ledger, &state, write_pass, (void *)pass);
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static enum vw_status refuse(const struct vw_ledger *ledger, const char *what) {
    return vw_fail(VW_ERROR_INPUT, "%s: damaged: lasting credit %s; restore the file from a copy",
                   ledger->database.path, what);
}

static enum vw_status check_settings(struct vw_ledger *ledger, uint64_t index, void *row) {
    (void)row;
    return index ? refuse(ledger, "has more than one row of settings") : VW_OK;
}

static enum vw_status check_step(struct vw_ledger *ledger, uint64_t index, void *row) {
    const struct vw_lasting_step *step = row;
    if (step->step != index + 1) return refuse(ledger, "lacks a step");
    return step->size_psnr < 0 || step->size_loss < 0 ? refuse(ledger, "has a size below 0") : VW_OK;
}

static enum vw_status check_check(struct vw_ledger *ledger, uint64_t index, void *row) {
    const struct vw_gate_check *check = row;
    if (check->from_step > ledger->next_step) return vw_ledger_fail_column(ledger, "from_step");
    return index > 0 && check[-1].image_id >= check->image_id ? refuse(ledger, "checks a photo twice") : VW_OK;
}

// Takes the PSNR of every validation photo after every step; the ledger may also have none of these rows.
static enum vw_status take_views(struct vw_ledger *ledger, const struct vw_lasting_view_row *rows, uint64_t row_count,
                                 struct vw_lasting_pass *pass) {
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
        return refuse(ledger, "lacks a validation photo, or has too many");
    for (uint64_t i = 0; i < row_count; i++) {
        psnr[i] = rows[i].psnr;
        if (rows[i].step != i / count + 1 || rows[i].image_id != views[i % count])
            return refuse(ledger, "lacks a step of a validation photo");
    }
    pass->view_count = (uint32_t)count;
    return VW_OK;
}

static enum vw_status read_pass(struct vw_ledger *ledger, struct vw_lasting_pass *pass) {
    uint64_t pass_count = 0, check_count = 0, view_count = 0;
    struct vw_lasting_pass *settings = NULL;
    struct vw_lasting_view_row *views = NULL;
    enum vw_status status =
        vw_ledger_read_table(ledger, &vw_lasting_table, NULL, check_settings, (void **)&settings, &pass_count);
    if (!status && pass_count) *pass = *settings;
    free(settings);
    if (!status)
        status = vw_ledger_read_table(ledger, &vw_lasting_step_table, NULL, check_step, (void **)&pass->steps,
                                      &pass->step_count);
    if (!status)
        status = vw_ledger_read_table(ledger, &vw_lasting_check_table, NULL, check_check, (void **)&pass->checks,
                                      &check_count);
    pass->check_count = (uint32_t)check_count; // as many as images at most
    uint64_t wanted = pass_count ? ledger->next_step - 1 : 0;
    if (pass_count && !ledger->next_step) wanted = UINT64_MAX;
    if (!status && (pass->step_count != wanted || (!pass_count && check_count)))
        status = refuse(ledger, "lacks a step");
    if (!status)
        status = vw_ledger_read_table(ledger, &vw_lasting_view_table, NULL, NULL, (void **)&views, &view_count);
    if (!status) status = take_views(ledger, views, view_count, pass);
    free(views);
    return status;
}

enum vw_status vw_ledger_get_lasting(struct vw_ledger *ledger, struct vw_lasting_pass *pass) {
    struct vw_lasting_pass read = {0};
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = read_pass(ledger, &read);
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
