// One training step on the device: from the pixels of one photo to updated params.
//   rays of one photo -> field forward -> composite + loss -> field backward -> optimiser
// The part from rays to gradients is taken by the backward pass and the consistency loss as well.
#ifndef VIEWWORTH_TRAIN_STEP_H
#define VIEWWORTH_TRAIN_STEP_H

#include "gpu/compute.h"
#include "train/effects/effects.h"
#include "train/field.h"
#include "train/pixels.h"

struct vw_consistency_effect; // effects/appearance_encoder.h
struct vw_device_photos;      // device_photos.h
struct vw_photo_order;

// The passes that steps of all renderers begin and end with: rays of the photo's pixels, and, after the last of them,
// the gradient of the sky, NULL without that effect.
struct vw_ray_passes {
    struct vw_pass *generate, *gradient_sky;
};

struct vw_step_passes {
    struct vw_radiance_field *field;    // borrowed
    struct vw_gpu_objects objects;      // owned: all buffers and passes that are not borrowed
    struct vw_photo_order *photo_order; // borrowed
    struct vw_buffer *pixels, *scalars; // borrowed
    struct vw_device_photos *photos;    // borrowed; NULL: the host draws pixels
    struct vw_pass *draw_pixels;        // NULL likewise
    struct vw_pixel *drawn;             // owned; room for the pixels of a step; NULL where the device draws
    uint32_t *counted; // owned; by place in `pixels`: how many rays of a step there count, and come first
    uint32_t rays, padded_rays;
    struct vw_buffer *ray_buffer, *ray_loss, *overflow, *d_weights, *weight_moments;
    struct vw_pass *reduce_loss, *update_weights;
    void *of_renderer;                               // owned: what the renderer has beside
    struct vw_buffer *effect_buffers[VW_SLOT_COUNT]; // the effects', by slot
    struct vw_effect_sets effects;
    struct vw_consistency_effect *consistency; // NULL without that loss
};

// The flags of `overflow`, which passes set: one of the weights, one of photos, then those of the renderer.
enum { VW_OVERFLOW_WEIGHTS, VW_OVERFLOW_PHOTOS, VW_OVERFLOW_RENDERER };
struct vw_binding vw_step_overflow_binding(const struct vw_step_passes *step, uint32_t flag);

// Binds a step's buffers and its field's. Writes the bindings after the first `*count` and advances it.
void vw_step_bind(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count);

// Creates the pass that draws pixels, where the device does; `tiles`: those of splats, else NULL.
enum vw_status vw_step_create_draw(struct vw_step_passes *step, const struct vw_shader *shader,
                                   struct vw_buffer *tiles);

// Creates them with these params. The first waits for the flags of the step before only where it writes the photo
// there.
enum vw_status vw_ray_passes_create(const struct vw_model *model, struct vw_gpu_objects *objects,
                                    const struct vw_pass_params *common, const struct vw_specialization *specialization,
                                    struct vw_ray_passes *passes);
// Records what follows the last chunk of `rays`.
void vw_ray_passes_record_end(const struct vw_ray_passes *passes, struct vw_submission *submission, uint32_t rays);

// Creates the passes. `photo_order` says of which photos the steps are. `pixels` has room for vw_pixel of many steps,
// `scalars` takes vec4 rows. `photos` are those that the device draws pixels from, into its own memory; NULL: the host
// draws them, and `pixels` is mapped. All outlive the passes.
enum vw_status vw_step_create(struct vw_radiance_field *field, struct vw_photo_order *photo_order,
                              struct vw_buffer *pixels, struct vw_buffer *scalars, struct vw_device_photos *photos,
                              struct vw_step_passes *step);
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
