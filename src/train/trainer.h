// The trainer's inside, shared by trainer.c (steps), render.c, field_file.c and identity.c.
#ifndef VIEWWORTH_TRAIN_TRAINER_H
#define VIEWWORTH_TRAIN_TRAINER_H

#include "step.h"

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
    struct model model;
    struct field field;
    struct step_passes step;

    uint32_t *train_views, train_count;
    uint32_t *order; // of the epoch `ordered_epoch`
    uint64_t ordered_epoch;

    struct evaluator validation;
    struct vw_pass *reduce_views;
    struct vw_buffer *val_ranges; // vw_ray_range per validation view
    uint32_t *val_views, val_count;
    uint32_t *val_pixel_counts; // pixels with weight, per validation view
    uint32_t val_rays;

    struct vw_buffer *pixels;  // UPLOAD: steps_capacity * rays per batch slot
    struct vw_buffer *scalars; // READBACK: (steps_capacity + 1) * (1 + val_count) vec4 per batch slot
    uint32_t steps_capacity, steps_per_batch;
    bool adapt_batches;
    struct batch_slot slots[BATCHES_IN_FLIGHT];
    uint32_t next_slot;
    uint64_t next_step;             // the next to record; 0 before the first batch
    struct vw_step_record *records; // of the batch handed out last
    struct vw_view_error *view_errors;
    struct vw_trainer_stats stats;
};

#endif
