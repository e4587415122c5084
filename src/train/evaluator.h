// The passes that render rays from a field without changing anything. Validation and `render` are two evaluators over
// the same field (decision 1: a pure function of the params).
#ifndef VIEWWORTH_TRAIN_EVALUATOR_H
#define VIEWWORTH_TRAIN_EVALUATOR_H

#include "train/effects/kind.h"
#include "train/field.h"
#include "train/fields/registry.h"
#include "train/renderers/volume/importance.h"

struct vw_splat_evaluation; // renderers/splats/splats_renderer.h

extern const char evaluator_role[]; // role of its passes, in the timers

// Rays of one view that follow one another.
struct vw_view_rays {
    uint32_t view, first, count;
};

struct vw_evaluator {
    struct vw_radiance_field *field; // borrowed
    struct vw_gpu_objects objects;   // owned: all buffers and passes
    uint32_t ray_count;              // with padding
    bool depth;                      // colours are depths: see vw_evaluator_create_of_depth()
    struct vw_buffer *pixels, *rays, *colours;
    struct vw_pass *generate;
    struct vw_effect_sets effects;
    // The volume's: rays whose samples are held at a time, and these samples with their places, which are NULL without
    // importance samples.
    uint32_t chunk_rays;
    struct vw_buffer *samples, *places;
    struct vw_pass *composite;
    struct vw_field_passes passes; // the field's
    struct vw_importance importance;
    struct vw_splat_evaluation *splats; // owned; of the renderer splats
    struct vw_submission *submission;   // for vw_evaluator_set_pixels
    // With an effect that sees photos, as the pixels are; owned. Until there are pixels, all rays are of view 0.
    struct vw_view_rays *views;
    uint32_t view_count;
};

// Creates an evaluator for up to `rays` rays.
enum vw_status vw_evaluator_create(struct vw_radiance_field *field, uint32_t rays, struct vw_evaluator *evaluator);
// Creates one whose colours are, in x, depths times what the ray has of them: its share 1 - w. A volume tells them as
// distances along the ray (t of distance_at() in shaders/rays/sampling.glsl), splats along the camera's axis; in box
// edges.
enum vw_status vw_evaluator_create_of_depth(struct vw_radiance_field *field, uint32_t rays,
                                            struct vw_evaluator *evaluator);
void vw_evaluator_destroy(struct vw_evaluator *evaluator);
// Makes the rays of `count` <= `rays` pixels and waits for them. The rest is padding.
enum vw_status vw_evaluator_set_pixels(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count);
// Renders the rays that there are, and waits.
enum vw_status vw_evaluator_run(struct vw_evaluator *evaluator);
// Renders `count` pixels: their colours over the backdrop, and the transmittance that remains.
enum vw_status vw_evaluator_render(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count,
                                   vw_float4 *colours);
// Records the rendering of all rays into `colours`.
void vw_evaluator_record(const struct vw_evaluator *evaluator, struct vw_submission *submission);
// Returns whether its views are rendered one by one, as `views` lists them.
bool vw_evaluator_sees_photos(const struct vw_evaluator *evaluator);

#endif
