#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

enum { NAME_BYTES_MOST = 600 };                       // struct vw_gpu_info
static const uint32_t image_id_most = UINT32_MAX - 1; // VW_RECORD_UNTRAINED is none

const char *vw_ledger_keep_text(struct vw_ledger *ledger, const char *text) {
    char *kept = vw_copy_text(text);
    if (!kept) return NULL;
    if (vw_grow((void **)&ledger->texts, &ledger->text_capacity, ledger->text_count + 1, sizeof *ledger->texts)) {
        free(kept);
        return NULL;
    }
    ledger->texts[ledger->text_count++] = kept;
    return kept;
}

// ---- Columns: see ledger_private.h ----

static void fail_damaged(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    *status = vw_fail(VW_ERROR_INPUT, "%s: damaged: column %s has an invalid value; restore the file from a copy",
                      ledger->database.path, sqlite3_column_name(statement, column));
}

// Copies a text; the copy lives as long as the ledger. Returns NULL for NULL.
static const char *keep_text(struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    int type = sqlite3_column_type(statement, column);
    if (*status || type == SQLITE_NULL) return NULL;
    const char *text = type == SQLITE_TEXT ? (const char *)sqlite3_column_text(statement, column) : NULL;
    if (!text || strlen(text) != (size_t)sqlite3_column_bytes(statement, column)) {
        fail_damaged(ledger, statement, column, status);
        return NULL;
    }
    const char *kept = vw_ledger_keep_text(ledger, text);
    if (!kept) *status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory", ledger->database.path);
    return kept;
}

uint64_t vw_ledger_read_count(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, uint64_t most,
                              enum vw_status *status) {
    int64_t value = sqlite3_column_int64(statement, column);
    if (*status) return 0;
    if (sqlite3_column_type(statement, column) == SQLITE_INTEGER && value >= 0 && (uint64_t)value <= most)
        return (uint64_t)value;
    fail_damaged(ledger, statement, column, status);
    return 0;
}

double vw_ledger_read_real(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column,
                           enum vw_status *status) {
    int type = sqlite3_column_type(statement, column);
    double value = type == SQLITE_FLOAT ? sqlite3_column_double(statement, column) : NAN;
    if (*status || type == SQLITE_NULL) return NAN;
    if (type != SQLITE_FLOAT || !isfinite(value)) fail_damaged(ledger, statement, column, status);
    return value;
}

uint32_t vw_ledger_read_image_id(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column,
                                 enum vw_status *status) {
    uint32_t id = (uint32_t)vw_ledger_read_count(ledger, statement, column, image_id_most, status);
    if (!*status && !vw_ledger_find_image(ledger->images, ledger->image_count, id))
        fail_damaged(ledger, statement, column, status);
    return id;
}

static uint32_t read_image_or_untrained(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column,
                                        enum vw_status *status) {
    bool untrained = sqlite3_column_type(statement, column) == SQLITE_NULL;
    return untrained ? (uint32_t)VW_RECORD_UNTRAINED : vw_ledger_read_image_id(ledger, statement, column, status);
}

// Copies a text from a column that is never NULL in a valid ledger.
static const char *keep_some_text(struct vw_ledger *ledger, sqlite3_stmt *statement, int column,
                                  enum vw_status *status) {
    const char *text = keep_text(ledger, statement, column, status);
    if (!text && !*status) fail_damaged(ledger, statement, column, status);
    return text;
}

// ---- The run and its state ----

// Copies the status and refuses unknown words, which would be shown as if viewworth had written them.
static const char *keep_status(struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    static const char *const known[] = {VW_LEDGER_RUNNING, "finished", "interrupted", "failed"};
    const char *text = keep_some_text(ledger, statement, column, status);
    for (size_t i = 0; text && i < VW_ARRAY_COUNT(known); i++)
        if (strcmp(text, known[i]) == 0) return text;
    if (!*status) fail_damaged(ledger, statement, column, status);
    return NULL;
}

// Copies the name of a device or driver, which a page and tables show.
static const char *keep_name(struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    const char *text = keep_some_text(ledger, statement, column, status);
    if (text && (strlen(text) > NAME_BYTES_MOST || !vw_text_is_clean(text)))
        fail_damaged(ledger, statement, column, status);
    return text;
}

// Loads the run row; a ledger has exactly one.
static enum vw_status load_run(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database,
        "SELECT run_id, scene_hash, scene_path, seed, config_json, subset_hash, device, driver, shader_hash, version, "
        "started_utc,"
        " scene_options_json, effects_json, status, row_hash, final_hash, finished_utc, plan_json, "
        "field_sha256 FROM run",
        &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && !found)
        status = vw_fail(VW_ERROR_MISMATCH, "%s: its run row was removed; restore the file from a copy",
                         ledger->database.path);
    if (!status) {
        ledger->run = (struct vw_ledger_run){
            .run_id = keep_some_text(ledger, statement, 0, &status),
            .scene_hash = keep_some_text(ledger, statement, 1, &status),
            .scene_path = keep_some_text(ledger, statement, 2, &status),
            .seed = (int64_t)vw_ledger_read_count(ledger, statement, 3, INT64_MAX, &status),
            .config_json = keep_some_text(ledger, statement, 4, &status),
            .subset_hash = keep_some_text(ledger, statement, 5, &status),
            .device = keep_name(ledger, statement, 6, &status),
            .driver = keep_name(ledger, statement, 7, &status),
            .shader_hash = keep_some_text(ledger, statement, 8, &status),
            .version = keep_name(ledger, statement, 9, &status),
            .started_utc = keep_some_text(ledger, statement, 10, &status),
            .scene_options_json = keep_some_text(ledger, statement, 11, &status),
            .effects_json = keep_some_text(ledger, statement, 12, &status),
            .plan_json = keep_some_text(ledger, statement, 17, &status),
            .status = keep_status(ledger, statement, 13, &status),
            .finished_utc = keep_text(ledger, statement, 16, &status),
            .field_sha256 = keep_text(ledger, statement, 18, &status),
        };
        vw_row_copy_hash(statement, 14, ledger->run_hash);
        vw_row_copy_hash(statement, 15, ledger->final_hash);
        memcpy(ledger->head, ledger->run_hash, sizeof ledger->head);
    }
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found)
        status = vw_fail(VW_ERROR_MISMATCH, "%s: has more than one run; use the ledger of a single run",
                         ledger->database.path);
    sqlite3_finalize(statement);
    return status;
}

static enum vw_status load_last_step(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT step, row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) {
        ledger->next_step = 1 + vw_ledger_read_count(ledger, statement, 0, INT64_MAX - 1, &status);
        vw_row_copy_hash(statement, 1, ledger->head);
    }
    sqlite3_finalize(statement);
    return status;
}

// Reads both in one transaction, because another process may be appending.
enum vw_status vw_ledger_load(struct vw_ledger *ledger) {
    enum vw_status status = vw_database_begin_reading(&ledger->database);
    if (status) return status;
    status = load_run(ledger);
    if (!status) status = load_last_step(ledger);
    return vw_database_end(&ledger->database, status);
}

enum vw_status vw_ledger_check_current(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false, current = false;
    enum vw_status status =
        vw_database_prepare(&ledger->database,
                            "SELECT final_hash, (SELECT count(*) FROM (SELECT 1 FROM step WHERE step >= ? LIMIT 1)),"
                            " (SELECT row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1) FROM run",
                            &statement);
    if (!status && sqlite3_bind_int64(statement, 1, (sqlite3_int64)ledger->next_step) != SQLITE_OK)
        status = vw_database_fail(&ledger->database, "query the ledger");
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) {
        char final_hash[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
        vw_row_copy_hash(statement, 0, final_hash);
        vw_row_copy_hash(statement, 2, head);
        bool added = sqlite3_column_int(statement, 1) > 0;
        current = strcmp(final_hash, ledger->final_hash) == 0 && !added &&
                  (ledger->next_step == 0 || strcmp(head, ledger->head) == 0);
    }
    sqlite3_finalize(statement);
    if (status || current) return status;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: another process has written to it; use each folder for one run at a time, then --resume",
                   ledger->database.path);
}

enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run) {
    *run = ledger->run;
    return VW_OK;
}

// ---- Tables ----

enum vw_status vw_ledger_read_rows(struct vw_ledger *ledger, const struct vw_row_reader *reader, void **items,
                                   uint64_t *count) {
    sqlite3_stmt *statement = NULL;
    void *read = NULL;
    size_t capacity = 0, used = 0;
    bool found = false;
    enum vw_status status = vw_database_prepare(&ledger->database, reader->sql, &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        status = vw_grow(&read, &capacity, used + 1, reader->item_bytes);
        if (!status) status = reader->read(ledger, statement, used, (char *)read + used * reader->item_bytes);
        used++;
    }
    sqlite3_finalize(statement);
    if (status) {
        free(read);
        return status;
    }
    *items = read;
    *count = used;
    return VW_OK;
}

// Reads an image. The ids must ascend, because images are found by binary search.
static enum vw_status read_image(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    enum vw_status status = VW_OK;
    struct vw_ledger_image *image = item;
    *image = (struct vw_ledger_image){
        .image_id = (uint32_t)vw_ledger_read_count(ledger, statement, 0, image_id_most, &status),
        .name = keep_some_text(ledger, statement, 1, &status),
        .split = keep_some_text(ledger, statement, 2, &status),
        .provider = keep_text(ledger, statement, 3, &status),
        .sha256 = keep_text(ledger, statement, 4, &status),
        .ground_truth = keep_text(ledger, statement, 5, &status),
    };
    if (!status && index >= VW_VIEWS_MOST)
        status = vw_fail(VW_ERROR_INPUT, "%s: has more than %d images; viewworth writes no such ledger",
                         ledger->database.path, VW_VIEWS_MOST);
    if (!status && index > 0 && image[-1].image_id >= image->image_id) fail_damaged(ledger, statement, 0, &status);
    return status;
}

enum vw_status vw_ledger_get_images(struct vw_ledger *ledger, const struct vw_ledger_image **images, uint32_t *count) {
    static const struct vw_row_reader reader = {
        "SELECT image_id, name, split, provider, sha256, ground_truth FROM image ORDER BY scene_hash, image_id",
        sizeof **images, read_image};
    if (!ledger->images) {
        void *loaded = NULL;
        uint64_t loaded_count = 0;
        enum vw_status status = vw_ledger_read_rows(ledger, &reader, &loaded, &loaded_count);
        if (status) return status;
        ledger->images = loaded;
        ledger->image_count = (uint32_t)loaded_count;
    }
    *images = ledger->images;
    *count = ledger->image_count;
    return VW_OK;
}

static enum vw_status read_step(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    enum vw_status status = VW_OK;
    struct vw_step_record *record = item;
    *record = (struct vw_step_record){
        .step = vw_ledger_read_count(ledger, statement, 0, index, &status),
        .epoch = (uint32_t)vw_ledger_read_count(ledger, statement, 1, index < UINT32_MAX ? index : UINT32_MAX, &status),
        .view = read_image_or_untrained(ledger, statement, 2, &status),
        .train_loss = vw_ledger_read_real(ledger, statement, 3, &status),
        .validated = sqlite3_column_type(statement, 4) != SQLITE_NULL,
        .val_psnr = vw_ledger_read_real(ledger, statement, 4, &status),
        .val_psnr_pooled = vw_ledger_read_real(ledger, statement, 5, &status),
        .val_l1 = vw_ledger_read_real(ledger, statement, 6, &status),
        .nonfinite = vw_ledger_read_count(ledger, statement, 7, 1, &status) == 1,
        .clamped_count = vw_ledger_read_count(ledger, statement, 8, INT64_MAX, &status),
        .floored_views = (uint32_t)vw_ledger_read_count(ledger, statement, 9, UINT32_MAX, &status),
    };
    if (!status && record->step != index) fail_damaged(ledger, statement, 0, &status);
    return status;
}

enum vw_status vw_ledger_load_images(struct vw_ledger *ledger) {
    const struct vw_ledger_image *images = NULL;
    uint32_t count = 0;
    return vw_ledger_get_images(ledger, &images, &count);
}

enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count) {
    static const struct vw_row_reader reader = {"SELECT step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, "
                                                "val_l1, nonfinite, clamped, floored FROM step"
                                                " ORDER BY run_id, step",
                                                sizeof **records, read_step};
    enum vw_status status = vw_ledger_load_images(ledger);
    return status ? status : vw_ledger_read_rows(ledger, &reader, (void **)records, count);
}

static enum vw_status read_probe(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    (void)index;
    enum vw_status status = VW_OK;
    const char *name = (const char *)sqlite3_column_text(statement, 2);
    uint32_t kind = 0;
    while (kind < VW_PROBE_KIND_COUNT && !(name && strcmp(name, vw_probe_kind_names[kind]) == 0)) kind++;
    if (kind == VW_PROBE_KIND_COUNT) fail_damaged(ledger, statement, 2, &status);
    *(struct vw_probe *)item = (struct vw_probe){
        .step = vw_ledger_read_count(ledger, statement, 0, INT64_MAX, &status),
        .index = (uint32_t)vw_ledger_read_count(ledger, statement, 1, UINT32_MAX, &status),
        .kind = (enum vw_probe_kind)kind,
        .val_psnr = vw_ledger_read_real(ledger, statement, 3, &status),
        .val_psnr_pooled = vw_ledger_read_real(ledger, statement, 4, &status),
        .val_l1 = vw_ledger_read_real(ledger, statement, 5, &status),
        .view = read_image_or_untrained(ledger, statement, 6, &status),
    };
    return status;
}

enum vw_status vw_ledger_get_probes(struct vw_ledger *ledger, struct vw_probe **probes, uint64_t *count) {
    static const struct vw_row_reader reader = {
        "SELECT step, probe, kind, val_psnr, val_psnr_pooled, val_l1, image_id FROM probe ORDER BY run_id, step, probe",
        sizeof **probes, read_probe};
    enum vw_status status = vw_ledger_load_images(ledger);
    return status ? status : vw_ledger_read_rows(ledger, &reader, (void **)probes, count);
}

// Reads the best or the worst rank. Both are NULL if there is no interval; the rank is then 0.
static uint32_t read_rank(const struct vw_ledger *ledger, sqlite3_stmt *statement, int column, enum vw_status *status) {
    if (sqlite3_column_type(statement, column) == SQLITE_NULL) return 0;
    return (uint32_t)vw_ledger_read_count(ledger, statement, column, UINT32_MAX, status);
}

static enum vw_status read_score(struct vw_ledger *ledger, sqlite3_stmt *statement, uint64_t index, void *item) {
    (void)index;
    enum vw_status status = VW_OK;
    *(struct vw_ledger_score *)item = (struct vw_ledger_score){
        .image_id = vw_ledger_read_image_id(ledger, statement, 0, &status),
        .method = keep_some_text(ledger, statement, 1, &status),
        .value = vw_ledger_read_real(ledger, statement, 2, &status),
        .unit = keep_some_text(ledger, statement, 3, &status),
        .standard_error = vw_ledger_read_real(ledger, statement, 4, &status),
        .visits = (uint32_t)vw_ledger_read_count(ledger, statement, 5, UINT32_MAX, &status),
        .resampling_stderr = vw_ledger_read_real(ledger, statement, 6, &status),
        .ci_low = vw_ledger_read_real(ledger, statement, 7, &status),
        .ci_high = vw_ledger_read_real(ledger, statement, 8, &status),
        .rank_ci_low = read_rank(ledger, statement, 9, &status),
        .rank_ci_high = read_rank(ledger, statement, 10, &status),
    };
    return status;
}

enum vw_status vw_ledger_get_scores(struct vw_ledger *ledger, struct vw_ledger_score **scores, uint32_t *count) {
    static const struct vw_row_reader reader = {
        "SELECT image_id, method, value, unit, stderr, visits, resampling_stderr, ci_low, ci_high, rank_ci_low, "
        "rank_ci_high FROM score"
        " JOIN (SELECT method, min(rowid) AS first FROM score GROUP BY method) USING (method) ORDER BY first, image_id",
        sizeof **scores, read_score};
    uint64_t read_count = 0;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = vw_ledger_read_rows(ledger, &reader, (void **)scores, &read_count);
    if (!status) *count = (uint32_t)read_count;
    return status;
}
