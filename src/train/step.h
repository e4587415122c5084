// One training step on the device: from the pixels of one photo to updated params.
//   rays of one photo -> field forward -> composite + loss -> field backward -> optimiser
#ifndef VIEWWORTH_TRAIN_STEP_H
#define VIEWWORTH_TRAIN_STEP_H

#include "train/pixels.h"
#include "train/step_passes.h"

// Creates the passes. `photo_order` says of which photos the steps are. `pixels` has room for vw_pixel of many steps,
// `scalars` takes vec4 rows. `photos` are those that the device draws pixels from, into its own memory; NULL: the host
// draws them, and `pixels` is mapped. All outlive the passes.
enum vw_status vw_step_create(struct vw_radiance_field *field, const struct vw_config *config,
                              struct vw_photo_order *photo_order, struct vw_buffer *pixels, struct vw_buffer *scalars,
                              struct vw_device_photos *photos, struct vw_step_passes *step);
void vw_step_destroy(struct vw_step_passes *step);

// Decodes photos, and brings them to the device where it draws.
enum vw_status vw_step_take_photos(const struct vw_step_passes *step, const uint32_t *views, uint32_t count);
// Draws the pixels of step number `draw->step` on a photo that was taken, from `first_pixel` of the step's buffer on,
// or records that.
void vw_step_draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                         const struct vw_pixel_draw *draw, uint32_t first_pixel);
// Returns how many of the pixels at `first_pixel` the step looks at. They come first; the others have no weight.
uint32_t vw_step_counted_rays(const struct vw_step_passes *step, uint32_t first_pixel);

// The state of a training: everything that a step changes and the next one starts from (params, moments, visits, and
// what effects carry). Training resumes from it and the step's number. Returns how many buffers there are.
enum { TRAINING_STATE_BUFFERS_MAX = 16 };
uint32_t vw_step_training_state(const struct vw_step_passes *step,
                                struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX]);

// Records the first part of a step, up to the loss of each ray and the gradients.
void vw_step_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                              uint32_t first_pixel);
// Records the optimiser's part at the step's learning rate, which moves the params by 1 + `extra` times what it says
// (0 in every run).
void vw_step_record_update(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           uint32_t first_pixel, float extra);
// Records the last part: the step's loss and flags, to scalars[scalar_row]. It clears the flags, which the gradients of
// the next step need.
void vw_step_record_loss(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t first_pixel,
                         uint32_t scalar_row);
// Records that alone, after gradients that are not a step's.
void vw_step_record_clear(const struct vw_step_passes *step, struct vw_submission *submission);

// Records step `number` (from 1) on the pixels from `first_pixel` on; the loss and the flags go to scalars[scalar_row].
void vw_step_record_passes(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                           uint32_t first_pixel, uint32_t scalar_row);

#endif
