// The loops over the effects (kind.h) that are on in a model, or in a step of it.
#ifndef VIEWWORTH_TRAIN_EFFECTS_EFFECTS_H
#define VIEWWORTH_TRAIN_EFFECTS_EFFECTS_H

#include "train/effects/kind.h"
#include "train/model.h"
#include "train/passes.h"

// ---- Of a model ----

enum vw_status vw_effects_initialise(const struct vw_model *model, const struct vw_scene *scene,
                                     const struct vw_drawn *drawn, void *params);

// Writes the exposures of photos that points tell (appearance.c), where the effect takes them.
enum vw_status vw_appearance_take_exposures(const struct vw_model *model, const struct vw_scene *scene, void *params);

// Returns whether validation fits a gain and a bias to each view.
bool vw_effects_fit(const struct vw_model *model);
// Returns whether validation sees a view by the view's photo.
bool vw_effects_see_photos(const struct vw_model *model);
// Returns whether passes of a step read which photo it is on, of vw_step_state.
bool vw_effects_know_photos(const struct vw_model *model);
// Returns the model's specialization for validation and rendering, without the effects of training alone.
struct vw_specialization vw_effects_specialise_validation(const struct vw_model *model);
// Returns VW_ERROR_USAGE and names the effect when one is on that lasting credit cannot be computed with.
enum vw_status vw_effects_check_adjoint(const struct vw_model *model);

struct vw_camera_corrections; // train/trainer.h
struct vw_radiance_field;
// Measures the corrections of these views' cameras by the effect pose, 0 without it.
enum vw_status vw_pose_measure(const struct vw_radiance_field *field, const uint32_t *views, uint32_t count,
                               struct vw_camera_corrections *corrections);

// Returns the range of params of the network of the effect visibility or uncertainty, empty without the effect.
struct vw_param_range vw_visibility_network(const struct vw_model *model);
struct vw_param_range vw_uncertainty_network(const struct vw_model *model);

// ---- Buffers and passes ----

// The buffers of effects, by slot.
struct vw_effect_buffers {
    struct vw_buffer *params;          // the block of all params
    struct vw_buffer *const *of_field; // the buffers that rendering needs as well
    struct vw_buffer *const *of_step;  // NULL outside of a step
};

// Creates the buffers that belong to the field, or those of a step, by slot; `pixels`: room for those of many steps.
enum vw_status vw_effects_create_buffers(const struct vw_model *model, struct vw_gpu_objects *objects, bool of_field,
                                         uint32_t padded_rays, uint64_t pixels,
                                         struct vw_buffer *created[VW_SLOT_COUNT]);
// Returns the bytes per pixel of what is uploaded beside pixels; writes it for a step whose pixels are drawn.
uint64_t vw_effects_pixel_bytes(const struct vw_model *model);
void vw_effects_draw_pixels(const struct vw_model *model, const struct vw_step_passes *step, uint32_t view,
                            uint32_t first_pixel);
// Fills those of the field.
enum vw_status vw_effects_fill(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                               struct vw_buffer *const *buffers);
// Binds the buffers of effects and their ranges of params after `*count`, which it advances. Buffers that do not exist
// are bound as unused. Slots that are bound already are left alone.
void vw_effects_bind(const struct vw_model *model, const struct vw_effect_buffers *buffers, struct vw_binding *bindings,
                     uint32_t *count);
// Appends the buffers that one step leaves to the next, beside the params.
void vw_effects_training_state(const struct vw_model *model, const struct vw_effect_buffers *buffers,
                               struct vw_buffer **state, uint32_t *count);

// Creates the passes of a step, or only those that see photos.
enum vw_status vw_effects_create_passes(const struct vw_model *model, struct vw_gpu_objects *objects,
                                        const struct vw_pass_params *common, bool of_step,
                                        struct vw_effect_sets *effects);
// Creates and destroys what the effects of a step have beyond buffers and passes.
enum vw_status vw_effects_create_extras(const struct vw_model *model, struct vw_step_passes *step);
void vw_effects_destroy_extras(const struct vw_model *model, struct vw_step_passes *step);

// ---- Recording: what the effects add to a step, in its order ----

void vw_effects_record_rays(const struct vw_model *model, const struct vw_effect_sets *effects,
                            const struct vw_step_passes *step, struct vw_submission *submission,
                            const struct vw_push_rays *rays);
// Records what a photo makes of the field, before the field sees its rays; also in an evaluator.
void vw_effects_record_photo(const struct vw_model *model, const struct vw_effect_sets *effects,
                             struct vw_submission *submission, uint32_t view);
void vw_effects_record_chunk_gradient(const struct vw_model *model, const struct vw_effect_sets *effects,
                                      struct vw_submission *submission, const struct vw_push_samples *chunk);
void vw_effects_record_gradient(const struct vw_model *model, const struct vw_effect_sets *effects,
                                const struct vw_step_passes *step, struct vw_submission *submission,
                                const struct vw_push_rays *rays, uint64_t number);
// Records the updates. push->count: the padded rays of a step.
void vw_effects_record_update(const struct vw_model *model, const struct vw_effect_sets *effects,
                              struct vw_submission *submission, const struct vw_push_update *push);

#endif
