#include "ledger/sweeps.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "ledger/database_open.h"

// In a series of its own: see vw_database_format.
enum { SWEEPS_VERSION = 2001 };
static const char hashed_as[] = "viewworth measurement row 1";

#define COLUMN(member, of_kind)                                                                                        \
    { #member, VW_COLUMN_##of_kind, offsetof(struct vw_sweep_metrics, member) }
static const struct vw_sweep_column columns[] = {
    COLUMN(configuration, TEXT),
    COLUMN(parameter, TEXT),
    COLUMN(value, TEXT),
    COLUMN(base, WHOLE),
    COLUMN(epochs, WHOLE),
    COLUMN(steps, WHOLE),
    COLUMN(train_ms, REAL),
    COLUMN(value_ms, REAL),
    COLUMN(scoring_ratio, REAL),
    COLUMN(run_seconds, REAL),
    COLUMN(device_mib, REAL),
    COLUMN(val_psnr, REAL),
    COLUMN(psnr_pareto_front, WHOLE),
    COLUMN(method, TEXT),
    COLUMN(score_pareto_front, WHOLE),
    COLUMN(seed_pearson, REAL),
    COLUMN(seed_spearman, REAL),
    COLUMN(agreement_pearson, REAL),
    COLUMN(agreement_spearman, REAL),
    COLUMN(all_pixels_pearson, REAL),
    COLUMN(all_pixels_spearman, REAL),
    COLUMN(auc, REAL),
    COLUMN(lds, REAL),
    COLUMN(lds_ci_low, REAL),
    COLUMN(lds_ci_high, REAL),
};

const struct vw_sweep_column *vw_sweep_columns(uint32_t *count) {
    *count = VW_ARRAY_COUNT(columns);
    return columns;
}

struct vw_sweeps {
    struct vw_database database;
};

// ---- The file ----

static const char *const types[] = {
    [VW_COLUMN_TEXT] = "TEXT NOT NULL", [VW_COLUMN_WHOLE] = "INTEGER NOT NULL", [VW_COLUMN_REAL] = "REAL"};

// Writes a statement with a part for every column: its definition, or a placeholder for its value. The caller owns it.
static char *write_sql(const char *before, bool defines, const char *behind) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream statement;
    FILE *stream = vw_text_stream_open(&statement);
    if (stream) fputs(before, stream);
    for (size_t i = 0; stream && i < VW_ARRAY_COUNT(columns); i++)
        if (defines) fprintf(stream, ", %s %s", columns[i].name, types[columns[i].kind]);
        else fputs(", ?", stream);
    if (stream) fputs(behind, stream);
    return vw_text_stream_close(&statement, "statement", &text, &size_bytes) ? NULL : text;
}

static enum vw_status open_file(const char *path, struct vw_database *database) {
    char *schema_sql = write_sql("CREATE TABLE measurement (configuration_id TEXT NOT NULL, quantity TEXT NOT NULL, "
                                 "value REAL, row_hash TEXT NOT NULL,"
                                 " PRIMARY KEY (configuration_id, quantity)) WITHOUT ROWID;"
                                 "CREATE TABLE metric (sweep_id TEXT NOT NULL, place INTEGER NOT NULL",
                                 true, ", PRIMARY KEY (sweep_id, place)) WITHOUT ROWID; PRAGMA user_version = 2001;");
    _Static_assert(SWEEPS_VERSION == 2001, "write it into the statement, too");
    const struct vw_database_format format = {
        .schema_sql = schema_sql, .version = SWEEPS_VERSION, .what = "the results of a sweep"};
    enum vw_status status = schema_sql ? vw_database_open_or_create(path, &format, database) : VW_ERROR_MEMORY;
    free(schema_sql);
    return status;
}

enum vw_status vw_sweeps_open(const char *path, struct vw_sweeps **sweeps) {
    struct vw_sweeps *opened = vw_allocate(1, sizeof *opened);
    if (!opened) return VW_ERROR_MEMORY;
    enum vw_status status = open_file(path, &opened->database);
    if (status) vw_sweeps_close(&opened);
    else *sweeps = opened;
    return status;
}

void vw_sweeps_close(struct vw_sweeps **sweeps) {
    if (!*sweeps) return;
    vw_database_close(&(*sweeps)->database);
    free(*sweeps);
    *sweeps = NULL;
}

// ---- Measurements ----

enum { VALUE = 2, ROW_HASH = 3 }; // columns

enum vw_status vw_sweeps_find(struct vw_sweeps *sweeps, const char *configuration_id, const char *quantity, bool *found,
                              double *value) {
    struct vw_database *database = &sweeps->database;
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(database,
                                                "SELECT configuration_id, quantity, value, row_hash FROM measurement "
                                                "WHERE configuration_id = ? AND quantity = ?",
                                                &row.statement);
    vw_row_add_text(&row, configuration_id);
    vw_row_add_text(&row, quantity);
    if (!status && row.failed) status = vw_database_fail(database, "find a measurement");
    if (!status) status = vw_database_next(database, row.statement, found);
    if (!status && *found) *value = vw_row_read_real(row.statement, VALUE);
    if (!status && *found && !vw_row_fits_hash(row.statement, ROW_HASH, hashed_as))
        status = vw_fail(
            VW_ERROR_MISMATCH,
            "%s: measurement %s of %s was edited: its row_hash does not match; delete the row to measure it again",
            database->path, quantity, configuration_id);
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_sweeps_keep(struct vw_sweeps *sweeps, const char *configuration_id,
                              const struct vw_measurement *measurements, uint32_t count) {
    struct vw_database *database = &sweeps->database;
    struct vw_hasher hasher;
    struct vw_row row = {0};
    enum vw_status status = vw_database_begin(database);
    if (status) return status;
    status = vw_database_prepare(
        database,
        "INSERT OR REPLACE INTO measurement (configuration_id, quantity, value, row_hash) VALUES (?, ?, ?, ?)",
        &row.statement);
    for (uint32_t i = 0; i < count && !status; i++) {
        char hash[VW_HASH_HEX_BYTES];
        row.hasher = &hasher;
        vw_row_begin_hash(&hasher, hashed_as);
        vw_row_add_text(&row, configuration_id);
        vw_row_add_text(&row, measurements[i].quantity);
        vw_row_add_real(&row, measurements[i].value);
        vw_row_end_hash(&hasher, hash);
        row.hasher = NULL;
        vw_row_add_text(&row, hash);
        status = vw_row_write(&row, database, "record a measurement");
    }
    sqlite3_finalize(row.statement);
    return vw_database_end(database, status);
}

// ---- Metrics ----

static enum vw_status remove_metrics(struct vw_database *database, const char *sweep_id) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(database, "DELETE FROM metric WHERE sweep_id = ?", &row.statement);
    vw_row_add_text(&row, sweep_id);
    if (!status) status = vw_row_write(&row, database, "remove old metrics");
    sqlite3_finalize(row.statement);
    return status;
}

static void add_metric(struct vw_row *row, const struct vw_sweep_metrics *metric) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(columns); i++) {
        const void *value = (const char *)metric + columns[i].offset;
        switch (columns[i].kind) {
        case VW_COLUMN_TEXT: vw_row_add_text(row, *(const char *const *)value); break;
        case VW_COLUMN_WHOLE: vw_row_add_integer(row, *(const uint32_t *)value); break;
        case VW_COLUMN_REAL: vw_row_add_real(row, *(const double *)value); break;
        }
    }
}

static enum vw_status insert_metrics(struct vw_database *database, const char *sweep_id,
                                     const struct vw_sweep_metrics *metrics, uint32_t count) {
    struct vw_row row = {0};
    char *sql = write_sql("INSERT INTO metric VALUES (?, ?", false, ")");
    if (!sql) return VW_ERROR_MEMORY;
    enum vw_status status = vw_database_prepare(database, sql, &row.statement);
    for (uint32_t i = 0; i < count && !status; i++) {
        vw_row_add_text(&row, sweep_id);
        vw_row_add_integer(&row, i);
        add_metric(&row, &metrics[i]);
        status = vw_row_write(&row, database, "record a metric");
    }
    sqlite3_finalize(row.statement);
    free(sql);
    return status;
}

enum vw_status vw_sweeps_set_metrics(struct vw_sweeps *sweeps, const char *sweep_id,
                                     const struct vw_sweep_metrics *metrics, uint32_t count) {
    struct vw_database *database = &sweeps->database;
    enum vw_status status = vw_database_begin(database);
    if (status) return status;
    status = remove_metrics(database, sweep_id);
    if (!status) status = insert_metrics(database, sweep_id, metrics, count);
    return vw_database_end(database, status);
}
