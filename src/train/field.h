// The field on the device: the params block, the cameras, and the passes that render rays from them without changing
// anything. Validation and `render` are two evaluators over the same field (decision 1: a pure function of the params).
#ifndef VIEWWORTH_TRAIN_FIELD_H
#define VIEWWORTH_TRAIN_FIELD_H

#include "gpu/compute.h"
#include "train/model.h"

struct field {
    struct vw_gpu *gpu;            // borrowed
    const struct model *model;     // borrowed
    struct vw_buffer *params;      // model->param_bytes
    struct vw_buffer *cameras;     // vw_gpu_camera per view
    struct vw_buffer *rows, *relu; // activations of one training chunk
    struct vw_buffer *step_state;  // one vw_step_state
    struct vw_buffer *occupancy;   // float per cell, with that effect; else NULL
};

enum vw_status field_create(struct vw_gpu *gpu, const struct model *model, const struct vw_scene *scene, uint64_t seed,
                            struct field *field);
void field_destroy(struct field *field);

// The camera of a view, in coordinates of `box`, as the effects that are on see it.
struct vw_gpu_camera field_camera(const struct model *model, const struct vw_view *view, const struct vw_box *box);

// Bindings of the field that several passes share: grid (as both views), weights with the sky, the sky. Writes them
// behind `*count` and advances it.
void field_bind(const struct field *field, struct vw_binding *bindings, uint32_t *count);

// forward_field, as the grid's features are stored.
const struct vw_shader *field_forward_shader(const struct model *model);

extern const char evaluator_role[]; // of its passes, in the timers

struct evaluator {
    struct field *field; // borrowed
    uint32_t ray_count;  // with padding
    uint32_t chunk_rays; // rays whose samples are held at a time
    struct vw_buffer *pixels, *rays, *samples, *colours;
    struct vw_pass *generate, *forward, *composite;
    struct vw_batch *batch; // for evaluator_set_pixels
};

// An evaluator for up to `rays` rays.
enum vw_status evaluator_create(struct field *field, uint32_t rays, struct evaluator *evaluator);
void evaluator_destroy(struct evaluator *evaluator);
// Makes the rays of `count` <= `rays` pixels and waits for them. The rest is padding.
enum vw_status evaluator_set_pixels(struct evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count);
// Renders the rays that there are, and waits.
enum vw_status evaluator_run(struct evaluator *evaluator);
// Renders `count` pixels: their colours over the backdrop, and the transmittance that remains.
enum vw_status evaluator_render(struct evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count,
                                vw_float4 *colours);
// Records the rendering of all rays into `colours`.
void evaluator_record(const struct evaluator *evaluator, struct vw_batch *batch);

#endif
