// The renderer `volume` (renderers/registry.h): what it has of a step and of an evaluator, and the functions of its
// table in volume.c.
#ifndef VIEWWORTH_TRAIN_RENDERERS_VOLUME_VOLUME_H
#define VIEWWORTH_TRAIN_RENDERERS_VOLUME_VOLUME_H

#include "gpu/compute.h"
#include "train/evaluator.h"
#include "train/fields/registry.h"
#include "train/renderers/registry.h"
#include "train/step.h"

// ---- Importance samples ----

// Samples placed where the field has matter (--importance-samples). Before a chunk of rays goes forward, its even
// samples are rendered, and place_samples lists all places of the chunk, which the passes after it read. The field
// itself renders the even samples, without a backward pass; or, as in NeRF (Mildenhall et al., ECCV 2020, section 5.2),
// a coarse network of the same shape (--coarse-network own), which a step trains by the loss of its own colours against
// the same pixels, NeRF's equation 6. No gradient goes through the places.
struct vw_importance {
    struct vw_field_passes even;
    struct vw_pass *place;         // NULL without importance samples
    struct vw_pass *backward_rays; // over the even samples; NULL where no coarse network is trained
};

// Returns the bytes of the listed places of a chunk of rays, 0 without importance samples; bound at
// VW_SLOT_PLACES.
uint64_t vw_importance_places_bytes(const struct vw_model *model, uint32_t rays);
// Creates the placing for passes of this specialization. `backward_rays`: the shader that trains a coarse network, if
// there is one; NULL where nothing is trained.
enum vw_status vw_importance_create(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    const struct vw_specialization *specialization,
                                    const struct vw_shader *backward_rays, struct vw_importance *importance);
// Records the placing of a chunk's samples, and the backward pass of a coarse network. Does nothing without importance
// samples.
void vw_importance_record(const struct vw_model *model, const struct vw_importance *importance,
                          struct vw_submission *submission, const struct vw_push_samples *chunk);

// ---- A step ----

// The passes that go from rays to gradients. Several sets of them, each with its specialization, may share the buffers
// of a step: those of the training itself, and those of the backward pass (adjoint_passes.h).
struct vw_gradient_passes {
    struct vw_specialization specialization;
    struct vw_ray_passes of_rays;
    struct vw_pass *backward_rays;
    struct vw_field_passes field;
    struct vw_importance importance;
};

struct vw_volume_step {
    uint32_t chunk_rays;
    struct vw_buffer *samples, *d_samples, *weight_partials;
    struct vw_buffer *places; // places of a chunk's samples; NULL without importance samples
    struct vw_buffer *d_grid, *grid_moment1, *grid_moment2, *grid_visits;
    struct vw_gradient_passes gradient;
    struct vw_pass *update_grid[VW_LEVELS_MAX]; // per window
};
static inline struct vw_volume_step *vw_volume_step_of(const struct vw_step_passes *step) { return step->of_renderer; }

// Creates another set of passes over the step's buffers. `objects` own them.
enum vw_status vw_gradient_create(const struct vw_step_passes *step, struct vw_gpu_objects *objects,
                                  const struct vw_specialization *specialization, struct vw_gradient_passes *gradient);
// Records forward and back through the rays of one chunk, of which the next chunk overwrites all but the gradients.
void vw_gradient_record_chunk(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                              struct vw_submission *submission, const struct vw_push_samples *chunk);
// Records the chunk's end, from the field's rgb and density on.
void vw_gradient_record_back(const struct vw_step_passes *step, const struct vw_gradient_passes *gradient,
                             struct vw_submission *submission, const struct vw_push_samples *chunk);
// Returns the piece of `rays` that begins at `first`, up to a chunk.
struct vw_push_samples vw_gradient_chunk(const struct vw_step_passes *step, uint32_t rays, uint32_t first,
                                         vw_uint4 key);

// ---- An evaluator ----

struct vw_volume_evaluation {
    uint32_t chunk_rays;                // rays whose samples are held at a time
    struct vw_buffer *samples, *places; // places: NULL without importance samples
    struct vw_pass *composite;
    struct vw_field_passes passes; // the field's
    struct vw_importance importance;
};
static inline struct vw_volume_evaluation *vw_volume_evaluation_of(const struct vw_evaluator *evaluator) {
    return evaluator->of_renderer;
}

extern const struct vw_renderer_step vw_volume_renderer_step;
extern const struct vw_renderer_evaluation vw_volume_renderer_evaluation;

#endif
