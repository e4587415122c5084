// The passes and buffers of a training step, and the part of it from rays to gradients, which the backward pass
// and the consistency loss take as well.
#ifndef VIEWWORTH_TRAIN_STEP_PASSES_H
#define VIEWWORTH_TRAIN_STEP_PASSES_H

#include "gpu/compute.h"
#include "train/effects/effects.h"
#include "train/field.h"
#include "train/fields/registry.h"
#include "train/renderers/volume/importance.h"

struct vw_consistency_effect; // effects/consistency.h
struct vw_device_photos;      // device_photos.h
struct vw_photo_order;
struct vw_splat_step; // renderers/splats/splats_renderer.h

// The passes that go from rays to gradients. Several sets of them, each with its specialization, may share the buffers
// of a step: those of the training itself, and those of the backward pass (adjoint_passes.h).
struct vw_gradient_passes {
    struct vw_specialization specialization;
    struct vw_pass *generate, *backward_rays;
    struct vw_pass *ends[VW_EFFECT_COUNT_MAX]; // ray_gradient of effects, by place in their table
    struct vw_field_passes field;
    struct vw_importance importance;
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
    uint32_t rays, padded_rays, chunk_rays;
    struct vw_buffer *ray_buffer, *samples, *d_samples, *ray_loss, *overflow;
    struct vw_buffer *places; // places of a chunk's samples; NULL without importance samples
    struct vw_buffer *weight_partials, *d_weights, *weight_moments;
    struct vw_buffer *d_grid, *grid_moment1, *grid_moment2, *grid_visits;
    struct vw_gradient_passes gradient;
    struct vw_splat_step *splats; // owned; of the renderer splats, which has none of the volume's buffers
    struct vw_pass *reduce_loss, *update_weights, *update_grid[VW_LEVELS_MAX]; // update_grid: per window
    struct vw_buffer *effect_buffers[VW_SLOT_COUNT];                           // the effects', by slot
    struct vw_effect_sets effects;
    struct vw_consistency_effect *consistency; // NULL without that loss
};

// The flags of `overflow`, which passes set: one of the weights, one of photos, then those of the renderer.
enum { VW_OVERFLOW_WEIGHTS, VW_OVERFLOW_PHOTOS, VW_OVERFLOW_RENDERER };
struct vw_binding vw_step_overflow_binding(const struct vw_step_passes *step, uint32_t flag);

// Returns the buffers of effects, by slot.
struct vw_effect_buffers vw_step_effect_buffers(const struct vw_step_passes *step);
// Binds a step's buffers and its field's. Writes the bindings after the first `*count` and advances it.
void vw_step_bind(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count);

// Creates the pass that draws pixels, where the device does; `tiles`: those of splats, else NULL.
enum vw_status vw_step_create_draw(struct vw_step_passes *step, const struct vw_shader *shader,
                                   struct vw_buffer *tiles);

// Creates another set of passes over the step's buffers. `objects` own them.
enum vw_status vw_gradient_create(const struct vw_step_passes *step, struct vw_gpu_objects *objects,
                                  const struct vw_specialization *specialization, struct vw_gradient_passes *gradient);
// Records forward and back through the rays of one chunk, of which the next chunk overwrites all but the gradients.
void vw_gradient_record_chunk(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                              struct vw_submission *submission, const struct vw_push_samples *chunk);
// Creates the pass that makes its rays. It waits for the flags of the step before only where it writes the photo there.
enum vw_status vw_gradient_create_generate(const struct vw_model *model, struct vw_gpu_objects *objects,
                                           const struct vw_pass_params *common, struct vw_gradient_passes *gradient);
// Creates those of its passes that follow the last chunk, with these params.
enum vw_status vw_gradient_create_ends(const struct vw_model *model, struct vw_gpu_objects *objects,
                                       const struct vw_pass_params *common, struct vw_gradient_passes *gradient);
// Records the chunk's beginning, after the placing of samples, up to their rgb and density, by these passes of the
// field.
void vw_gradient_record_forward(const struct vw_step_passes *step, const struct vw_field_passes *passes,
                                struct vw_submission *submission, const struct vw_push_samples *chunk);
// Records the chunk's end, from there on.
void vw_gradient_record_back(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                             struct vw_submission *submission, const struct vw_push_samples *chunk);
// Returns the piece of `rays` that begins at `first`, up to a chunk.
struct vw_push_samples vw_gradient_chunk(const struct vw_step_passes *step, uint32_t rays, uint32_t first,
                                         vw_uint4 key);
// Records what follows the last chunk of `rays`.
void vw_gradient_record_end(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                            struct vw_submission *submission, uint32_t rays);

#endif
