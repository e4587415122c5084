// The trainer's inside, shared by trainer.c (steps), noise_probe.c, first_order.c, same_state.c, render.c,
// field_file.c, checkpoint.c and identity.c.
#ifndef VIEWWORTH_TRAIN_TRAINER_H
#define VIEWWORTH_TRAIN_TRAINER_H

#include "train/probes/first_order.h"
#include "train/snapshot.h"
#include "train/probes/noise_probe.h"
#include "train/probes/same_state.h"
#include "train/step.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "train/view_fit.h"

enum { BATCHES_IN_FLIGHT = 2 }; // one runs while the host records the next and files the last one's records

struct batch_slot {
    struct vw_batch *batch;
    uint64_t first_step; // 0 in the run's first batch, which also measures the untrained field
    uint32_t row_count;  // steps it holds, step 0 included
    double submitted_s;
    bool in_flight;
};

struct vw_trainer {
    struct vw_gpu *gpu;           // borrowed
    const struct vw_scene *scene; // borrowed
    struct vw_config config;
    bool validate;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    bool masks; // mask files are obeyed, or there are none
    struct model model;
    struct field field;
    struct step_passes step;

    uint32_t *train_views, train_count;
    uint32_t *order; // of the epoch `ordered_epoch`: indices in train_views
    uint64_t ordered_epoch;

    struct evaluator validation;
    struct vw_pass *reduce_views;
    struct vw_buffer *val_ranges; // vw_ray_range per validation view
    uint32_t *val_views, val_count;
    uint32_t *val_pixel_counts; // pixels with weight, per validation view
    uint32_t val_rays;          // that are scored; those to fit views on lie behind them
    struct view_fit view_fit;

    struct snapshot snapshot;            // while something else is tried from it; empty unless something is
    struct noise_probe *noise_probe;     // NULL without --noise-floor
    struct first_order *first_order;     // NULL without --first-order
    struct same_state_probes same_state; // empty without --same-state

    struct vw_buffer *pixels; // UPLOAD: per batch slot, steps_capacity times one or more draws of the step's rays
    struct vw_buffer
        *scalars; // READBACK: per batch slot, (steps_capacity + 1) times one or more measurements of 1 + val_count vec4
    uint32_t steps_capacity, steps_per_batch;
    bool adapt_batches;
    struct batch_slot slots[BATCHES_IN_FLIGHT];
    uint32_t next_slot;
    uint64_t next_step;             // the next to record; 0 before the first batch
    uint64_t stop_step;             // the last to record until told otherwise
    struct vw_step_record *records; // of the batch handed out last
    struct vw_view_error *view_errors;
    struct vw_probe *probes;
    struct vw_view_error *probe_errors; // of one validation: scratch
    struct vw_trainer_stats stats;
};

// Whether steps are submitted that were not handed out yet.
bool trainer_in_flight(const struct vw_trainer *trainer);

// The photo of a step (from 1), by the epoch's shuffled order: its index in train_views.
uint32_t trainer_photo_of_step(struct vw_trainer *trainer, uint64_t step);
uint32_t trainer_epoch_of_step(const struct vw_trainer *trainer, uint64_t step);

// The photos of a step's own pixels and of its redraws: what pixels_draw takes for `draw` beyond them is free.
enum { TRAINER_STEP_DRAWS = 1 + PROBE_RESAMPLES };

// A measurement in the scalars: a row of the step, then one per validation view.
uint32_t trainer_rows_per_measurement(const struct vw_trainer *trainer);

// Reads a measurement into the probe's values; `stepped`: its first row says whether the step before it was finite.
void trainer_read_probe(const struct vw_trainer *trainer, const vw_float4 *rows, bool stepped, struct vw_probe *probe);

// Records the validation of the field as it is, into the rows behind scalar_row.
void trainer_record_validation(const struct vw_trainer *trainer, struct vw_batch *batch, uint32_t scalar_row);

#endif
