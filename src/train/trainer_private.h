// The inside of a trainer, for trainer.c and trainer_outputs.c.
#ifndef VIEWWORTH_TRAIN_TRAINER_PRIVATE_H
#define VIEWWORTH_TRAIN_TRAINER_PRIVATE_H

#include "gpu/compute.h"
#include "train/shared_submissions.h"
#include "train/trainer_parts.h"

// A trainer's part of the submission of the same index.
struct vw_submission_slot {
    uint64_t first_step; // 0 in the run's first submission, which also measures the untrained field
    uint32_t row_count;  // its steps, step 0 included
    bool in_flight;      // submitted, and not handed out
};

struct vw_trainer {
    struct vw_gpu *gpu;           // borrowed
    const struct vw_scene *scene; // borrowed
    struct vw_config config;
    bool validate;
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    bool masks; // mask files are obeyed, or there are none

    struct vw_model model;
    struct vw_radiance_field field;
    struct vw_step_passes step;
    struct vw_photo_order photo_order;
    struct vw_validation validation;
    struct vw_trainer_parts parts; // the above, for code that works between steps

    struct vw_buffer *pixels; // UPLOAD, or DEVICE where the device draws: per submission slot and step, the step's rays
    struct vw_buffer *scalars; // READBACK: per submission slot and step (step 0 included), a measurement
    struct vw_submissions *submissions, *own_submissions; // own: NULL where they are shared
    struct vw_submission_slot slots[SUBMISSIONS_IN_FLIGHT];
    uint32_t next_slot;     // to hand out
    uint64_t next_step;     // the next to record; 0 before the first submission
    uint64_t stop_step;     // the last to record until told otherwise
    enum vw_status failure; // to decode a photo: no step follows
    struct vw_saved_error why;

    struct vw_step_record *records; // records of the submission handed out last, with what they lend
    struct vw_view_error *view_errors;
    uint64_t clamped_count, nonfinite_steps, floored_steps; // counts over the records handed out
};

#endif
