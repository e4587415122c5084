// The renderer splats (--field splats): layout and initial values of its params, its part of a step and of an
// evaluator, over the passes of splats.h.
#ifndef VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLATS_RENDERER_H
#define VIEWWORTH_TRAIN_RENDERERS_SPLATS_SPLATS_RENDERER_H

#include "train/evaluator.h"
#include "train/renderers/splats/splats.h"
#include "train/step.h"

// Unit of the rates: the learning rate of the passes is that of effects, as with the hash grid, at the default --lr.
#define VW_SPLAT_RATE_UNIT 0.001

// Counts the points of a scene that a train view sees.
uint32_t vw_splats_count_points(const struct vw_model *model, const struct vw_scene *scene);
// Writes the initial values of all splats: of points, or, where no train view sees any, drawn in the box.
enum vw_status vw_splats_start(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                               float *params);
// Writes for each point its root mean square distance to the three nearest others, but at least `least`.
enum vw_status vw_splats_measure_gaps(const float (*points)[3], uint32_t count, float least, float *gaps);

// Returns params of passes, without room for views, tiles and pairs, and fills in `specialization`.
struct vw_splat_pass_params vw_splats_pass_params(const struct vw_radiance_field *field,
                                                  const struct vw_specialization *run,
                                                  struct vw_splat_specialization *specialization);
// Returns room for the pairs of a drawing: for tiles full of splats, for a picture of all splats, and never for more
// than the tiles can have or the device binds.
uint32_t vw_splats_pair_room(const struct vw_radiance_field *field, const struct vw_splat_room *room);
struct vw_binding vw_splats_binding(const struct vw_radiance_field *field);
struct vw_push_splats vw_splats_push(const struct vw_model *model);

uint32_t vw_splats_draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                               const struct vw_pixel_draw *draw, uint32_t first_pixel);
enum vw_status vw_splats_create_step_buffers(struct vw_step_passes *step);
enum vw_status vw_splats_create_step_passes(struct vw_step_passes *step);
void vw_splats_destroy_step(struct vw_step_passes *step);
void vw_splats_training_state(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count);
void vw_splats_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                                const struct vw_push_rays *rays);
void vw_splats_record_update(const struct vw_step_passes *step, struct vw_submission *submission,
                             struct vw_push_update update);

const struct vw_splat_drawing *vw_splats_step_drawing(const struct vw_step_passes *step);

enum vw_status vw_splats_create_evaluation(struct vw_evaluator *evaluator);
void vw_splats_destroy_evaluation(struct vw_evaluator *evaluator);
enum vw_status vw_splats_take_pixels(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count);
void vw_splats_record_evaluation(const struct vw_evaluator *evaluator, struct vw_submission *submission);
const struct vw_splat_drawing *vw_splats_evaluation_drawing(const struct vw_evaluator *evaluator);
// Returns how many drawings the pixels are, and adds up their views.
uint32_t vw_splats_count_parts(const struct vw_evaluator *evaluator, uint32_t *views);

#endif
