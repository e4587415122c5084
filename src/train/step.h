// One training step on the device: from the pixels of one photo to updated params.
//   rays of one photo -> field forward -> composite + loss -> field backward -> optimiser
#ifndef VIEWWORTH_TRAIN_STEP_H
#define VIEWWORTH_TRAIN_STEP_H

#include "train/effects/appearance.h"
#include "train/field.h"
#include "train/fields/registry.h"
#include "gpu/compute.h"
#include "train/effects/consistency.h"
#include "train/effects/occupancy.h"
#include "train/effects/pose.h"
#include "train/effects/visibility.h"
#include "train/importance.h"
#include "train/effects/transient.h"

// The passes that go from rays to gradients. Several sets of them, each with its specialization, may share the buffers
// of a step: those of the training itself, and those of the backward sweep (sweep_passes.h).
struct gradient_passes {
    struct vw_specialization specialization;
    struct vw_pass *generate, *backward_rays;
    struct vw_pass *gradient_sky; // NULL without the effect
    struct field_passes field;
    struct importance importance;
};

struct schedule;

struct step_passes {
    struct field *field;                // borrowed
    struct schedule *schedule;          // borrowed; of the consistency loss
    struct vw_buffer *pixels, *scalars; // borrowed
    uint32_t rays, padded_rays, chunk_rays;
    struct vw_buffer *ray_buffer, *samples, *d_samples, *ray_loss, *overflow;
    struct vw_buffer *places; // of a chunk's samples; NULL without importance samples
    struct vw_buffer *weight_partials, *d_weights, *weight_moments;
    struct vw_buffer *d_sky; // NULL without the effect
    struct vw_buffer *d_grid, *grid_moment1, *grid_moment2, *grid_visits;
    struct gradient_passes gradient;
    struct vw_pass *reduce_loss, *update_weights, *update_grid[VW_LEVELS_MAX]; // update_grid: per window
    struct appearance appearance;
    struct occupancy occupancy;
    struct visibility visibility;
    struct transient transient;
    struct pose pose;
    struct encoder_passes encoder;
    struct encoder_gradient encoder_gradient;
    struct consistency *consistency; // NULL without that loss
};

// `schedule` says of which photos the steps are. `pixels` holds vw_pixel of many steps, `scalars` takes vec4 rows. All
// three outlive the passes.
enum vw_status step_create(struct field *field, const struct vw_config *config, struct schedule *schedule,
                           struct vw_buffer *pixels, struct vw_buffer *scalars, struct step_passes *step);
void step_destroy(struct step_passes *step);

// The state of a training: everything that a step changes and the next one starts from (params, moments, visits, and
// what effects carry). Training resumes from it and the step's number. Returns how many buffers there are.
enum { TRAINING_STATE_BUFFERS_MAX = 16 };
uint32_t step_training_state(const struct step_passes *step, struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX]);

// Bindings of a step's buffers and of its field's. Writes them behind `*count` and advances it.
void step_bind(const struct step_passes *step, struct vw_binding *bindings, uint32_t *count);

// Whose buffers are in variants of the passes over rays alone: sky, appearance and visibility.
bool step_has_ray_effects(const struct vw_specialization *specialization);
// Another set of passes over the step's buffers.
enum vw_status gradient_create(const struct step_passes *step, const struct vw_specialization *specialization,
                               struct gradient_passes *gradient);
void gradient_destroy(struct gradient_passes *gradient);
// Records forward and back through the rays of one chunk, of which the next chunk overwrites all but the gradients.
void gradient_record_chunk(const struct step_passes *step, const struct gradient_passes *gradient,
                           struct vw_batch *batch, const struct vw_push_samples *chunk);
// Its beginning behind the placing of samples, up to their rgb and density, by these passes of the field.
void gradient_record_forward(const struct step_passes *step, const struct field_passes *passes, struct vw_batch *batch,
                             const struct vw_push_samples *chunk);
// Its end, from there on.
void gradient_record_back(const struct step_passes *step, const struct gradient_passes *gradient,
                          struct vw_batch *batch, const struct vw_push_samples *chunk);
// The piece of `rays` that begins at `first`, up to a chunk.
struct vw_push_samples gradient_chunk(const struct step_passes *step, uint32_t rays, uint32_t first, vw_uint4 key);
// What follows the last chunk of `rays`.
void gradient_record_sky(const struct gradient_passes *gradient, struct vw_batch *batch, uint32_t rays);

// Records, behind generate_rays, what the step's photo makes of the field's colours.
void step_record_appearance(const struct step_passes *step, struct vw_batch *batch);
// Records the first part of a step, up to the loss of each ray and the gradients.
void step_record_gradients(const struct step_passes *step, struct vw_batch *batch, uint64_t number,
                           uint32_t first_pixel);
// Records the optimiser's part at the step's learning rate, which moves the params by 1 + `extra` times what it says
// (0 in every run).
void step_record_update(const struct step_passes *step, struct vw_batch *batch, uint64_t number, float extra);
// Records the last part: the step's loss and flags, to scalars[scalar_row].
void step_record_loss(const struct step_passes *step, struct vw_batch *batch, uint32_t scalar_row);

// Records step `number` (from 1) on the pixels from `first_pixel` on; the loss and the flags go to scalars[scalar_row].
void step_record(const struct step_passes *step, struct vw_batch *batch, uint64_t number, uint32_t first_pixel,
                 uint32_t scalar_row);

#endif
