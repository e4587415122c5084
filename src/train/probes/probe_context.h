// The parts of a trainer that probes work with. A probe tries something on the state of a training and restores the
// state, so that the run's own steps keep their bits.
#ifndef VIEWWORTH_TRAIN_PROBES_PROBE_CONTEXT_H
#define VIEWWORTH_TRAIN_PROBES_PROBE_CONTEXT_H

#include "gpu/compute.h"
#include "train/files/snapshot.h"
#include "train/photo_order.h"
#include "train/step.h"
#include "train/validation/validation.h"
#include "viewworth/types.h"

struct vw_probe_context { // all borrowed
    const struct vw_scene *scene;
    const struct vw_config *config;
    bool masks; // mask files are obeyed
    struct vw_radiance_field *field;
    const struct vw_step_passes *step;
    const struct vw_validation *validation;
    struct vw_photo_order *schedule;
    const struct vw_snapshot *snapshot; // empty unless a probe needs it
    struct vw_buffer *pixels, *scalars; // the trainer's, for its batches
};

// Reads a measurement into the probe's values; `stepped`: its first row says whether the step before it was finite.
void vw_probe_read(const struct vw_probe_context *context, const vw_float4 *rows, bool stepped, struct vw_probe *probe);

// Returns the parts of a trainer, borrowed, for code that works on its training when nothing is in flight.
struct vw_trainer;
const struct vw_probe_context *vw_trainer_context(struct vw_trainer *trainer);

#endif
