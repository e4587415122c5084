// Validation: the fixed pixels of the validation views, the passes that render and measure them, and how their error
// sums are read. A pure function of the params (decision 1).
//
// A measurement is a run of vec4 rows in the scalars: first the row of the step before it, then one per validation view
// (squared error high and low, absolute error high and low).
#ifndef VIEWWORTH_TRAIN_VALIDATION_VALIDATION_H
#define VIEWWORTH_TRAIN_VALIDATION_VALIDATION_H

#include "gpu/compute.h"
#include "train/evaluator.h"
#include "train/pixels.h"
#include "viewworth/types.h"

// Validation of photos that differ in exposure. Every measurement fits a gain and a bias to each view on rays of the
// photo's left half and takes the errors on rays of its right half (shaders/effects/appearance/fit_views.comp). The fit
// is a function of the params alone, as all of validation (decision 1). If the width is odd, the middle column is in
// neither half.
struct vw_view_fit {          // all zero when validation fits nothing
    struct vw_buffer *ranges; // vw_ray_range per validation view: the rays to fit on
    struct vw_buffer *fits;   // vw_appearance per validation view
    struct vw_pass *pass;
};

struct vw_pixel_columns vw_view_fit_left_half(const struct vw_scene *scene, uint32_t view);
struct vw_pixel_columns vw_view_fit_right_half(const struct vw_scene *scene, uint32_t view);
enum { VIEW_FIT_RAYS_MAX = 128 }; // single pixels to fit a view on; more do not improve the fit of two numbers

struct vw_validation {           // all zero in a training without validation
    uint32_t *views, view_count; // owned; scene indices
    uint32_t *pixel_counts;      // owned; pixels with weight, per view
    double *weights;             // owned; per view, in the means over the views
    uint32_t ray_count;          // rays that are scored; those to fit views on follow them
    struct vw_evaluator evaluator;
    struct vw_gpu_objects objects; // owned: the buffers and passes that follow
    struct vw_view_fit view_fit;
    struct vw_buffer *ranges; // vw_ray_range per view
    struct vw_pass *reduce_views;
};

// Lists the views of the split val. VW_ERROR_INPUT when there is none.
enum vw_status vw_validation_list_views(const struct vw_scene *scene, struct vw_validation *validation);

struct vw_validation_params {
    struct vw_radiance_field *field; // borrowed
    const struct vw_scene *scene;
    uint32_t ray_count;        // in total, spread over the views
    uint64_t seed;             // seed of the choice of pixels; 0 in all runs that validate on the same ones
    bool masks;                // mask files are obeyed
    struct vw_buffer *scalars; // takes the measurements
};
// Chooses the pixels and creates the passes for the views that are listed. VW_ERROR_INPUT, naming the view, when one
// has no usable pixel.
enum vw_status vw_validation_create(const struct vw_validation_params *params, struct vw_validation *validation);
void vw_validation_destroy(struct vw_validation *validation);

uint32_t vw_validation_rows_per_measurement(const struct vw_validation *validation);

// Records the validation of the field as it is, into the rows after scalar_row. Does nothing without validation.
void vw_validation_record(const struct vw_validation *validation, struct vw_submission *submission,
                          uint32_t scalar_row);

struct vw_field_measurement {
    double val_psnr, val_psnr_pooled, val_l1; // as in vw_step_record
    uint32_t floored_views;
    bool finite; // all sums are; else the values mean nothing
};
// Reads a measurement, whose rows are `rows`. `views` takes the error of each view; it may be NULL.
struct vw_field_measurement vw_validation_read(const struct vw_validation *validation, const vw_float4 *rows,
                                               struct vw_view_error *views);

#endif
