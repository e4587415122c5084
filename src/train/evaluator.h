// The passes that render rays from a field without changing anything. Validation and `render` are two evaluators over
// the same field (decision 1: a pure function of the params).
#ifndef VIEWWORTH_TRAIN_EVALUATOR_H
#define VIEWWORTH_TRAIN_EVALUATOR_H

#include "train/effects/effects.h"
#include "train/field.h"

extern const char evaluator_role[]; // role of its passes, in the timers

// Rays of one view that follow one another.
struct vw_view_rays {
    uint32_t view, first, count;
};

struct vw_evaluator {
    struct vw_radiance_field *field; // borrowed
    struct vw_gpu_objects objects;   // owned: all buffers and passes
    uint32_t ray_count;              // with padding
    bool depth;                      // colours are depths
    struct vw_buffer *pixels, *rays, *colours;
    struct vw_pass *generate;
    struct vw_effect_sets effects;
    void *of_renderer;                // owned: what the renderer has beside
    struct vw_submission *submission; // for vw_evaluator_set_pixels
    // With an effect that sees photos, as the pixels are; owned. Until there are pixels, all rays are of view 0.
    struct vw_view_rays *views;
    uint32_t view_count;
};

// Creates an evaluator for up to `rays` rays. With `depth` its colours are, in x, depths times what the ray has of
// them: its share 1 - w. A volume tells them as distances along the ray (t of distance_at() in
// shaders/rays/sampling.glsl), splats along the camera's axis; in box edges.
enum vw_status vw_evaluator_create(struct vw_radiance_field *field, uint32_t rays, bool depth,
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

// ---- Renders ----

struct vw_picture {
    uint32_t view;       // index in the field's scene
    uint32_t size_px[2]; // at most the view's: a smaller picture takes the pixel in the middle of each of its own
    double depth_share;  // > 0: instead of rgb the expected depth along the camera's axis in world units, 0 where the
                         // ray sees no more than this share of anything
    const struct vw_view *posed; // another camera in place of the view's; NULL: its own
};

// Renders pictures of the same size and kind, one after another: floats, rows top to bottom, rgb or a depth per pixel.
// Owned by the caller.
enum vw_status vw_field_render(struct vw_radiance_field *field, const struct vw_picture *pictures, uint32_t count,
                               float **values);

#endif
