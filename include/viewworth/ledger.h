// The ledger: OUT/ledger.db, an SQLite file with one run. Its tables:
// - run, image, step, view, score: their columns stay, and new ones are appended;
// - retraining(run_id, retraining, seed, epochs, image_ids, val_psnr): struct vw_ledger_retraining,
//   numbered from 0; image_ids is a list with single spaces between.
// - payout_request(run_id, cents): what the payout in OUT was asked for; none without one.
//
// The tables of lasting credit (value.h), empty in a run without it:
// - lasting(run_id, rays, epochs, states, row_hash): the settings of the pass;
// - lasting_step(run_id, step, psnr, loss, size_psnr, size_loss): vw_lasting_step, one row per step but step 0;
// - lasting_check(run_id, image_id, from_step, predicted_psnr, measured_psnr, predicted_loss, measured_loss):
//   vw_gate_check, the gate;
// - lasting_view(run_id, step, image_id, psnr): dB that the PSNR of validation photo image_id at the end gains by the
//   step; a row for every step but step 0 and every validation photo. lasting_step.psnr is their mean, but for
//   rounding.
//
// The rows form a hash chain. Each hash covers the values in the order named here, rows in the order of their keys
// (src/ledger/README.md in the source tree says what that protects, and what it does not):
// - run.row_hash: run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version, and all image rows;
// - step.row_hash: the row_hash before it (for step 0 that of the run), the other columns of the step and its view
// rows;
// - run.final_hash: the last row_hash (that of the run itself while status is "running"), scene_path, config_json,
//   scene_options_json, effects_json, plan_json, started_utc, finished_utc, status, field_sha256, all score rows in
//   the order of their rowids, which is the order of the methods, and all retraining rows; then the row of lasting, if
//   there is one, and that of payout_request;
// - lasting.row_hash: the row_hash of the last step, the other columns of lasting, all rows of lasting_step, of
//   lasting_check and of lasting_view.
// So the chain of the steps depends only on what the run is: the same command produces it again, and extending a run
// keeps it. (run_id covers the part of config_json that belongs to the run's identity.)
//
// Every append is one synced transaction in rollback-journal mode (decision 11).
#ifndef VIEWWORTH_LEDGER_H
#define VIEWWORTH_LEDGER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

struct vw_ledger;

// The run row. Hashes are 64 hex digits, times ISO 8601 in UTC ("2026-11-21T03:04:05Z").
struct vw_ledger_run {
    const char *run_id;
    const char *scene_hash;
    const char *scene_path;
    int64_t seed;
    const char *config_json;
    const char *subset_hash; // hash of the names of the photos trained on
    const char *device, *driver;
    const char *shader_hash;
    const char *version; // version of viewworth
    const char *started_utc;
    const char *scene_options_json; // the options that the scene was opened with ("{}": none), or the hash of an
                                    // imported log, with validated_every where its steps share changes (step_log.h)
    const char *effects_json;       // the decision on every effect, with its evidence (decision 7)
    const char *plan_json;          // the decisions of --accuracy or --budget; "{}" or NULL: neither was given
    const char *status;       // "running", "finished", "interrupted" or "failed"; vw_ledger_create writes "running"
    const char *finished_utc; // when the run last ended; NULL: not yet. vw_ledger_create ignores it
    const char *field_sha256; // hash of the field file written at this end; NULL: none. vw_ledger_create ignores it
};

struct vw_ledger_image {
    uint32_t image_id; // the view's index in the scene
    const char *name, *split, *provider;
    const char *sha256;       // 64 hex digits
    const char *ground_truth; // the label of the injected corruption ("blur", "clean", ...); NULL: unknown
    double weight;            // the share in means over validation photos: the number by its name in "weights" of
                              // scene_options_json, or 1; vw_ledger_create ignores it
};

struct vw_ledger_score {
    uint32_t image_id;
    const char *method;                 // "dv_psnr", "dv_loss", "quality", ...
    double value;                       // more = better
    const char *unit;                   // "dB", "mean absolute error"
    double standard_error;              // in the unit of value; NaN: NULL in the ledger
    uint32_t visits;                    // steps that count for the value
    double ci_low, ci_high;             // 95 % interval of the value over seeds; NaN: NULL in the ledger
    uint32_t rank_ci_low, rank_ci_high; // 95 % interval of the rank in the method, 1 = most valuable; 0: NULL in the
                                        // ledger
};

// The effect of a step on the end of the training, found by the backward pass of lasting credit (value.h).
struct vw_lasting_step {
    uint64_t step;               // 1, 2, ...
    double psnr, loss;           // dB that the end gains by the step; mean absolute error that it loses
    double size_psnr, size_loss; // length of the gradient of either by the params after the step; 0 or more
};

// One photo of the gate: its steps after from_step were scaled in trainings from there on.
struct vw_gate_check {
    uint32_t image_id;
    uint64_t from_step;
    double predicted_psnr, measured_psnr; // dB per unit of scale; measured NaN: a training was not finite
    double predicted_loss, measured_loss; // the same in mean absolute error, more = better
};

// A backward pass through a training, which gives lasting credit. step_count 0: there is none.
struct vw_lasting_pass {
    uint32_t rays;                       // per step, that the product takes; 0: all
    uint32_t epochs, states;             // the end is the mean over at most so many states of the last epochs
    const struct vw_lasting_step *steps; // all steps of the run but step 0, in order
    uint64_t step_count;
    const struct vw_gate_check *checks; // by image_id; none without the gate
    uint32_t check_count;
    const uint32_t *views; // image_ids of all validation photos, ascending; none without credit by validation photo
    const double
        *view_psnr; // dB that each gains by each step: that of step s and view v is at (s - 1) * view_count + v
    uint32_t view_count;
};

// A training on some of the run's photos after the run, at as many steps as the run, from which worth is computed.
struct vw_ledger_retraining {
    uint64_t seed; // seed of order, pixels, jitter and initialisation
    uint32_t epochs;
    const uint32_t *image_ids; // trained on, ascending
    uint32_t image_count;
    double val_psnr; // dB, mean over the ends of the last epochs; NaN: NULL in the ledger, it has no value
};

struct vw_payout_request {
    uint64_t cents; // 0: none
};

// Creates the file `path`. VW_ERROR_USAGE if it exists.
enum vw_status vw_ledger_create(const char *path, const struct vw_ledger_run *run, const struct vw_ledger_image *images,
                                uint32_t image_count, struct vw_ledger **ledger);
// Opens a ledger to read it. Changes nothing in its folder, and may be called while another process appends. The whole
// file is checked first, since it may come from someone who wants to harm. VW_ERROR_INPUT if it is not exactly a ledger
// of this version, or if a killed process left a write unfinished, which vw_ledger_open_to_append puts right.
enum vw_status vw_ledger_open(const char *path, struct vw_ledger **ledger);
// Opens the ledger in the same way, to append after its last step. Verifies it, since every later hash would vouch for
// an edited row: VW_ERROR_MISMATCH names the first one.
enum vw_status vw_ledger_open_to_append(const char *path, struct vw_ledger **ledger);
void vw_ledger_close(struct vw_ledger **ledger);

// Appends steps with their view rows, as one synced transaction. `validation_views` has the image_id of each
// entry of record->views.
enum vw_status vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                const uint32_t *validation_views);
// Replaces the scores and sets finished_utc, status ("finished", "interrupted" or "failed") and final_hash, as one
// synced transaction.
enum vw_status vw_ledger_finish(struct vw_ledger *ledger, const char *status, const char *finished_utc,
                                const struct vw_ledger_score *scores, uint32_t score_count);

// Replaces pass and scores of a finished run, as one synced transaction; its status stays. An append removes the
// pass. VW_ERROR_USAGE when its steps are not those of the run, or a value is not finite.
enum vw_status vw_ledger_set_lasting(struct vw_ledger *ledger, const struct vw_lasting_pass *pass,
                                     const struct vw_ledger_score *scores, uint32_t score_count);

// Appends retrainings to those that are recorded, and replaces the scores of a finished run, as one synced
// transaction. A run that is extended afterwards loses its retrainings.
enum vw_status vw_ledger_add_retrainings(struct vw_ledger *ledger, const struct vw_ledger_retraining *retrainings,
                                         uint32_t count, const struct vw_ledger_score *scores, uint32_t score_count);

// Replaces what a payout was asked for, as one synced transaction; scores and state stay. No cents: there is none.
enum vw_status vw_ledger_set_payout_request(struct vw_ledger *ledger, const struct vw_payout_request *request);
enum vw_status vw_ledger_get_payout_request(struct vw_ledger *ledger, struct vw_payout_request *request);

// Names the SHA-256 (64 hex digits) of the field file that the run ends with. vw_ledger_finish writes it, and an append
// forgets it.
enum vw_status vw_ledger_set_field(struct vw_ledger *ledger, const char *sha256);

// Sets the config for further steps. Only what is not part of the run's identity may differ (epochs). It is written
// with the next append or finish.
enum vw_status vw_ledger_extend(struct vw_ledger *ledger, const char *config_json);
uint64_t vw_ledger_next_step(const struct vw_ledger *ledger); // the step that the next append must begin with
// Writes the chain head, which covers everything in the ledger: final_hash after the run has ended, before that the
// last row_hash.
void vw_ledger_chain_head(const struct vw_ledger *ledger, char head[VW_HASH_HEX_BYTES]);
// Compares repeated steps with the recorded ones, bit for bit. records[0].step + count must be at most
// vw_ledger_next_step. VW_ERROR_MISMATCH names the first step that differs.
enum vw_status vw_ledger_compare(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                 const uint32_t *validation_views);
// Recomputes every hash. VW_ERROR_MISMATCH names the first row that was edited, removed, added or reordered: run,
// image, step, view or score. This does not detect a chain that was rewritten as a whole: compare the chain head
// with one noted elsewhere, or repeat the steps and use vw_ledger_compare.
enum vw_status vw_ledger_verify(struct vw_ledger *ledger);

// Returns the run row; the strings belong to the ledger and live until it is closed.
enum vw_status vw_ledger_get_run(struct vw_ledger *ledger, struct vw_ledger_run *run);
// Returns the image rows by image_id; array and strings belong to the ledger and live until it is closed.
enum vw_status vw_ledger_get_images(struct vw_ledger *ledger, const struct vw_ledger_image **images, uint32_t *count);
// Returns all step rows in order, without view rows (`views` is NULL). The caller frees `*records`. NULL columns become
// NaN.
enum vw_status vw_ledger_get_steps(struct vw_ledger *ledger, struct vw_step_record **records, uint64_t *count);
// Returns all score rows by method (in the order in which they were written) and image. The caller frees the array; its
// strings belong to the ledger.
enum vw_status vw_ledger_get_scores(struct vw_ledger *ledger, struct vw_ledger_score **scores, uint32_t *count);
// Returns the backward pass of lasting credit; without one, step_count is 0. VW_ERROR_INPUT: its rows are inconsistent.
// The caller frees the arrays (vw_lasting_pass_free).
enum vw_status vw_ledger_get_lasting(struct vw_ledger *ledger, struct vw_lasting_pass *pass);
void vw_lasting_pass_free(struct vw_lasting_pass *pass);
// Returns all retraining rows in order; `*retrainings` and what it points to is one array, owned by the caller (free).
enum vw_status vw_ledger_get_retrainings(struct vw_ledger *ledger, struct vw_ledger_retraining **retrainings,
                                         uint32_t *count);
// Calls `take` with every row of table view, by step and image. The rows are not kept in memory, because there is one
// for every step and validation view.
typedef void vw_ledger_view_taker(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error);
enum vw_status vw_ledger_each_view(struct vw_ledger *ledger, vw_ledger_view_taker *take, void *context);

VW_PUBLIC_END

#endif
