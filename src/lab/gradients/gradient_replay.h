// Base of the methods of gradient_methods.h: a finished training, replayed up to a step, and the gradient of U there.
#ifndef VIEWWORTH_LAB_GRADIENTS_GRADIENT_REPLAY_H
#define VIEWWORTH_LAB_GRADIENTS_GRADIENT_REPLAY_H

#include "lab/gradients/gradient_methods.h"
#include "train/adjoint/adjoint_passes.h"
#include "train/files/training_files.h"

struct vw_gradient_replay {
    struct vw_step_replay replay;
    struct vw_adjoint_passes passes; // passes for PSNR alone; two rows for every step of a submission
    struct vw_interrupt interrupt;
    struct vw_gpu_objects objects; // owned: the next two
    struct vw_buffer *zeros;       // a block
    struct vw_pass *multiply;      // the adjoint with a step
    struct vw_snapshot state;      // that photos are tried from
    uint64_t step;                 // the last step in the state on the device
};

enum vw_status vw_gradient_replay_create(const struct vw_gradient_params *params,
                                         struct vw_gradient_replay *gradient_replay);
void vw_gradient_replay_destroy(struct vw_gradient_replay *gradient_replay);
enum vw_status vw_gradient_replay_check_interrupt(const struct vw_gradient_replay *gradient_replay);

// Takes the steps up to this one.
enum vw_status vw_gradient_replay_go_to(struct vw_gradient_replay *gradient_replay, uint64_t step);
// Records the passes that set the adjoint to the gradient of U in the state on the device; that state is copied to the
// block `after`.
void vw_gradient_replay_record_validation(const struct vw_gradient_replay *gradient_replay, uint32_t scalar_row);
// Sets the adjoint to 0; records.
void vw_gradient_replay_record_zero(const struct vw_gradient_replay *gradient_replay);
// Takes step `number` and leaves in the blocks the params before and after it and its gradient.
void vw_gradient_replay_record_step(const struct vw_gradient_replay *gradient_replay, uint64_t number,
                                    uint32_t first_pixel, uint32_t scalar_row);
// Writes into a row of the passes the adjoint times what the step in the blocks moved, or times its gradient (x + y; w:
// not finite).
void vw_gradient_replay_record_multiply(const struct vw_gradient_replay *gradient_replay, bool by_gradient,
                                        uint32_t row);
// Returns a product that this has written; NaN if it was not finite.
double vw_gradient_replay_read(const struct vw_gradient_replay *gradient_replay, uint32_t row);

// The adjoint times what step `number` would be, were it taken on a photo from the state on the device, and times its
// gradient.
struct vw_photo_products {
    double by_step, by_gradient; // NaN where the step was not finite
};
// Computes the products of every photo that is trained on. Afterwards the state on the device is as it was.
enum vw_status vw_gradient_replay_try_photos(struct vw_gradient_replay *gradient_replay, uint64_t number,
                                             struct vw_photo_products *products);

#endif
