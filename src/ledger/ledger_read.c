#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "base/text.h"
#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

enum { NAME_BYTES_MOST = 600 }; // struct vw_gpu_info

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

// ---- Columns -------------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_fail_column(const struct vw_ledger *ledger, const char *name) {
    return vw_fail(VW_ERROR_INPUT, "%s: damaged: column %s has an invalid value; restore the file from a copy",
                   ledger->database.path, name);
}

static enum vw_status read_text(struct vw_ledger *ledger, sqlite3_stmt *statement, int index,
                                const struct vw_column *column, const char **text) {
    int type = sqlite3_column_type(statement, index);
    const char *found = type == SQLITE_TEXT ? (const char *)sqlite3_column_text(statement, index) : NULL;
    *text = NULL;
    if (type == SQLITE_NULL && column->kind == VW_COLUMN_TEXT_OR_NULL) return VW_OK;
    if (!found || strlen(found) != (size_t)sqlite3_column_bytes(statement, index) ||
        (column->kind == VW_COLUMN_NAME && strlen(found) > NAME_BYTES_MOST) || !vw_text_is_clean(found))
        return vw_ledger_fail_column(ledger, column->name);
    *text = vw_ledger_keep_text(ledger, found);
    return *text ? VW_OK : vw_fail(VW_ERROR_MEMORY, "%s: out of memory", ledger->database.path);
}

static enum vw_status read_count(const struct vw_ledger *ledger, sqlite3_stmt *statement, int index,
                                 const struct vw_column *column, uint64_t most, uint64_t *count) {
    int64_t value = sqlite3_column_int64(statement, index);
    if (sqlite3_column_type(statement, index) != SQLITE_INTEGER || value < 0 || (uint64_t)value > most)
        return vw_ledger_fail_column(ledger, column->name);
    *count = (uint64_t)value;
    return VW_OK;
}

static enum vw_status read_image(const struct vw_ledger *ledger, sqlite3_stmt *statement, int index,
                                 const struct vw_column *column, uint32_t *image_id) {
    uint64_t id = 0;
    enum vw_status status = read_count(ledger, statement, index, column, UINT32_MAX, &id);
    if (!status && !vw_ledger_find_image(ledger->images, ledger->image_count, (uint32_t)id))
        status = vw_ledger_fail_column(ledger, column->name);
    *image_id = (uint32_t)id;
    return status;
}

static enum vw_status read_real(const struct vw_ledger *ledger, sqlite3_stmt *statement, int index,
                                const struct vw_column *column, double *value) {
    int type = sqlite3_column_type(statement, index);
    *value = type == SQLITE_FLOAT ? sqlite3_column_double(statement, index) : NAN;
    bool valid = type == SQLITE_NULL ? column->kind == VW_COLUMN_REAL_OR_NULL : isfinite(*value);
    return valid ? VW_OK : vw_ledger_fail_column(ledger, column->name);
}

static enum vw_status read_column(struct vw_ledger *ledger, sqlite3_stmt *statement, int index,
                                  const struct vw_column *column, void *member) {
    bool null = sqlite3_column_type(statement, index) == SQLITE_NULL;
    uint64_t count = 0;
    enum vw_status status = VW_OK;
    switch (column->kind) {
    case VW_COLUMN_OWNER: return VW_OK; // it decides nothing
    case VW_COLUMN_TEXT:
    case VW_COLUMN_TEXT_OR_NULL:
    case VW_COLUMN_NAME: return read_text(ledger, statement, index, column, member);
    case VW_COLUMN_FLAG:
        status = read_count(ledger, statement, index, column, 1, &count);
        *(bool *)member = count == 1;
        return status;
    case VW_COLUMN_COUNT64: return read_count(ledger, statement, index, column, INT64_MAX, member);
    case VW_COLUMN_RANK:
    case VW_COLUMN_COUNT:
        if (!null || column->kind == VW_COLUMN_COUNT)
            status = read_count(ledger, statement, index, column, UINT32_MAX, &count);
        *(uint32_t *)member = (uint32_t)count;
        return status;
    case VW_COLUMN_IMAGE_OR_NULL:
        *(uint32_t *)member = VW_RECORD_UNTRAINED;
        if (null) return VW_OK;
        // fall through
    case VW_COLUMN_IMAGE: return read_image(ledger, statement, index, column, member);
    case VW_COLUMN_REAL:
    case VW_COLUMN_REAL_OR_NULL: return read_real(ledger, statement, index, column, member);
    default: return vw_ledger_fail_column(ledger, column->name);
    }
    return status;
}

static enum vw_status read_row(struct vw_ledger *ledger, const struct vw_table *table, sqlite3_stmt *statement,
                               void *row) {
    enum vw_status status = VW_OK;
    for (int i = 0; !status && i < table->column_count; i++)
        status = read_column(ledger, statement, i, &table->columns[i], (char *)row + table->columns[i].offset);
    return status;
}

// ---- Tables --------------------------------------------------------------------------------------------------------

enum vw_status vw_ledger_read_table(struct vw_ledger *ledger, const struct vw_table *table, const char *order,
                                    vw_ledger_check_row *check, void **rows, uint64_t *count) {
    sqlite3_stmt *statement = NULL;
    void *read = NULL;
    size_t capacity = 0, used = 0;
    bool found = false;
    enum vw_status status = vw_table_select(&ledger->database, table, order, &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        status = vw_grow(&read, &capacity, used + 1, table->row_bytes);
        void *row = (char *)read + used * table->row_bytes;
        if (!status) status = read_row(ledger, table, statement, row);
        if (!status && check) status = check(ledger, used, row);
        used++;
    }
    sqlite3_finalize(statement);
    if (status) {
        free(read);
        return status;
    }
    *rows = read;
    *count = used;
    return VW_OK;
}

// Reads the weights of validation photos from run.scene_options_json; one that has none weighs 1.
static enum vw_status read_weights(struct vw_ledger *ledger, struct vw_ledger_image *images, uint64_t count) {
    const char *json = ledger->run.scene_options_json;
    json_t *options = vw_json_load(json, strlen(json), 0, NULL), *weights = json_object_get(options, "weights");
    size_t read = 0;
    bool valid = true, weighted = false;
    for (uint64_t i = 0; i < count; i++) {
        const json_t *weight = strcmp(images[i].split, "val") == 0 ? json_object_get(weights, images[i].name) : NULL;
        images[i].weight = weight ? json_number_value(weight) : 1;
        valid &= !weight || (json_is_number(weight) && vw_val_weight_is_valid(images[i].weight));
        weighted |= images[i].weight > 0 && !strcmp(images[i].split, "val");
        read += weight != NULL;
    }
    valid &= !weights || (json_is_object(weights) && json_object_size(weights) == read && weighted);
    json_decref(options);
    return valid ? VW_OK : vw_ledger_fail_column(ledger, "scene_options_json");
}

// Checks that the ids ascend, because images are found by binary search.
static enum vw_status check_image(struct vw_ledger *ledger, uint64_t index, void *row) {
    const struct vw_ledger_image *image = row;
    if (index >= VW_VIEWS_MOST)
        return vw_fail(VW_ERROR_INPUT, "%s: has more than %d images; viewworth writes no such ledger",
                       ledger->database.path, VW_VIEWS_MOST);
    bool valid = image->image_id != VW_RECORD_UNTRAINED && (!index || image[-1].image_id < image->image_id);
    return valid ? VW_OK : vw_ledger_fail_column(ledger, "image_id");
}

enum vw_status vw_ledger_get_images(struct vw_ledger *ledger, const struct vw_ledger_image **images, uint32_t *count) {
    enum vw_status status = vw_ledger_load_images(ledger);
    if (status) return status;
    *images = ledger->images;
    *count = ledger->image_count;
    return VW_OK;
}

enum vw_status vw_ledger_load_images(struct vw_ledger *ledger) {
    void *loaded = NULL;
    uint64_t count = 0;
    if (ledger->images) return VW_OK;
    enum vw_status status = vw_ledger_read_table(ledger, &vw_image_table, NULL, check_image, &loaded, &count);
    if (!status) status = read_weights(ledger, loaded, count);
    if (status) {
        free(loaded);
        return status;
    }
    ledger->images = loaded;
    ledger->image_count = (uint32_t)count;
    return VW_OK;
}

// ---- The run and its state -----------------------------------------------------------------------------------------

// Checks the status: an unknown word would be shown as if viewworth had written it.
static enum vw_status check_run(struct vw_ledger *ledger, uint64_t index, void *row) {
    static const char *const known[] = {VW_LEDGER_RUNNING, VW_LEDGER_FINISHED, "interrupted", "failed"};
    const struct vw_sealed_run *run = row;
    if (index > 0)
        return vw_fail(VW_ERROR_MISMATCH, "%s: has more than one run; use the ledger of a single run",
                       ledger->database.path);
    for (size_t i = 0; i < VW_ARRAY_COUNT(known); i++)
        if (strcmp(run->run.status, known[i]) == 0) return VW_OK;
    return vw_ledger_fail_column(ledger, "status");
}

// Copies a hash; "", which equals no hash, if the text is something else.
static void copy_hash(const char *text, char hash[VW_HASH_HEX_BYTES]) {
    bool is_hash = strlen(text) == VW_HASH_HEX_BYTES - 1;
    memcpy(hash, is_hash ? text : "", is_hash ? VW_HASH_HEX_BYTES : 1);
}

static enum vw_status load_run(struct vw_ledger *ledger) {
    void *rows = NULL;
    uint64_t count = 0;
    enum vw_status status = vw_ledger_read_table(ledger, &vw_run_table, NULL, check_run, &rows, &count);
    if (!status && !count)
        status = vw_fail(VW_ERROR_MISMATCH, "%s: its run row was removed; restore the file from a copy",
                         ledger->database.path);
    if (!status) {
        const struct vw_sealed_run *row = rows;
        ledger->run = row->run;
        copy_hash(row->row_hash, ledger->run_hash);
        copy_hash(row->final_hash, ledger->final_hash);
        memcpy(ledger->head, ledger->run_hash, sizeof ledger->head);
    }
    free(rows);
    return status;
}

static enum vw_status load_last_step(struct vw_ledger *ledger) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(
        &ledger->database, "SELECT step, row_hash FROM step ORDER BY run_id DESC, step DESC LIMIT 1", &statement);
    if (!status) status = vw_database_next(&ledger->database, statement, &found);
    if (!status && found) {
        int64_t step = sqlite3_column_int64(statement, 0);
        if (step < 0 || step == INT64_MAX) status = vw_ledger_fail_column(ledger, "step");
        else ledger->next_step = (uint64_t)step + 1;
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

enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run) {
    *run = ledger->run;
    return VW_OK;
}

// ---- Steps, scores and views ---------------------------------------------------------------------------------------

static enum vw_status check_step(struct vw_ledger *ledger, uint64_t index, void *row) {
    struct vw_step_record *record = row;
    record->validated = !isnan(record->val_psnr);
    if (record->step != index) return vw_ledger_fail_column(ledger, "step");
    return vw_step_has_epoch(record) ? VW_OK : vw_ledger_fail_column(ledger, "epoch");
}

enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count) {
    enum vw_status status = vw_ledger_load_images(ledger);
    return status ? status : vw_ledger_read_table(ledger, &vw_step_table, NULL, check_step, (void **)records, count);
}

enum vw_status vw_ledger_get_scores(struct vw_ledger *ledger, struct vw_ledger_score **scores, uint32_t *count) {
    static const char by_first_row_of_method[] = "min(rowid) OVER (PARTITION BY method), image_id";
    uint64_t read_count = 0;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status)
        status =
            vw_ledger_read_table(ledger, &vw_score_table, by_first_row_of_method, NULL, (void **)scores, &read_count);
    if (!status) *count = (uint32_t)read_count;
    return status;
}

enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_ledger_load_images(ledger);
    if (!status) status = vw_table_select(&ledger->database, &vw_view_table, NULL, &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found) {
        struct vw_view_row row = {0};
        status = read_row(ledger, &vw_view_table, statement, &row);
        const struct vw_view_error error = {.mse = row.mse, .l1 = row.l1};
        if (!status) take(context, row.step, row.image_id, &error);
    }
    sqlite3_finalize(statement);
    return status;
}
