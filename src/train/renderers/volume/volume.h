// The functions of the renderer `volume` (renderers/registry.h), for its table in volume.c.
#ifndef VIEWWORTH_TRAIN_RENDERERS_VOLUME_VOLUME_H
#define VIEWWORTH_TRAIN_RENDERERS_VOLUME_VOLUME_H

#include "train/evaluator.h"
#include "train/step.h"

struct vw_pixel_draw; // train/pixels.h

uint32_t vw_volume_draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                               const struct vw_pixel_draw *draw, uint32_t first_pixel);
enum vw_status vw_volume_create_step_buffers(struct vw_step_passes *step);
enum vw_status vw_volume_create_step_passes(struct vw_step_passes *step);
void vw_volume_training_state(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count);
void vw_volume_record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                                const struct vw_push_rays *rays);
void vw_volume_record_update(const struct vw_step_passes *step, struct vw_submission *submission,
                             struct vw_push_update update);

enum vw_status vw_volume_create_evaluation(struct vw_evaluator *evaluator);
void vw_volume_record_evaluation(const struct vw_evaluator *evaluator, struct vw_submission *submission);

#endif
