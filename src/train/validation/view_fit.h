// Validation of photos that differ in exposure. Every measurement fits a gain and a bias to each view on rays of the
// photo's left half and takes the errors on rays of its right half (shaders/effects/appearance/fit_views.comp). The fit
// is a function of the params alone, as all of validation (decision 1). If the width is odd, the middle column is in
// neither half.
#ifndef VIEWWORTH_TRAIN_VALIDATION_VIEW_FIT_H
#define VIEWWORTH_TRAIN_VALIDATION_VIEW_FIT_H

#include "gpu/compute.h"
#include "train/evaluator.h"
#include "train/pixels.h"

struct vw_view_fit {          // all zero when validation fits nothing
    struct vw_buffer *ranges; // vw_ray_range per validation view: the rays to fit on
    struct vw_buffer *fits;   // vw_appearance per validation view
    struct vw_pass *pass;
};

struct vw_pixel_columns vw_view_fit_left_half(const struct vw_scene *scene, uint32_t view);
struct vw_pixel_columns vw_view_fit_right_half(const struct vw_scene *scene, uint32_t view);

// Writes the fixed pixels to fit each view on, after the `*written` pixels that are scored: as many per view as are
// scored, but at most VIEW_FIT_RAYS_MAX, since more do not improve the fit of two numbers. `seed`, `masks`
// and `side` are those of the scored ones (vw_pixels_stratify_squares).
enum { VIEW_FIT_RAYS_MAX = 128 };
void vw_view_fit_choose_pixels(const struct vw_scene *scene, const uint32_t *views, uint32_t count, uint64_t seed,
                               bool masks, uint32_t side, const struct vw_ray_range *scored, struct vw_pixel *pixels,
                               uint32_t *written, struct vw_ray_range *ranges);
// Creates the pass over an evaluator that renders those pixels as well. `objects` own it.
enum vw_status vw_view_fit_create(const struct vw_evaluator *evaluator, struct vw_gpu_objects *objects,
                                  const struct vw_ray_range *ranges, uint32_t count, struct vw_view_fit *fit);
// Records the fit, between rendering and reduce_views.
void vw_view_fit_record(const struct vw_view_fit *fit, struct vw_submission *submission, uint32_t view_count);

#endif
