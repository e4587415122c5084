#include "ledger/schema.h"

// Keys begin with the run (or scene), so that ledgers of several runs can be merged into one file. Tables WITHOUT ROWID
// store rows in key order, which is also the order of hashing. View rows are written before their step row,
// because its hash covers them: therefore their references are deferred. Scores have a rowid: it records the order in
// which the methods were written. The tables of lasting credit are empty in a run without it.
static const char schema_sql[] =
    "CREATE TABLE run ("
    " run_id TEXT PRIMARY KEY NOT NULL, scene_hash TEXT NOT NULL, scene_path TEXT NOT NULL, seed INTEGER NOT NULL,"
    " config_json TEXT NOT NULL, subset_hash TEXT NOT NULL, device TEXT NOT NULL, driver TEXT NOT NULL,"
    " shader_hash TEXT NOT NULL, version TEXT NOT NULL, started_utc TEXT NOT NULL,"
    " finished_utc TEXT, status TEXT NOT NULL, row_hash TEXT NOT NULL, final_hash TEXT NOT NULL, scene_options_json "
    "TEXT NOT NULL,"
    " effects_json TEXT NOT NULL, plan_json TEXT NOT NULL, field_sha256 TEXT);"
    "CREATE TABLE image ("
    " image_id INTEGER NOT NULL, scene_hash TEXT NOT NULL, name TEXT NOT NULL,"
    " split TEXT NOT NULL CHECK (split IN ('train', 'val', 'test', 'excluded')),"
    " provider TEXT, sha256 TEXT, ground_truth TEXT,"
    " PRIMARY KEY (scene_hash, image_id), UNIQUE (scene_hash, name)) WITHOUT ROWID;"
    "CREATE TABLE step ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), step INTEGER NOT NULL, epoch INTEGER NOT NULL, image_id INTEGER,"
    " train_loss REAL, val_psnr REAL, val_psnr_pooled REAL, val_l1 REAL,"
    " nonfinite INTEGER NOT NULL CHECK (nonfinite IN (0, 1)), row_hash TEXT NOT NULL, clamped INTEGER NOT NULL,"
    " floored INTEGER NOT NULL,"
    " PRIMARY KEY (run_id, step)) WITHOUT ROWID;"
    "CREATE TABLE view ("
    " run_id TEXT NOT NULL, step INTEGER NOT NULL, image_id INTEGER NOT NULL, mse REAL NOT NULL, l1 REAL NOT NULL,"
    " PRIMARY KEY (run_id, step, image_id),"
    " FOREIGN KEY (run_id, step) REFERENCES step (run_id, step) DEFERRABLE INITIALLY DEFERRED) WITHOUT ROWID;"
    "CREATE TABLE score ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), image_id INTEGER NOT NULL, method TEXT NOT NULL,"
    " value REAL NOT NULL, unit TEXT NOT NULL, stderr REAL, visits INTEGER NOT NULL, ci_low REAL, ci_high REAL,"
    " rank_ci_low INTEGER, rank_ci_high INTEGER,"
    " PRIMARY KEY (run_id, image_id, method));"
    "CREATE TABLE retraining ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), retraining INTEGER NOT NULL,"
    " seed INTEGER NOT NULL,"
    " epochs INTEGER NOT NULL, image_ids TEXT NOT NULL, val_psnr REAL,"
    " PRIMARY KEY (run_id, retraining)) WITHOUT ROWID;"
    "CREATE TABLE lasting ("
    " run_id TEXT PRIMARY KEY NOT NULL REFERENCES run (run_id), rays INTEGER NOT NULL, epochs INTEGER NOT NULL,"
    " states INTEGER NOT NULL, row_hash TEXT NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE lasting_step ("
    " run_id TEXT NOT NULL, step INTEGER NOT NULL, psnr REAL NOT NULL, loss REAL NOT NULL, size_psnr REAL NOT NULL,"
    " size_loss REAL NOT NULL,"
    " PRIMARY KEY (run_id, step), FOREIGN KEY (run_id, step) REFERENCES step (run_id, step)) WITHOUT ROWID;"
    "CREATE TABLE lasting_check ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), image_id INTEGER NOT NULL, from_step INTEGER NOT NULL,"
    " predicted_psnr REAL NOT NULL, measured_psnr REAL, predicted_loss REAL NOT NULL, measured_loss REAL,"
    " PRIMARY KEY (run_id, image_id)) WITHOUT ROWID;"
    "CREATE TABLE lasting_view ("
    " run_id TEXT NOT NULL, step INTEGER NOT NULL, image_id INTEGER NOT NULL, psnr REAL NOT NULL,"
    " PRIMARY KEY (run_id, step, image_id), FOREIGN KEY (run_id, step) REFERENCES step (run_id, step)) WITHOUT ROWID;"
    "CREATE TABLE payout_request ("
    " run_id TEXT PRIMARY KEY NOT NULL REFERENCES run (run_id), cents INTEGER NOT NULL) WITHOUT ROWID;"
    "PRAGMA user_version = 3;";

_Static_assert(VW_SCHEMA_VERSION == 3, "raise user_version above too");

const struct vw_database_format vw_ledger_format = {schema_sql, VW_SCHEMA_VERSION, "a viewworth ledger"};

// ---- The same tables by their columns, in the order in which ledger.h says that they are hashed ---------------------

#define RUN_ID VW_COLUMN_OF_OWNER("run_id")

static const struct vw_column run_columns[] = {
    VW_COLUMN(struct vw_ledger_run, TEXT, run_id),
    VW_COLUMN(struct vw_ledger_run, TEXT, scene_hash),
    VW_COLUMN(struct vw_ledger_run, TEXT, scene_path),
    VW_COLUMN(struct vw_ledger_run, COUNT64, seed),
    VW_COLUMN(struct vw_ledger_run, TEXT, config_json),
    VW_COLUMN(struct vw_ledger_run, TEXT, subset_hash),
    VW_COLUMN(struct vw_ledger_run, NAME, device),
    VW_COLUMN(struct vw_ledger_run, NAME, driver),
    VW_COLUMN(struct vw_ledger_run, TEXT, shader_hash),
    VW_COLUMN(struct vw_ledger_run, NAME, version),
    VW_COLUMN(struct vw_ledger_run, TEXT, started_utc),
    VW_COLUMN(struct vw_ledger_run, TEXT, scene_options_json),
    VW_COLUMN(struct vw_ledger_run, TEXT, effects_json),
    VW_COLUMN(struct vw_ledger_run, TEXT, plan_json),
    VW_COLUMN(struct vw_ledger_run, TEXT, status),
    VW_COLUMN(struct vw_ledger_run, TEXT_OR_NULL, finished_utc),
    VW_COLUMN(struct vw_ledger_run, TEXT_OR_NULL, field_sha256),
    VW_COLUMN(struct vw_sealed_run, TEXT, row_hash),
    VW_COLUMN(struct vw_sealed_run, TEXT, final_hash),
};
const struct vw_table vw_run_table = {VW_TABLE("run", struct vw_sealed_run, run_columns), .order = "run_id",
                                      .doing = "record the run"};

static const struct vw_column image_columns[] = {
    VW_COLUMN(struct vw_ledger_image, COUNT, image_id),
    VW_COLUMN_OF_OWNER("scene_hash"),
    VW_COLUMN(struct vw_ledger_image, TEXT, name),
    VW_COLUMN(struct vw_ledger_image, TEXT, split),
    VW_COLUMN(struct vw_ledger_image, TEXT_OR_NULL, provider),
    VW_COLUMN(struct vw_ledger_image, TEXT_OR_NULL, sha256),
    VW_COLUMN(struct vw_ledger_image, TEXT_OR_NULL, ground_truth),
};
const struct vw_table vw_image_table = {VW_TABLE("image", struct vw_ledger_image, image_columns),
                                        .order = "scene_hash, image_id", .doing = "record the images"};

static const struct vw_column step_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_step_record, COUNT64, step),
    VW_COLUMN(struct vw_step_record, COUNT, epoch),
    VW_COLUMN_AS("image_id", struct vw_step_record, IMAGE_OR_NULL, view),
    VW_COLUMN(struct vw_step_record, REAL_OR_NULL, train_loss),
    VW_COLUMN(struct vw_step_record, REAL_OR_NULL, val_psnr),
    VW_COLUMN(struct vw_step_record, REAL_OR_NULL, val_psnr_pooled),
    VW_COLUMN(struct vw_step_record, REAL_OR_NULL, val_l1),
    VW_COLUMN(struct vw_step_record, FLAG, nonfinite),
    VW_COLUMN_AS("clamped", struct vw_step_record, COUNT64, clamped_count),
    VW_COLUMN_AS("floored", struct vw_step_record, COUNT, floored_views),
};
const struct vw_table vw_step_table = {VW_TABLE("step", struct vw_step_record, step_columns), .order = "run_id, step",
                                       .doing = "record a step", .has_hash = true};

static const struct vw_column view_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_view_row, COUNT64, step),
    VW_COLUMN(struct vw_view_row, IMAGE, image_id),
    VW_COLUMN(struct vw_view_row, REAL, mse),
    VW_COLUMN(struct vw_view_row, REAL, l1),
};
const struct vw_table vw_view_table = {VW_TABLE("view", struct vw_view_row, view_columns),
                                       .order = "run_id, step, image_id", .doing = "record a validation view"};

static const struct vw_column score_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_ledger_score, IMAGE, image_id),
    VW_COLUMN(struct vw_ledger_score, TEXT, method),
    VW_COLUMN(struct vw_ledger_score, REAL, value),
    VW_COLUMN(struct vw_ledger_score, TEXT, unit),
    VW_COLUMN_AS("stderr", struct vw_ledger_score, REAL_OR_NULL, standard_error),
    VW_COLUMN(struct vw_ledger_score, COUNT, visits),
    VW_COLUMN(struct vw_ledger_score, REAL_OR_NULL, ci_low),
    VW_COLUMN(struct vw_ledger_score, REAL_OR_NULL, ci_high),
    VW_COLUMN(struct vw_ledger_score, RANK, rank_ci_low),
    VW_COLUMN(struct vw_ledger_score, RANK, rank_ci_high),
};
const struct vw_table vw_score_table = {VW_TABLE("score", struct vw_ledger_score, score_columns), .order = "rowid",
                                        .doing = "record a score"};

static const struct vw_column retraining_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_retraining_row, COUNT64, retraining),
    VW_COLUMN(struct vw_retraining_row, COUNT64, seed),
    VW_COLUMN(struct vw_retraining_row, COUNT, epochs),
    VW_COLUMN(struct vw_retraining_row, TEXT, image_ids),
    VW_COLUMN(struct vw_retraining_row, REAL_OR_NULL, val_psnr),
};
const struct vw_table vw_retraining_table = {VW_TABLE("retraining", struct vw_retraining_row, retraining_columns),
                                             .order = "run_id, retraining", .doing = "record a retraining"};

static const struct vw_column payout_request_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_payout_request, COUNT64, cents),
};
const struct vw_table vw_payout_request_table = {
    VW_TABLE("payout_request", struct vw_payout_request, payout_request_columns), .order = "run_id",
    .doing = "record what a payout was asked for"};

static const struct vw_column lasting_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_lasting_pass, COUNT, rays),
    VW_COLUMN(struct vw_lasting_pass, COUNT, epochs),
    VW_COLUMN(struct vw_lasting_pass, COUNT, states),
};
const struct vw_table vw_lasting_table = {VW_TABLE("lasting", struct vw_lasting_pass, lasting_columns),
                                          .order = "run_id", .doing = "record the settings of lasting credit",
                                          .has_hash = true};

static const struct vw_column lasting_step_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_lasting_step, COUNT64, step),
    VW_COLUMN(struct vw_lasting_step, REAL, psnr),
    VW_COLUMN(struct vw_lasting_step, REAL, loss),
    VW_COLUMN(struct vw_lasting_step, REAL, size_psnr),
    VW_COLUMN(struct vw_lasting_step, REAL, size_loss),
};
const struct vw_table vw_lasting_step_table = {VW_TABLE("lasting_step", struct vw_lasting_step, lasting_step_columns),
                                               .order = "run_id, step", .doing = "record the lasting credit of a step"};

static const struct vw_column lasting_check_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_gate_check, IMAGE, image_id),
    VW_COLUMN(struct vw_gate_check, COUNT64, from_step),
    VW_COLUMN(struct vw_gate_check, REAL, predicted_psnr),
    VW_COLUMN(struct vw_gate_check, REAL_OR_NULL, measured_psnr),
    VW_COLUMN(struct vw_gate_check, REAL, predicted_loss),
    VW_COLUMN(struct vw_gate_check, REAL_OR_NULL, measured_loss),
};
const struct vw_table vw_lasting_check_table = {VW_TABLE("lasting_check", struct vw_gate_check, lasting_check_columns),
                                                .order = "run_id, image_id", .doing = "record a photo of the gate"};

static const struct vw_column lasting_view_columns[] = {
    RUN_ID,
    VW_COLUMN(struct vw_lasting_view_row, COUNT64, step),
    VW_COLUMN(struct vw_lasting_view_row, IMAGE, image_id),
    VW_COLUMN(struct vw_lasting_view_row, REAL, psnr),
};
const struct vw_table vw_lasting_view_table = {
    VW_TABLE("lasting_view", struct vw_lasting_view_row, lasting_view_columns), .order = "run_id, step, image_id",
    .doing = "record the lasting credit of a validation photo"};
