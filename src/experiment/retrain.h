// Retraining: trainings on some photos of one scene, measured on its validation and test photos. Every result is kept
// in OUT/retrainings.db; an equal retraining returns the recorded result.
#ifndef VIEWWORTH_EXPERIMENT_RETRAIN_H
#define VIEWWORTH_EXPERIMENT_RETRAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "base/hash.h"
#include "base/interrupt.h"
#include "experiment/measured_views.h"
#include "ledger/retraining.h"
#include "run/recorded/recorded_run.h"
#include "run/session.h"
#include "viewworth/train.h"
#include "viewworth/value.h"

// Number of ends of epochs over which the target of scores is averaged: a constant learning rate does not settle.
enum { VW_TRUTH_EPOCHS = 4 };

struct vw_retrainer_params {
    struct vw_session *session;     // open, and open as long as the retrainer; its effects are decided when it opens
    const struct vw_config *config; // needed; retrainings bring their seeds, and their epochs unless these are 0
    const char *out;                // a folder that exists; NULL: results are kept in memory, and none is recalled
    uint32_t together;              // retrainings that take their steps together on each device; 0: by it
    enum vw_equal equal;            // equal epochs or equal steps on different photos
    uint32_t averaged_epochs;       // results are means over the ends of the last so many epochs; 0 as 1: the end alone
    bool whole_views;               // measure whole views, with SSIM, instead of an even share of their pixels
    struct vw_interrupt interrupt;
};

struct vw_retrainer {
    struct vw_retrainer_params params;
    // With whole_views: the views of which a retraining saves a picture. A retraining that lacks one is made again. The
    // caller sets it; zero: none.
    struct vw_saved_views saved_views;
    struct vw_retraining_store *retrainings;
    uint32_t *train_views, train_count; // owned: scene indices of the photos that may be trained on
    uint32_t *left_out;                 // owned; scratch: as many
    char base_id[VW_HASH_HEX_BYTES];    // run_id of the training on all of them with seed 0
    char scene_hash[VW_HASH_HEX_BYTES];
    uint64_t made, recalled;      // retrainings so far
    uint64_t planned;             // in all; the caller sets it, for the log
    double started_s, reported_s; // for the log
};

// Decides effects and opens the file of retrainings. `*retrainer` is zero. Close it also after a failure, before the
// session.
enum vw_status vw_retrainer_open(const struct vw_retrainer_params *params, struct vw_retrainer *retrainer);
void vw_retrainer_close(struct vw_retrainer *retrainer);

// Computes the id of a retraining: the hash of all that decides its bits on a device and driver.
void vw_retrainer_name(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                       char id[VW_HASH_HEX_BYTES]);

// Logs, before vw_retrain() makes them, how many different retrainings are to be made and about how long that takes, by
// steps that it measures.
enum vw_status vw_retrainer_announce(struct vw_retrainer *retrainer, const struct vw_retrain_params *retrainings,
                                     uint32_t count);

// Makes retrainings; a vw_retrain_function whose `context` is the retrainer. The views of a retraining are scene
// indices; without any, the untrained field is measured. Makes several at a time (train/training_pool.h) on every
// device of the session, each with the result that it has alone. After a failure, and when the interrupt is
// requested (VW_ERROR_INTERRUPTED), it finishes and keeps those that it has begun.
enum vw_status vw_retrain(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                          struct vw_retrain_result *results);

// Announces all retrainings of a command and makes them.
enum vw_status vw_retrain_announced(struct vw_retrainer *retrainer, const struct vw_retrain_params *retrainings,
                                    uint32_t count, struct vw_retrain_result *results);

// Compares a result that this retrainer has made, and its single photos, with those that another store has, if any.
// VW_ERROR_MISMATCH when a bit differs; only the CPU time may.
enum vw_status vw_retrainer_compare(const struct vw_retrainer *retrainer, struct vw_retraining_store *recorded,
                                    const struct vw_retrain_params *retraining, const struct vw_retrain_result *result);

// Fills in psnr_db of a retraining's single validation and test photos, whose image_ids are scene indices. Returns
// VW_ERROR_MISMATCH when the store lacks one.
enum vw_status vw_retrainer_find_views(const struct vw_retrainer *retrainer, const struct vw_retrain_params *retraining,
                                       struct vw_retrain_view *views, uint32_t view_count);

// ---- Retraining the photos of a recorded run ----

// Opens a session on devices (the first NULL: the run's), scene and effects of the run. Returns VW_ERROR_INPUT for a
// scene that has changed. Close it also after a failure, before the run, which owns the scene and the first device.
enum vw_status vw_session_open_recorded(struct vw_recorded_run *recorded, const struct vw_device_choice *devices,
                                        struct vw_session *session);
void vw_session_close_recorded(struct vw_session *session);
// Returns the run's config with the epochs that its steps took.
struct vw_config vw_config_of_retrainings(const struct vw_recorded_run *recorded, const struct vw_value_input *steps);
// Returns the first of 2^32 seeds without the run's own: trainings with that one would favour what its scores select.
// All retrainings, now or later, count from here.
uint64_t vw_first_seed_after(uint64_t own);

#endif
