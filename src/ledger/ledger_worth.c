#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text_stream.h"
#include "ledger/find_image.h"
#include "ledger/ledger_private.h"

// ---- Writing -------------------------------------------------------------------------------------------------------

static enum vw_status write_ids(const struct vw_ledger_retraining *retraining, char **text) {
    size_t size_bytes = 0;
    struct vw_text_stream list;
    FILE *stream = vw_text_stream_open(&list);
    for (uint32_t i = 0; stream && i < retraining->image_count; i++)
        fprintf(stream, "%s%" PRIu32, i ? " " : "", retraining->image_ids[i]);
    return vw_text_stream_close(&list, "photos of a retraining", text, &size_bytes);
}

static enum vw_status insert(struct vw_ledger *ledger, const struct vw_ledger_retraining *retrainings, uint32_t count,
                             int64_t first) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(
        &ledger->database,
        "INSERT INTO retraining (run_id, retraining, whole_providers, seed, epochs, image_ids, val_psnr)"
        " VALUES (?, ?, ?, ?, ?, ?, ?)",
        &row.statement);
    for (uint32_t i = 0; !status && i < count; i++) {
        char *ids = NULL;
        status = write_ids(&retrainings[i], &ids);
        if (status) break;
        vw_row_add_text(&row, ledger->run.run_id);
        vw_row_add_integer(&row, first + i);
        vw_row_add_integer(&row, retrainings[i].whole_providers);
        vw_row_add_integer(&row, (int64_t)retrainings[i].seed);
        vw_row_add_integer(&row, retrainings[i].epochs);
        vw_row_add_text(&row, ids);
        vw_row_add_real(&row, retrainings[i].val_psnr);
        status = vw_row_write(&row, &ledger->database, "record a retraining");
        free(ids);
    }
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_ledger_add_retrainings(struct vw_ledger *ledger, const struct vw_ledger_retraining *retrainings,
                                         uint32_t count, const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_ledger_state state = {.status = ledger->run.status,
                                    .finished_utc = ledger->run.finished_utc,
                                    .field_sha256 = ledger->run.field_sha256,
                                    .scores = scores,
                                    .score_count = score_count};
    int64_t recorded = 0;
    if (!vw_ledger_has_ended(ledger))
        return vw_fail(VW_ERROR_USAGE, "%s: the run has not ended; finish it by --resume first", ledger->database.path);
    enum vw_status status = vw_database_begin(&ledger->database);
    if (status) return status;
    status = vw_ledger_check_current(ledger);
    if (!status) status = vw_database_read_number(&ledger->database, "SELECT count(*) FROM retraining", &recorded);
    if (!status) status = insert(ledger, retrainings, count, recorded);
    if (!status) status = vw_ledger_write_state(ledger, &state);
    status = vw_database_end(&ledger->database, status);
    if (!status) vw_ledger_take_state(ledger, &state);
    return status;
}

// ---- Reading: the rows may come from elsewhere ---------------------------------------------------------------------

// Rows that are read, and all their ids; these move as they grow.
struct reading {
    struct vw_ledger_retraining *rows;
    size_t count, capacity;
    uint32_t *ids;
    size_t id_count, id_capacity;
};

static bool is_trained(const struct vw_ledger *ledger, uint64_t id) {
    const struct vw_ledger_image *image =
        id <= UINT32_MAX ? vw_ledger_find_image(ledger->images, ledger->image_count, (uint32_t)id) : NULL;
    return image && strcmp(image->split, "train") == 0;
}

// Reads ids of train photos. They must ascend, with single spaces between them and nothing more.
static enum vw_status read_ids(const struct vw_ledger *ledger, const char *text, struct reading *reading, bool *valid) {
    enum vw_status status = VW_OK;
    uint64_t last = 0;
    bool first = true;
    *valid = text && *text;
    while (*valid && *text && !status) {
        uint64_t id = 0;
        const char *digit = text;
        for (; *digit >= '0' && *digit <= '9' && id <= UINT32_MAX; digit++) id = id * 10 + (uint64_t)(*digit - '0');
        bool canonical =
            digit > text && (*text != '0' || digit == text + 1) && (!*digit || (*digit == ' ' && digit[1]));
        *valid = canonical && (first || id > last) && is_trained(ledger, id);
        if (!*valid) break;
        status = vw_grow((void **)&reading->ids, &reading->id_capacity, reading->id_count + 1, sizeof *reading->ids);
        if (!status) reading->ids[reading->id_count++] = (uint32_t)id;
        last = id;
        first = false;
        text = *digit ? digit + 1 : digit;
    }
    return status;
}

static enum vw_status read_row(struct vw_ledger *ledger, sqlite3_stmt *statement, struct reading *reading) {
    size_t first = reading->id_count;
    bool valid = sqlite3_column_type(statement, 4) == SQLITE_TEXT;
    const char *text = valid ? (const char *)sqlite3_column_text(statement, 4) : NULL;
    valid = text && strlen(text) == (size_t)sqlite3_column_bytes(statement, 4);
    enum vw_status status =
        vw_grow((void **)&reading->rows, &reading->capacity, reading->count + 1, sizeof *reading->rows);
    if (!status && valid) status = read_ids(ledger, text, reading, &valid);
    if (status) return status;
    uint64_t number = vw_ledger_read_count(ledger, statement, 0, INT64_MAX, &status);
    reading->rows[reading->count] = (struct vw_ledger_retraining){
        .whole_providers = vw_ledger_read_count(ledger, statement, 1, 1, &status) == 1,
        .seed = vw_ledger_read_count(ledger, statement, 2, INT64_MAX, &status),
        .epochs = (uint32_t)vw_ledger_read_count(ledger, statement, 3, UINT32_MAX, &status),
        .image_count = (uint32_t)(reading->id_count - first),
        .val_psnr = vw_ledger_read_real(ledger, statement, 5, &status)};
    if (!status && (!valid || number != reading->count))
        status = vw_fail(VW_ERROR_INPUT,
                         "%s: damaged: row %zu of table retraining has an invalid number or list of photos; restore "
                         "the file from a copy",
                         ledger->database.path, reading->count);
    reading->count++;
    return status;
}

// Joins everything in one block: the rows, followed by their ids.
static enum vw_status join(const struct reading *reading, struct vw_ledger_retraining **retrainings) {
    size_t rows_bytes = reading->count * sizeof **retrainings;
    struct vw_ledger_retraining *rows = vw_allocate(rows_bytes + reading->id_count * sizeof *reading->ids, 1);
    if (!rows) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(rows + reading->count);
    if (reading->count) memcpy(rows, reading->rows, rows_bytes);
    if (reading->id_count) memcpy(ids, reading->ids, reading->id_count * sizeof *ids);
    for (size_t i = 0; i < reading->count; i++) {
        rows[i].image_ids = ids;
        ids += rows[i].image_count;
    }
    *retrainings = rows;
    return VW_OK;
}

enum vw_status vw_ledger_get_retrainings(struct vw_ledger *ledger, struct vw_ledger_retraining **retrainings,
                                         uint32_t *count) {
    const struct vw_ledger_image *images = NULL;
    uint32_t image_count = 0;
    struct reading reading = {0};
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status)
        status = vw_database_prepare(&ledger->database,
                                     "SELECT retraining, whole_providers, seed, epochs, image_ids, val_psnr FROM "
                                     "retraining ORDER BY run_id, retraining",
                                     &statement);
    while (!status && !(status = vw_database_next(&ledger->database, statement, &found)) && found)
        status = read_row(ledger, statement, &reading);
    sqlite3_finalize(statement);
    if (!status) status = join(&reading, retrainings);
    if (!status) *count = (uint32_t)reading.count;
    free(reading.rows);
    free(reading.ids);
    return status;
}
