// The parts of a trainer, for code that works on its training between steps: pilots, the backward pass of lasting
// credit, and measurements of the laboratory. Whoever changes the state restores it (train/files/training_files.h), so
// that the run's own steps keep their bits.
#ifndef VIEWWORTH_TRAIN_TRAINER_PARTS_H
#define VIEWWORTH_TRAIN_TRAINER_PARTS_H

#include "gpu/compute.h"
#include "train/photo_order.h"
#include "train/step.h"
#include "train/validation/validation.h"

struct vw_trainer;

struct vw_trainer_parts { // all borrowed
    const struct vw_scene *scene;
    const struct vw_config *config;
    const struct vw_effect_decision *effects;
    uint32_t effect_count;
    bool masks; // mask files are obeyed
    struct vw_radiance_field *field;
    const struct vw_step_passes *step;
    const struct vw_validation *validation;
    struct vw_photo_order *photo_order;
    struct vw_buffer *pixels, *scalars; // the trainer's, for its submissions
};

// Returns the parts, borrowed. Use them when nothing is in flight.
const struct vw_trainer_parts *vw_trainer_get_parts(struct vw_trainer *trainer);

#endif
