#include "ledger/sweeps.h"

#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text_stream.h"
#include "ledger/database_open.h"
#include "ledger/table.h"

// In a series of its own: see vw_database_format.
enum { SWEEPS_VERSION = 2001 };

// The metrics are the first member of a row, so that their columns are also those of struct vw_sweep_metrics.
struct metric_row {
    struct vw_sweep_metrics metrics;
    uint32_t place;
};
#define SHOWN(column_kind, member, heading, digits_shown)                                                              \
    { VW_CELL(#member, struct vw_sweep_metrics, column_kind, member), .title = heading, .digits = digits_shown }
static const struct vw_column metric_columns[] = {
    VW_COLUMN_OF_OWNER("sweep_id"),
    VW_COLUMN(struct metric_row, COUNT, place),
    SHOWN(TEXT, configuration, "configuration", 0),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, parameter),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, value),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, base),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, epochs),
    VW_COLUMN(struct vw_sweep_metrics, COUNT, steps),
    SHOWN(REAL_OR_NULL, train_ms, "step, ms", 2),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, value_ms),
    SHOWN(REAL_OR_NULL, scoring_ratio, "ratio", 2),
    SHOWN(REAL_OR_NULL, run_seconds, "run, s", 1),
    SHOWN(REAL_OR_NULL, device_mib, "MiB", 1),
    SHOWN(REAL_OR_NULL, val_psnr, "PSNR, dB", 2),
    SHOWN(COUNT, psnr_pareto_front, "front by PSNR", 0),
    VW_COLUMN(struct vw_sweep_metrics, TEXT, method),
    SHOWN(COUNT, score_pareto_front, "front by scores", 0),
    SHOWN(REAL_OR_NULL, seed_pearson, "r seeds", 3),
    SHOWN(REAL_OR_NULL, seed_spearman, "rho", 3),
    SHOWN(REAL_OR_NULL, agreement_pearson, "r reference", 3),
    SHOWN(REAL_OR_NULL, agreement_spearman, "rho", 3),
    SHOWN(REAL_OR_NULL, all_pixels_pearson, "r all pixels", 3),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, all_pixels_spearman),
    SHOWN(REAL_OR_NULL, auc, "AUC", 2),
    SHOWN(REAL_OR_NULL, lds, "LDS", 2),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, lds_ci_low),
    VW_COLUMN(struct vw_sweep_metrics, REAL_OR_NULL, lds_ci_high),
};

enum { KEY_COUNT = 2 };
static const struct vw_table metric_table = {VW_TABLE("metric", struct metric_row, metric_columns),
                                             .doing = "record a metric"};

struct vw_rows vw_sweep_rows(const struct vw_sweep_metrics *metrics, uint32_t count) {
    struct vw_rows rows = VW_ROWS(metric_columns, metrics, count);
    rows.columns += KEY_COUNT;
    rows.column_count -= KEY_COUNT;
    return rows;
}

struct vw_sweeps {
    struct vw_database database;
};

// ---- The file ----

static const char *const types[] = {
    [VW_COLUMN_TEXT] = "TEXT NOT NULL", [VW_COLUMN_COUNT] = "INTEGER NOT NULL", [VW_COLUMN_REAL_OR_NULL] = "REAL"};

// Writes the statements that make the tables. The caller owns them.
static char *write_schema(void) {
    char *sql = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream text;
    FILE *stream = vw_text_stream_open(&text);
    if (stream)
        fputs("CREATE TABLE measurement (configuration_id TEXT NOT NULL, quantity TEXT NOT NULL, value REAL, "
              "row_hash TEXT NOT NULL, PRIMARY KEY (configuration_id, quantity)) WITHOUT ROWID;"
              "CREATE TABLE metric (sweep_id TEXT NOT NULL, place INTEGER NOT NULL",
              stream);
    for (int i = KEY_COUNT; stream && i < metric_table.column_count; i++)
        fprintf(stream, ", %s %s", metric_columns[i].name, types[metric_columns[i].kind]);
    if (stream)
        fprintf(stream, ", PRIMARY KEY (sweep_id, place)) WITHOUT ROWID; PRAGMA user_version = %d;", SWEEPS_VERSION);
    return vw_text_stream_close(&text, "statement", &sql, &size_bytes) ? NULL : sql;
}

static enum vw_status open_file(const char *path, struct vw_database *database) {
    char *schema_sql = write_schema();
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

static const struct vw_column measurement_columns[] = {
    VW_COLUMN_OF_OWNER("configuration_id"),
    VW_COLUMN(struct vw_measurement, TEXT, quantity),
    VW_COLUMN(struct vw_measurement, REAL_OR_NULL, value),
};
static const struct vw_table measurement_table = {VW_TABLE("measurement", struct vw_measurement, measurement_columns),
                                                  .doing = "record a measurement",
                                                  .has_hash = true,
                                                  .hashed_as = "viewworth measurement row 1",
                                                  .key_count = 2,
                                                  .insert = "INSERT OR REPLACE"};

enum vw_status vw_sweeps_find(struct vw_sweeps *sweeps, const char *configuration_id, const char *quantity, bool *found,
                              double *value) {
    struct vw_measurement row = {.quantity = quantity};
    enum vw_found there = VW_ROW_ABSENT;
    enum vw_status status = vw_table_find(&sweeps->database, &measurement_table, configuration_id, &row, &there);
    if (status) return status;
    if (there == VW_ROW_EDITED)
        return vw_fail(
            VW_ERROR_MISMATCH,
            "%s: measurement %s of %s was edited: its row_hash does not match; delete the row to measure it again",
            sweeps->database.path, quantity, configuration_id);
    *found = there == VW_ROW_FOUND;
    if (*found) *value = row.value;
    return VW_OK;
}

enum vw_status vw_sweeps_keep(struct vw_sweeps *sweeps, const char *configuration_id,
                              const struct vw_measurement *measurements, uint32_t count) {
    struct vw_database *database = &sweeps->database;
    enum vw_status status = vw_database_begin(database);
    if (status) return status;
    return vw_database_end(database,
                           vw_table_insert(database, &measurement_table, configuration_id, measurements, count, NULL));
}

// ---- Metrics ----

static enum vw_status insert_metrics(struct vw_database *database, const char *sweep_id,
                                     const struct vw_sweep_metrics *metrics, uint32_t count) {
    struct vw_insertion insertion;
    enum vw_status status = vw_insertion_begin(database, &metric_table, sweep_id, &insertion);
    for (uint32_t i = 0; i < count && !status; i++) {
        const struct metric_row row = {metrics[i], i};
        status = vw_insertion_add(&insertion, &row);
    }
    vw_insertion_end(&insertion);
    return status;
}

enum vw_status vw_sweeps_set_metrics(struct vw_sweeps *sweeps, const char *sweep_id,
                                     const struct vw_sweep_metrics *metrics, uint32_t count) {
    struct vw_database *database = &sweeps->database;
    enum vw_status status = vw_database_begin(database);
    if (status) return status;
    status =
        vw_database_run_with(database, "DELETE FROM metric WHERE sweep_id = ?", sweep_id, NULL, "remove old metrics");
    if (!status) status = insert_metrics(database, sweep_id, metrics, count);
    return vw_database_end(database, status);
}
