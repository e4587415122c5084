// The field on the device: the params block, the cameras, and what passes over them share.
#ifndef VIEWWORTH_TRAIN_FIELD_H
#define VIEWWORTH_TRAIN_FIELD_H

#include "gpu/compute.h"
#include "train/model.h"
#include "train/passes.h"

struct vw_radiance_field {
    struct vw_gpu *gpu;            // borrowed
    struct vw_gpu_objects objects; // owned: all that follow
    const struct vw_model *model;  // borrowed
    const struct vw_scene *scene;  // borrowed
    const struct vw_view *posed;   // borrowed: stands in for the view `posed_view`; NULL: none does
    uint32_t posed_view;
    struct vw_buffer *params;                        // model->param_bytes
    struct vw_buffer *cameras;                       // vw_gpu_camera per view
    struct vw_buffer *rows, *grid_rows;              // activations of one training chunk; grid_rows: of the field hash
    struct vw_buffer *head_rows;                     // rows of the effect transient's head, with the field hash
    struct vw_buffer *d_rows;                        // gradients by these, or by the rows of the field mlp
    struct vw_buffer *step_state;                    // one vw_step_state
    struct vw_buffer *effect_buffers[VW_SLOT_COUNT]; // the effects' that rendering needs as well, by slot
};

// Writes the initial values of the whole params block (param_bytes), which is 0: those of the renderer and of effects.
// They are a function of the seed, and with splats of the scene's cameras and points; else `scene` may be NULL.
enum vw_status vw_model_initialise(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                   void *params);

enum vw_status vw_field_create(struct vw_gpu *gpu, const struct vw_model *model, const struct vw_scene *scene,
                               uint64_t seed, struct vw_radiance_field *field);
void vw_field_destroy(struct vw_radiance_field *field);

// Returns the camera of a view, in coordinates of `box`, as the effects that are on see it.
struct vw_gpu_camera vw_field_camera(const struct vw_model *model, const struct vw_view *view,
                                     const struct vw_box *box);

// Lends a view the camera of `posed` until the next call; NULL: it has its own again.
enum vw_status vw_field_pose(struct vw_radiance_field *field, uint32_t view, const struct vw_view *posed);
// Returns a view as it is seen.
const struct vw_view *vw_field_view(const struct vw_radiance_field *field, uint32_t view);

// Binds the buffers of the field that several passes share: grid (as both views), all weights, rows, and, for passes of
// the training, the state of the step. Writes the bindings after the first `*count` and advances it.
void vw_field_bind(const struct vw_radiance_field *field, bool training, struct vw_binding *bindings, uint32_t *count);

#endif
