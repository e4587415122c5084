#include "ledger/schema.h"

// Keys begin with the run (or scene), so that ledgers of several runs can be merged into one file. Tables WITHOUT ROWID
// store rows in key order, which is also the order of hashing. View and probe rows are written before their step row,
// because its hash covers them: therefore their references are deferred. Scores have a rowid: it records the order in
// which the methods were written. Earlier versions recorded probes of the kind first_order; none does now, and the list
// of kinds stays, so that their other ledgers are still read.
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
    "CREATE TABLE probe ("
    " run_id TEXT NOT NULL, step INTEGER NOT NULL, probe INTEGER NOT NULL,"
    " kind TEXT NOT NULL CHECK (kind IN ('repeated', 'zero_learning_rate', 'resampled', 'same_state', 'first_order')),"
    " val_psnr REAL, val_psnr_pooled REAL, val_l1 REAL, image_id INTEGER,"
    " PRIMARY KEY (run_id, step, probe),"
    " FOREIGN KEY (run_id, step) REFERENCES step (run_id, step) DEFERRABLE INITIALLY DEFERRED) WITHOUT ROWID;"
    "CREATE TABLE score ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), image_id INTEGER NOT NULL, method TEXT NOT NULL,"
    " value REAL NOT NULL, unit TEXT NOT NULL, stderr REAL, visits INTEGER NOT NULL, resampling_stderr REAL, ci_low "
    "REAL, ci_high REAL,"
    " rank_ci_low INTEGER, rank_ci_high INTEGER,"
    " PRIMARY KEY (run_id, image_id, method));"
    "CREATE TABLE retraining ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), retraining INTEGER NOT NULL,"
    " whole_providers INTEGER NOT NULL CHECK (whole_providers IN (0, 1)), seed INTEGER NOT NULL,"
    " epochs INTEGER NOT NULL, image_ids TEXT NOT NULL, val_psnr REAL,"
    " PRIMARY KEY (run_id, retraining)) WITHOUT ROWID;"
    "PRAGMA user_version = 7;";

_Static_assert(VW_SCHEMA_VERSION == 7, "raise user_version above too");

// A ledger gets these tables with its first sweep, so that all others stay as earlier versions write and read them.
static const char lasting_sql[] =
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
    "CREATE TABLE lasting_photo ("
    " run_id TEXT NOT NULL REFERENCES run (run_id), image_id INTEGER NOT NULL, coverage REAL NOT NULL,"
    " PRIMARY KEY (run_id, image_id)) WITHOUT ROWID;"
    "PRAGMA user_version = 8;";

_Static_assert(VW_SCHEMA_VERSION_LASTING == 8, "raise user_version above too");

// A ledger gets this one with its first sweep by validation photo.
static const char lasting_views_sql[] =
    "CREATE TABLE lasting_view ("
    " run_id TEXT NOT NULL, step INTEGER NOT NULL, image_id INTEGER NOT NULL, psnr REAL NOT NULL,"
    " PRIMARY KEY (run_id, step, image_id), FOREIGN KEY (run_id, step) REFERENCES step (run_id, step)) WITHOUT ROWID;"
    "PRAGMA user_version = 9;";

_Static_assert(VW_SCHEMA_VERSION_LASTING_VIEWS == 9, "raise user_version above too");

const struct vw_database_format vw_ledger_format = {
    schema_sql,
    VW_SCHEMA_VERSION,
    "a viewworth ledger",
    {{lasting_sql, VW_SCHEMA_VERSION_LASTING}, {lasting_views_sql, VW_SCHEMA_VERSION_LASTING_VIEWS}}};
