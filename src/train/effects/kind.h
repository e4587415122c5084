// The interface of effects that have params, buffers or passes of their own, as fields have one (fields/registry.h). A
// kind is a row of the table in registry.c. The step, the field, the evaluator and the adjoint loop over
// that table, by the functions below. A function left NULL does nothing; what an effect has is created, and its
// functions are called, only where its specialization constant is not 0 (decision 7).
//
// Outside effects/, these files of train/ name an effect: fields/hash.c and fields/mlp.c (transient), field.c
// (unbounded), model.c (sky, background, unbounded, wide_box), step.c (sky), renderers/volume/ (transient,
// appearance_code, appearance_encoder), adjoint/adjoint_passes.c (appearance_code), trainer_outputs.c (appearance),
// evaluator.c (unbounded), renderers/splats/ (distortion).
#ifndef VIEWWORTH_TRAIN_EFFECTS_KIND_H
#define VIEWWORTH_TRAIN_EFFECTS_KIND_H

#include "gpu/compute.h"
#include "interface.h"
#include "viewworth/train.h"

struct vw_drawn; // model.h
struct vw_model; // model.h, and so on
struct vw_scene;
struct vw_step_passes;

enum { VW_EFFECT_PASSES_MAX = 8, VW_EFFECT_BUFFERS_MAX = 8, VW_EFFECT_UPDATE = VW_EFFECT_PASSES_MAX - 1 };

// The offset of an effect's switch in struct vw_specialization.
#define VW_EFFECT_CONSTANT(effect) offsetof(struct vw_specialization, effect_##effect)

// A buffer of an effect, kept and bound under its slot.
struct vw_effect_buffer {
    uint32_t slot;
    const char *name;
    uint64_t size_bytes; // 0: it is not created, and bound as unused
    enum vw_effect_use {
        VW_EFFECT_OF_STEP,
        VW_EFFECT_CARRIED = 1,   // part of the training's state: one step leaves it to the next
        VW_EFFECT_OF_FIELD = 2,  // rendering needs it too, so the field owns it; otherwise a step does
        VW_EFFECT_OF_PIXELS = 4, // the host fills it beside the pixels that it draws; size_bytes: of one pixel
    } use;
};

// The passes of an effect in one use, in the order of the effect's `shaders`; the last is its `update`.
struct vw_effect_passes {
    struct vw_pass *passes[VW_EFFECT_PASSES_MAX];
};

// The passes of all effects in one use, by place in the table of kinds.
struct vw_effect_sets {
    struct vw_effect_passes sets[VW_EFFECT_COUNT_MAX];
};

enum vw_effect_adjoint {
    VW_ADJOINT_FOLLOWS, // lasting credit goes back to its columns, and to the ranges that are gathered
    VW_ADJOINT_HOLDS,   // it keeps them fixed
    VW_ADJOINT_REFUSES, // it cannot be computed with the effect on
};

struct vw_effect_kind {
    const char *name;
    size_t constant; // offset of its switch in struct vw_specialization
    enum vw_effect_adjoint adjoint;
    bool training_alone;    // validation and rendering do without it
    bool fits_views;        // validation fits a gain and a bias to each view
    bool binds_ray_buffers; // the variants VW_RAY_EFFECTS of the passes over rays bind its buffers
    // Passes of a step, of which validation and rendering have the first photo_pass_count as well. Where there are
    // such, they call record_photo(): they see a view by its own photo.
    const struct vw_shader *shaders[VW_EFFECT_PASSES_MAX];
    uint32_t photo_pass_count;
    bool (*updates)(const struct vw_model *model); // whether there is an update; NULL: yes
    const struct vw_shader *update; // moves what belongs to the step's photo, before update_weights, in one workgroup

    // Params: columns that update_weights moves, after those of the field; then ranges, of which those of views of
    // other splits than train stay 0. Initial values are 0 except for what initialise() draws.
    uint32_t ranges[2]; // slots of the latter, 0: no more
    void (*lay_out_columns)(struct vw_model *model);
    void (*lay_out_ranges)(struct vw_model *model, uint64_t trained_views);
    void (*initialise)(const struct vw_model *model, const struct vw_drawn *drawn, void *params);

    // Lists its buffers, for a step of so many rays (0: those of the field alone matter); returns how many.
    uint32_t (*list_buffers)(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers);
    // Fills the field's buffers.
    enum vw_status (*fill)(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                           struct vw_buffer *const *buffers);
    // Fills its buffer of pixels for a step, whose pixels are `drawn`.
    void (*draw_pixels)(const struct vw_step_passes *step, uint32_t view, uint32_t first_pixel);
    // Creates and destroys what a step has beyond buffers and passes; called last and first.
    enum vw_status (*create)(struct vw_step_passes *step);
    void (*destroy)(struct vw_step_passes *step);

    // In the order in which a step records them.
    void (*record_rays)(const struct vw_step_passes *step, struct vw_pass *const *passes,
                        struct vw_submission *submission,
                        const struct vw_push_rays *rays); // after generate_rays
    void (*record_photo)(const struct vw_model *model, struct vw_pass *const *passes, struct vw_submission *submission,
                         uint32_t view); // before the field sees rays; in a step, which knows its photo, `view` is 0
    void (*record_chunk_gradient)(const struct vw_model *model, struct vw_pass *const *passes,
                                  struct vw_submission *submission,
                                  const struct vw_push_samples *chunk); // after the field's backward pass
    void (*record_gradient)(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays,
                            uint64_t number); // after the last chunk
};

static inline bool vw_effect_is_on(const struct vw_effect_kind *kind, const struct vw_specialization *specialization) {
    return *(const uint32_t *)((const char *)specialization + kind->constant) != 0;
}

#endif
