// The ledger: OUT/ledger.db, an SQLite file with the tables of the contract (run, image, step, view, score) and one
// more: probe(run_id, step, probe, kind, val_psnr, val_psnr_pooled, val_l1, image_id), kind in repeat, still, redraw,
// same_state, first_order: vw_step_record.probes; image_id is NULL where a probe is of the step's own photo. One run
// per OUT.
//
// Rows are hash-chained, each hash over the values in the order named here, rows in the order of their keys:
// - run.row_hash: run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version, and all image rows.
// - step.row_hash: the row_hash before it (step 0: the run's), the step's other columns, its view rows and its probe
// rows.
// - run.final_hash: the last row_hash (of the run itself while its status is "running"), scene_path, config_json,
// scene_options_json,
//   effects_json, plan_json, started_utc, finished_utc, status, and all score rows.
// So the chain of the steps depends only on what the run is: the same command gives it again, and a run that is later
// extended keeps it. (What config_json says of the run's identity is in run_id.)
//
// Every append is one synced transaction in rollback-journal mode.
#ifndef VIEWWORTH_LEDGER_H
#define VIEWWORTH_LEDGER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/types.h"
#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

struct vw_ledger;

struct vw_ledger_run {
    const char *run_id;     // 64 hex digits
    const char *scene_hash; // 64 hex digits
    const char *scene_path;
    int64_t seed;
    const char *config_json;
    const char *subset_hash; // 64 hex digits: of the names trained on
    const char *device, *driver;
    const char *shader_hash; // 64 hex digits
    const char *version;
    const char *started_utc;        // ISO 8601, "2026-11-21T03:04:05Z"
    const char *scene_options_json; // the options the scene was opened with, "{}" without any, or the hash of an
                                    // imported log (appended)
    const char *effects_json;       // the verdict on every effect, with its evidence (appended column; decision 7)
    const char
        *plan_json;     // what --accuracy or --budget chose (cli/choice.h); "{}" or NULL: nothing was chosen (appended)
    const char *status; // "running", "finished", "interrupted", "failed"; ignored by vw_ledger_create: "running"
    const char
        *finished_utc; // when it had last ended when the ledger was opened, NULL: not yet; ignored by vw_ledger_create
};

struct vw_ledger_image {
    uint32_t image_id; // the view's index in the scene
    const char *name, *split, *provider;
    const char *sha256;       // 64 hex digits
    const char *ground_truth; // NULL, or the recipe's injected defect (appended column)
};

struct vw_ledger_score {
    uint32_t image_id;
    const char *method;       // "dv_psnr", "dv_loss", "dv_psnr_pooled", ...
    double value;             // positive = helps
    const char *unit;         // "dB", "mean absolute error"
    double standard_error;    // NaN becomes NULL
    uint32_t visits;          // steps that count into the value
    double resampling_stderr; // see value.h; NaN becomes NULL (appended column)
    double ci_low, ci_high;   // 95 % interval of the value over seeds; NaN becomes NULL (appended columns)
    uint32_t rank_ci_low,
        rank_ci_high; // 95 % interval of its rank in the method, 1 = most valuable; 0 becomes NULL (appended columns)
};

// Creates `path`; a file that exists is VW_ERROR_USAGE.
enum vw_status vw_ledger_create(const char *path, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                uint32_t image_count, struct vw_ledger **ledger);
// Opens an existing ledger, to read it or to go on appending after its last step. VW_ERROR_INPUT when it is not one.
enum vw_status vw_ledger_open(const char *path, struct vw_ledger **ledger);
void vw_ledger_close(struct vw_ledger **ledger);

// Appends steps and their view rows as one synced transaction. `validation_views` gives the image_id of each entry of
// record->views.
enum vw_status vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                const uint32_t *validation_views);
// Replaces the run's scores and sets finished_utc, status ("finished", "interrupted", "failed") and final_hash, in one
// transaction.
enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count);

// The config with which the run goes on: only what is no part of the run's identity (epochs) may differ. Written with
// the next append or finish.
enum vw_status vw_ledger_extend(struct vw_ledger *ledger, const char *config_json);
uint64_t vw_ledger_next_step(const struct vw_ledger *ledger); // the one that the next append has to begin with
// The hash that stands for all the ledger holds: final_hash once the run has ended, else the last row_hash.
void vw_ledger_chain_head(const struct vw_ledger *ledger, char head[VW_HASH_HEX_BYTES]);
// Holds steps that were taken again against the recorded ones, bit for bit: records[0].step + count must not pass
// vw_ledger_next_step. VW_ERROR_MISMATCH names the first step that differs.
enum vw_status vw_ledger_compare(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                 const uint32_t *validation_views);
// Recomputes every hash. VW_ERROR_MISMATCH names the first row that was edited, removed, added or reordered: run,
// image, step, view, probe or score. Whoever rewrites the whole chain goes unnoticed here: compare the head with one
// noted elsewhere, or take the steps again.
enum vw_status vw_ledger_verify(struct vw_ledger *ledger);

// The run row; the strings belong to the ledger and live until it is closed.
enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run);
// The image rows by image_id; array and strings belong to the ledger and live until it is closed.
enum vw_status vw_ledger_get_images(struct vw_ledger *ledger, const struct vw_ledger_image **images, uint32_t *count);
// All step rows in order, without view rows (`views` NULL); `*records` is owned by the caller (free). NULL columns come
// back as NaN.
enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count);
// All probe rows by step and index, and all score rows by method (in the order first written) and image; owned by the
// caller (free), the strings as above.
enum vw_status vw_ledger_get_probes(struct vw_ledger *ledger, struct vw_probe **probes, uint64_t *count);
enum vw_status vw_ledger_get_scores(struct vw_ledger *ledger, struct vw_ledger_score **scores, uint32_t *count);
// Calls `take` with every row of table view, by step and image, without keeping them: there is one per step and
// validation view.
typedef void vw_ledger_view_taker(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error);
enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context);

VW_PUBLIC_END

#endif
