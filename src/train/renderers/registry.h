// The registry of renderers: what turns params into colours of rays, and takes the gradients by these back to the
// params. A field (vw_config.field) belongs to a renderer. Photos, pixels, rays, losses, the optimiser of weights,
// validation, checkpoints and the ledger are the same for every renderer.
#ifndef VIEWWORTH_TRAIN_RENDERERS_REGISTRY_H
#define VIEWWORTH_TRAIN_RENDERERS_REGISTRY_H

#include "gpu/compute.h"
#include "interface.h"
#include "viewworth/gpu.h"
#include "viewworth/train.h"

struct vw_device_choices; // train/device_choices.h, and so on
struct vw_drawn;
struct vw_evaluator;
struct vw_model;
struct vw_pixel_draw;
struct vw_radiance_field;
struct vw_scene;
struct vw_step_passes;

// Renderers as a set, for what works with some of them.
enum { VW_RENDERER_VOLUME = 1, VW_RENDERER_SPLATS = 2, VW_RENDERERS_ALL = 3 };

// A renderer's part of a step.
struct vw_renderer_step {
    // Draws the pixels of a step on a photo, which will be those from `first_pixel` of the step's buffer on, or records
    // that where the device does. Returns how many of them, from the first on, a step has to look at.
    uint32_t (*draw_pixels)(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                            const struct vw_pixel_draw *draw, uint32_t first_pixel);
    // Creates its buffers, then its passes, of a step. The step owns them.
    enum vw_status (*create_buffers)(struct vw_step_passes *step);
    enum vw_status (*create_passes)(struct vw_step_passes *step);
    // Destroys what of_renderer owns beyond the step's objects; may be NULL.
    void (*destroy)(struct vw_step_passes *step);
    // Binds the buffers that its passes and those of effects share, after the first `*count`; may be NULL.
    void (*bind)(const struct vw_step_passes *step, struct vw_binding *bindings, uint32_t *count);
    // Appends the buffers that one step leaves to the next, beside the params and the moments of weights.
    void (*training_state)(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count);
    // Records everything of the step's photo from its rays to the loss of each and the gradients.
    void (*record_gradients)(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                             const struct vw_push_rays *rays);
    // Records the update of params that update_weights does not move.
    void (*record_update)(const struct vw_step_passes *step, struct vw_submission *submission,
                          struct vw_push_update update);
};

// A renderer's part of an evaluator.
struct vw_renderer_evaluation {
    // Creates what an evaluator needs from its pixels to their colours, `generate` included. The evaluator owns it.
    enum vw_status (*create)(struct vw_evaluator *evaluator);
    void (*destroy)(struct vw_evaluator *evaluator); // likewise
    // Prepares for these pixels, which the evaluator has; may be NULL.
    enum vw_status (*take_pixels)(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count);
    // Records the rendering of all rays into colours.
    void (*record)(const struct vw_evaluator *evaluator, struct vw_submission *submission);
};

struct vw_renderer_kind {
    bool depth_along_axis; // depths that it renders are along the camera's axis, else along the ray
    // Sets the constants and sizes that the params are laid out by. The first to be called.
    enum vw_status (*specialise)(struct vw_model *model);
    // Lays out the first params of the block: those that lasting credit goes back to, and, after the effects of which
    // this is true as well, those that it does not go back to (may be NULL).
    void (*lay_out)(const struct vw_scene *scene, struct vw_model *model);
    void (*lay_out_unfollowed)(struct vw_model *model);
    // Lays out what depends on the device.
    enum vw_status (*fit)(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model);
    enum vw_status (*initialise)(const struct vw_model *model, const struct vw_scene *scene,
                                 const struct vw_drawn *drawn, void *params);
    // Creates what passes over a field need beyond its params, and binds it and the renderer's params for them, after
    // the first `*count`. The field owns it. Both may be NULL.
    enum vw_status (*create_field)(struct vw_radiance_field *field);
    void (*bind_field)(const struct vw_radiance_field *field, bool training, struct vw_binding *bindings,
                       uint32_t *count);
    const struct vw_renderer_step *step;
    const struct vw_renderer_evaluation *evaluation;
};

extern const struct vw_renderer_kind renderer_volume, renderer_splats;

// Returns the VW_RENDERER_* that makes colours of a field.
static inline uint32_t vw_renderer_of(enum vw_field field) {
    return field == VW_FIELD_SPLATS ? VW_RENDERER_SPLATS : VW_RENDERER_VOLUME;
}

static inline const struct vw_renderer_kind *vw_renderer_kind_of(enum vw_field field) {
    return vw_renderer_of(field) == VW_RENDERER_SPLATS ? &renderer_splats : &renderer_volume;
}

#endif
