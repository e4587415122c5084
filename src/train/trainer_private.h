// The inside of a trainer, for trainer.c, submissions.c and trainer_outputs.c.
#ifndef VIEWWORTH_TRAIN_TRAINER_PRIVATE_H
#define VIEWWORTH_TRAIN_TRAINER_PRIVATE_H

#include "gpu/compute.h"
#include "train/probes/probes.h"
#include "train/schedule.h"
#include "train/step.h"
#include "train/submissions.h"
#include "train/validation.h"

enum { BATCHES_IN_FLIGHT = 2 }; // one runs while the host records the next and reads the last one's records

struct vw_submissions {
    struct vw_batch *batches[BATCHES_IN_FLIGHT];
    bool in_flight[BATCHES_IN_FLIGHT]; // submitted, and not waited for
    double submitted_s[BATCHES_IN_FLIGHT], took_s[BATCHES_IN_FLIGHT];
    struct vw_trainer *trainers[VW_TRAINERS_TOGETHER_MAX];
    uint32_t trainer_count;
    enum vw_status failure; // of any batch: it ends all of them
    struct vw_saved_error why;
};

// A trainer's part of the batch of the same index.
struct batch_slot {
    uint64_t first_step; // 0 in the run's first batch, which also measures the untrained field
    uint32_t row_count;  // steps it holds, step 0 included
    bool in_flight;      // submitted, and not handed out
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
    struct schedule schedule;
    struct validation validation;
    struct probes probes;

    struct vw_buffer *pixels;  // UPLOAD: per batch slot and step, one or more draws of the step's rays
    struct vw_buffer *scalars; // READBACK: per batch slot and step (step 0 included), one or more measurements
    struct vw_submissions *submissions, *own_submissions; // own: NULL where they are shared
    struct batch_slot slots[BATCHES_IN_FLIGHT];
    uint32_t next_slot; // to hand out
    uint64_t next_step; // the next to record; 0 before the first batch
    uint64_t stop_step; // the last to record until told otherwise

    struct vw_step_record *records; // of the batch handed out last, with what they lend
    struct vw_view_error *view_errors;
    struct vw_probe *step_probes;
    uint64_t clamped_count, nonfinite_steps, floored_steps; // of the records handed out
};

// ---- submissions.c ----

enum vw_status submissions_join(struct vw_submissions *submissions, struct vw_trainer *trainer);
// Waits for what is in flight, which the trainer may be part of.
void submissions_leave(struct vw_submissions *submissions, const struct vw_trainer *trainer);
// The failure that ended all submissions, with its message, or VW_OK.
enum vw_status submissions_check(const struct vw_submissions *submissions);
// Submits the batch `index` with the next steps of every trainer that has some and no steps in that batch already.
enum vw_status submissions_submit(struct vw_submissions *submissions, uint32_t index);
enum vw_status submissions_wait(struct vw_submissions *submissions, uint32_t index);

// ---- trainer.c ----

// Whether the trainer can record steps into the batch `index` now: its steps of that batch are handed out, and one is
// left that needs no look at the state before.
bool trainer_has_steps(const struct vw_trainer *trainer, uint32_t index);
void trainer_record_steps(struct vw_trainer *trainer, uint32_t index, struct vw_batch *batch);

#endif
