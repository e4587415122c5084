// What the methods of gradient_methods.h share: a finished training, replayed up to a step, and the gradient of U
// there.
#ifndef VIEWWORTH_LAB_GRADIENTS_GRADIENT_REPLAY_H
#define VIEWWORTH_LAB_GRADIENTS_GRADIENT_REPLAY_H

#include "lab/gradients/gradient_methods.h"
#include "train/adjoint/adjoint_passes.h"

struct gradient_sweep {
    struct step_replay replay;
    struct sweep_passes passes; // of PSNR alone; two rows for every step of a batch
    struct vw_interrupt interrupt;
    struct vw_buffer *zeros; // a block
    struct snapshot state;   // that photos are tried from
    uint64_t step;           // that the state on the device is behind
};

enum vw_status gradient_sweep_create(const struct vw_gradient_params *params, struct gradient_sweep *sweep);
void gradient_sweep_destroy(struct gradient_sweep *sweep);
enum vw_status gradient_sweep_check_interrupt(const struct gradient_sweep *sweep);

// Takes the steps up to this one.
enum vw_status gradient_sweep_go_to(struct gradient_sweep *sweep, uint64_t step);
// Records: the adjoint becomes the gradient of U in the state on the device, which the block `after` takes.
void gradient_sweep_record_validation(const struct gradient_sweep *sweep, uint32_t scalar_row);
// Sets the adjoint to 0; records.
void gradient_sweep_record_zero(const struct gradient_sweep *sweep);
// A product that sweep_record_multiply has written; NaN where it was not finite.
double gradient_sweep_read(const struct gradient_sweep *sweep, uint32_t row);

// The adjoint times what step `number` would be, were it taken on a photo from the state on the device, and times its
// gradient.
struct photo_products {
    double by_step, by_gradient; // NaN where the step was not finite
};
// Of every photo that is trained on. The state on the device is afterwards what it was.
enum vw_status gradient_sweep_try_photos(struct gradient_sweep *sweep, uint64_t number,
                                         struct photo_products *products);

#endif
