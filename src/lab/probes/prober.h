// Probes: validation after something other than a run's own step, from a state of the run. The state is restored after
// each, so that the run's own steps keep their bits.
#ifndef VIEWWORTH_LAB_PROBES_PROBER_H
#define VIEWWORTH_LAB_PROBES_PROBER_H

#include "train/files/training_files.h"
#include "train/trainer_parts.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

enum vw_probe_kind {             // the first three estimate measurement noise
    VW_PROBE_REPEATED,           // the same validation again: must give the same bits
    VW_PROBE_ZERO_LEARNING_RATE, // the step with learning rate 0: must give the same bits
    VW_PROBE_RESAMPLED,  // the step with other pixels of the same photo: how much sampling alone changes its delta
    VW_PROBE_SAME_STATE, // the next step, on any photo
    VW_PROBE_LONGER,     // all steps that follow, those on a photo longer
    VW_PROBE_SHORTER,
    VW_PROBE_KINDS
};
extern const char *const vw_probe_kind_names[VW_PROBE_KINDS];

struct vw_probe {
    uint64_t step; // the step that is probed: the one after the state, or from VW_PROBE_SAME_STATE on that of the state
    uint32_t index; // 0, 1, ... within the step
    enum vw_probe_kind kind;
    uint32_t view, draw;                      // the photo (scene index) and the draw of its pixels
    float extra;                              // share of itself by which each step on the photo is longer
    double val_psnr, val_psnr_pooled, val_l1; // results, as in vw_step_record; NaN: not finite
};

struct vw_prober {
    const struct vw_trainer_parts *parts; // borrowed from the trainer, which validates
    struct vw_submission *submission;
    struct vw_snapshot snapshot;
    struct vw_model zero_rate_model;          // the run's, with learning rate 0
    struct vw_radiance_field zero_rate_field; // the run's field seen through that model; owns nothing
    struct vw_step_passes zero_rate_step;     // has moments of its own
};

// Creates a prober of a trainer and decodes its photos. Destroy it also after a failure, before the trainer.
enum vw_status vw_prober_create(struct vw_trainer *trainer, struct vw_prober *prober);
void vw_prober_destroy(struct vw_prober *prober);
// Takes probes from the state on the device, which is the one before step `next_step`, and fills in their results.
// Nothing may be in flight. As many as a submission of the run has steps are submitted together.
enum vw_status vw_prober_take(const struct vw_prober *prober, uint64_t next_step, struct vw_probe *probes,
                              uint32_t count);

#endif
