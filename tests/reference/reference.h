// The plain-C reference of the training shaders, in double and without a GPU: what the passes ought to compute, written
// from the contracts and the mathematics. Matrices are dense [out][in], the grid is a flat array of features, loops go
// over one ray or one sample.
//
// It shares with the shaders only struct vw_specialization (the numbers of a run) and the buffer layouts it converts
// from.
#ifndef VIEWWORTH_TESTS_REFERENCE_REFERENCE_H
#define VIEWWORTH_TESTS_REFERENCE_REFERENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "train/model.h"

enum {
    REFERENCE_WIDTH_MAX = 64,
    REFERENCE_ENCODING_MAX = 64,
    REFERENCE_GEO = 16,       // density MLP outputs: raw density and 15 features
    REFERENCE_COLOUR_IN = 24, // colour MLP inputs: SH band 0, 15 features, SH bands 1 and 2
    REFERENCE_RGB = 3,
    REFERENCE_CODE = 48, // numbers of a photo's code
};

// ---- camera.c: box coordinates throughout ---------------------------------------------------------------------------

struct reference_ray {
    double origin[3], direction[3]; // direction: unit length
    double near, stride;            // ray parameter of the first stratum, length of one
    double far; // with the effect unbounded `near` and this are distances from the camera, and `origin` is at `near`
    double target[3], weight;
};

// Finds the line from the camera through a pixel, straight from the view: `origin` is the camera itself. Returns false
// beyond the lens model's fold.
bool reference_camera_line(const struct vw_view *view, const struct vw_box *box, double x_px, double y_px,
                           double origin[3], double direction[3]);
// Finds where a line runs within the unit cube grown by `margin` on every side, at parameters >= `least`. Returns false
// when it does not.
bool reference_box_span(const double origin[3], const double direction[3], double least, double margin, double *near,
                        double *far);
struct reference_ray reference_ray_of(const struct vw_ray *ray);

// ---- sampling.c -----------------------------------------------------------------------------------------------------

// Returns the position of a sample within its stratum: drawn in training, the centre otherwise.
double reference_stratum_offset(const struct vw_specialization *s, uint32_t ray, uint32_t sample, vw_uint4 key);
// Computes a sample's position in the field's unit cube.
void reference_sample_position(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample,
                               double offset, double position[3]);
// Computes the position at a place on the ray, counted in strata.
void reference_position_at(const struct vw_specialization *s, const struct reference_ray *ray, double place,
                           double position[3]);
// Returns the length for which a sample stands among all `places` of its ray, which are in order: up to the middles
// towards its neighbours.
double reference_listed_length(const struct vw_specialization *s, const struct reference_ray *ray, const double *places,
                               uint32_t sample);
// Computes the places of the importance samples of a ray, in order, from the optical thicknesses at its even samples
// (of whole strata). `weights` receives those of the strata, which the places follow.
void reference_place_samples(const struct vw_specialization *s, uint32_t ray, const double *taus, vw_uint4 key,
                             double *weights, double *places);
// Returns the length of the stratum that a sample lies in, in box edges.
double reference_stratum_length(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample);

// ---- field_box.c ----------------------------------------------------------------------------------------------------

// Maps box coordinates to the field's unit cube, with the effect unbounded.
void reference_contract(const double box[3], double field[3]);

// ---- hash_grid.c: feature f of entry e of level l is grid[2 * first_pair[l] + e * features + f] ---------------------

struct reference_corner {
    uint64_t first_feature; // index of the entry's feature 0 in the grid
    double weight;
};
void reference_grid_corners(const struct vw_specialization *s, const double position[3], uint32_t level,
                            struct reference_corner corners[8]);
void reference_grid_encode(const struct vw_specialization *s, const double *grid, const double position[3],
                           double *encoding);
// Accumulates into d_grid.
void reference_grid_scatter(const struct vw_specialization *s, const double position[3], const double *d_encoding,
                            double *d_grid);

// ---- spherical_harmonics.c: band 0, band 1 (-y, z, -x), band 2 (xy, -yz, 3zz-1, -xz, xx-yy) -------------------------

void reference_spherical_harmonics(const double direction[3], double values[9]);

// ---- sky.c: what stands behind the field and behind transparent pixels ----------------------------------------------

// Reads the coefficients from the whole params block; leaves them as they are without the effect.
void reference_sky_read(const struct vw_model *model, const float *params, double coefficients[VW_SKY_COLUMNS][3]);
// Computes the gradient by the logits of a ray of which the share `left` reaches the sky of colour `rgb`.
// reference_sky_gradient() adds its part of the coefficients' gradient.
void reference_sky_d_logit(const double rgb[3], double left, const double d_colour[3], double d_logit[3]);
void reference_sky_gradient(const double direction[3], const double d_logit[3],
                            double d_coefficients[VW_SKY_COLUMNS][3]);
// Computes the colour after the field on a ray at the step of `key`: the sky, the background, or black.
void reference_backdrop(const struct vw_specialization *s, const double sky[VW_SKY_COLUMNS][3],
                        const double direction[3], uint32_t ray, vw_uint4 key, double backdrop[3]);
struct reference_photo;
// Computes the pixel's colour, corrected by its photo, on the background, when the run has that effect.
void reference_target(const struct vw_specialization *s, const struct reference_photo *photo,
                      const struct vw_pixel *pixel, uint32_t ray, vw_uint4 key, double target[3]);

// ---- mlp.c ----------------------------------------------------------------------------------------------------------

// One number per weight, [out][in] of each matrix.
struct reference_weights {
    double density1[REFERENCE_WIDTH_MAX * REFERENCE_ENCODING_MAX];
    double density2[REFERENCE_GEO * REFERENCE_WIDTH_MAX];
    double colour1[REFERENCE_WIDTH_MAX * REFERENCE_COLOUR_IN];
    double colour2[REFERENCE_RGB * REFERENCE_WIDTH_MAX];
};

enum { REFERENCE_MATRICES = 4 };
struct reference_matrix {
    const char *name;
    double *values;
    uint32_t out, in;
};
// Lists the four matrices by name and size.
void reference_matrices(const struct vw_specialization *s, struct reference_weights *weights,
                        struct reference_matrix matrices[REFERENCE_MATRICES]);
// Reads the weights from the 4x4 blocks of the params block (see shaders/networks/mlp.glsl). `blocks` has 4 *
// weight_columns floats.
void reference_weights_from_blocks(const struct vw_specialization *s, const float *blocks,
                                   struct reference_weights *weights);
// Returns the index in `blocks` of weight [out][in] of matrix `matrix`.
uint32_t reference_block_index(const struct vw_specialization *s, uint32_t matrix, uint32_t out, uint32_t in);

// One sample on its way through the field.
struct reference_sample {
    double position[3], direction[3];
    double encoding[REFERENCE_ENCODING_MAX];
    double before1[REFERENCE_WIDTH_MAX], hidden1[REFERENCE_WIDTH_MAX]; // before and after the ReLU
    double geo[REFERENCE_GEO];
    double colour_in[REFERENCE_COLOUR_IN];
    double before2[REFERENCE_WIDTH_MAX], hidden2[REFERENCE_WIDTH_MAX];
    double rgb[3], density;
    bool active1[REFERENCE_WIDTH_MAX], active2[REFERENCE_WIDTH_MAX]; // the ReLUs' decisions, for the backward pass
    bool saturated;                                                  // density above its maximum: no gradient
};

// Gradients of each layer's output, as the backward pass through the field finds them.
struct reference_d_sample {
    double hidden1[REFERENCE_WIDTH_MAX], geo[REFERENCE_GEO], hidden2[REFERENCE_WIDTH_MAX], logit[REFERENCE_RGB];
    double encoding[REFERENCE_ENCODING_MAX];
};

extern const double reference_density_max; // per box edge
// Computes rgb and density from sample->encoding and direction.
void reference_networks_forward(const struct vw_specialization *s, const struct reference_weights *weights,
                                struct reference_sample *sample);
void reference_networks_backward(const struct vw_specialization *s, const struct reference_weights *weights,
                                 const struct reference_sample *sample, const double d_rgb[3], double d_raw,
                                 struct reference_d_sample *d_sample);
// Accumulates d_W = d_out x in of all four matrices.
void reference_weights_gradient(const struct vw_specialization *s, const struct reference_sample *sample,
                                const struct reference_d_sample *d_sample, struct reference_weights *d_weights);

// ---- composite.c ----------------------------------------------------------------------------------------------------

struct reference_point { // a sample as compositing sees it
    double rgb[3], density;
    double length; // the stratum's
};
// Returns the transmittance that remains.
double reference_composite(const struct reference_point *points, uint32_t count, const double background[3],
                           double colour[3]);
struct reference_d_point {
    double rgb[3], raw; // by the rgb, and by the logarithm of the density (saturation is the networks' business)
};
void reference_composite_gradient(const struct reference_point *points, uint32_t count, const double background[3],
                                  const double d_colour[3], struct reference_d_point *d_points);

// ---- loss.c ---------------------------------------------------------------------------------------------------------

// Returns one channel's loss; `slope` receives its slope by the error.
double reference_loss(const struct vw_specialization *s, double error, double *slope);
// Returns the second derivative of one channel's loss, as Gauss-Newton products take it: of L1 and Huber that of a
// smooth loss (shaders/rays/loss.glsl).
double reference_curvature(const struct vw_specialization *s, double error);

// ---- appearance.c ---------------------------------------------------------------------------------------------------

double reference_photo_rate(uint64_t visits); // times the learning rate
extern const double reference_photo_ridge, reference_fit_ridge;

struct reference_photo {     // params of one photo; 0 where the effect is off
    double gain[3], bias[3]; // gain: beyond 1
    double code[REFERENCE_CODE];
};
uint32_t reference_photo_count(const struct vw_model *model);
struct reference_photo reference_photo_of(const struct vw_model *model, const float *params, uint32_t view);
void reference_appear(const struct reference_photo *photo, const double rendered[3], double seen[3]);
// Computes what a pixel of the photo would show if the photo's gain and bias were 0, within [0,1].
void reference_correct(const struct reference_photo *photo, const double shown[3], double corrected[3]);
// Sums over rays of a photo's visits: of weights, and by them of rendered values, their squares, what they are short of
// the photo's, and the products with that. A ray whose corrected colour is black or white in a channel tells nothing.
struct reference_photo_sums {
    long double rays, rendered[3], squares[3], missing[3], products[3];
};
// Finds the photo's gain and bias (shaders/effects/appearance/fit_photo.comp); the code stays.
void reference_fit_photo(const struct reference_photo_sums *sums, struct reference_photo *photo);
// Finds gain and bias by which a photo is corrected: its fit, where the mean of the photos that were visited is the
// identity; and the identity itself up to its third visit. The code is 0.
struct reference_photo reference_photo_of_fits(const struct vw_photo_sums *sums, uint32_t count, uint32_t view);
// Computes what a code adds to the weights of the colour network's input 0; code weights are [width][REFERENCE_CODE].
// The gradients are overwritten.
void reference_mix_code(uint32_t width, const double *code_weights, const double code[REFERENCE_CODE], double *shift);
void reference_mix_code_gradient(uint32_t width, const double *code_weights, const double code[REFERENCE_CODE],
                                 const double *d_shift, double *d_code_weights, double d_code[REFERENCE_CODE]);
// Finds the gain beyond 1 and the bias that bring rendered values nearest to targets.
void reference_fit_channel(const double *rendered, const double *target, uint32_t count, double *gain, double *bias);

// ---- visibility.c ---------------------------------------------------------------------------------------------------

enum {
    REFERENCE_VISIBILITY = 4 * VISIBILITY_COLUMNS,    // numbers of the network, at the places that the device has
    REFERENCE_VISIBILITY_CODE = 4 * VISIBILITY_CODE4, // and of a photo's code
};
// Returns the cost of leaving a pixel out, at step `step`.
double reference_size_weight(const struct vw_specialization *s, uint64_t step);
// Returns how visible the field is at a place of a photo, -1 to 1 across it.
double reference_visibility(const double *network, const double *code, const double place[2]);
// Accumulates what a gradient by that says of the network and of the code.
void reference_visibility_gradient(const double *network, const double *code, const double place[2], double d_visible,
                                   double *d_network, double *d_code);

enum { REFERENCE_UNCERTAINTY = 4 * UNCERTAINTY_COLUMNS, REFERENCE_FEATURES = 4 * FEATURE4 };
// Returns the loss up to which a pixel counts wholly with the effect uncertainty, at step `step`.
double reference_certain_loss(const struct vw_specialization *s, uint64_t step);
// Returns how certain a pixel of these features is, the last of them 1.
double reference_certainty(const double *network, const double *features);
// Accumulates what a gradient by that says of the network.
void reference_certainty_gradient(const double *network, const double *features, double d_certain, double *d_network);

// ---- encoder.c: the effect appearance_encoder -----------------------------------------------------------------------

enum { REFERENCE_ENCODER_OUTPUTS = 16 * 16 * 4 * ENCODER4 }; // the first convolution's; each next one has a quarter
struct reference_photo_encoding {
    double thumbnail[THUMBNAIL_PIXELS][4];
    double outputs[ENCODER_LAYERS][REFERENCE_ENCODER_OUTPUTS], mean[4 * ENCODER4], code[REFERENCE_CODE],
        shift[REFERENCE_WIDTH_MAX];
};
// Makes the thumbnail of columns `first` to `end` of a photo.
void reference_thumbnail(const struct vw_view *view, uint32_t first, uint32_t end, bool masks,
                         double thumbnail[THUMBNAIL_PIXELS][4]);
// Fills all but the thumbnail. The network's numbers stand at the places that the device has; `width`: units of the
// colour network.
void reference_encode_photo(const double *network, uint32_t width, struct reference_photo_encoding *encoding);
// Accumulates into d_network.
void reference_encode_photo_gradient(const double *network, uint32_t width,
                                     const struct reference_photo_encoding *encoding, const double *d_shift,
                                     double *d_network);

// Accumulates into d_network from the gradient by the code alone; d_thumbnail is overwritten, and may be NULL.
void reference_code_gradient(const double *network, const struct reference_photo_encoding *encoding,
                             const double *d_code, double *d_network, double d_thumbnail[THUMBNAIL_PIXELS][4]);
// Makes the thumbnail of a square picture of `side` rendered colours a side. reference_picture_gradient() goes back to
// the colours. Both overwrite their results.
void reference_picture_thumbnail(uint32_t side, const double (*colours)[3], double thumbnail[THUMBNAIL_PIXELS][4]);
void reference_picture_gradient(uint32_t side, double d_thumbnail[THUMBNAIL_PIXELS][4], double (*d_colours)[3]);

// ---- fixed_point.c --------------------------------------------------------------------------------------------------

// Adds one sample's part to the features' integer gradients: its gradient, clamped and in quanta, times each corner's
// weight, rounded.
void reference_grid_scatter_fixed(const struct vw_specialization *s, const double position[3], const double *d_encoding,
                                  int64_t *quanta);
// Reads the integer gradient of every feature from the device's words.
void reference_unpack_grid(const struct vw_model *model, const uint64_t *words, int64_t *quanta);

// ---- adam.c ---------------------------------------------------------------------------------------------------------

// Returns what to subtract from a parameter whose mean gradient is `gradient` at its `visits`-th visit; updates the
// moments.
double reference_adam(const struct vw_specialization *s, double gradient, uint64_t visits, double *moment1,
                      double *moment2);

// ---- reductions.c ---------------------------------------------------------------------------------------------------

struct reference_view_error {
    double squared, absolute; // sums over rays and channels
};
struct reference_view_error reference_view_error(const struct vw_ray *rays, const vw_float4 *colours, uint32_t count);

// ---- recipe.c -------------------------------------------------------------------------------------------------------

struct reference_recipe {
    const struct vw_recipe_shape *shapes;
    struct vw_push_recipe push;
};
// Traces a line from `origin` (box coordinates): `rgba` receives the colour and coverage seen along it. Returns how far
// off that is, 0 when nothing is met.
double reference_recipe_trace(const struct reference_recipe *recipe, const double origin[3], const double direction[3],
                              double rgba[4]);

// ---- reference_step.c -----------------------------------------------------------------------------------------------

struct reference_params {
    struct reference_weights weights;
    double *grid;
    double sky[VW_SKY_COLUMNS][3];  // 0 without the effect
    struct reference_photo *photos; // one per view; NULL without such effects
    double code_weights[REFERENCE_WIDTH_MAX * REFERENCE_CODE];
    double visibility[REFERENCE_VISIBILITY];
    double (*visibility_codes)[REFERENCE_VISIBILITY_CODE]; // one per view; NULL without that effect
    double *uncertainty;                                   // the network; NULL without that effect
};

// One step: forward fills samples, colours and losses, backward the gradients. In between a test may put the device's
// ReLU decisions in the place of the reference's (reference_adopt_gates).
struct reference_step {
    const struct vw_model *model;
    uint32_t ray_count;
    struct reference_ray *rays;
    struct reference_sample *samples; // ray by ray
    double *
        sample_places; // per sample: where it is on its ray, in strata; a test may set them [NULL: one in each stratum]
    struct reference_d_sample *d_samples;                        // likewise
    double (*colours)[3], *left;                                 // per ray: rendered, transmittance that remains
    double (*backdrops)[3];                                      // per ray: the sky or the background
    double (*errors)[3], *losses;                                // per ray
    double loss;                                                 // sum over rays
    struct reference_weights d_weights;                          // gradient of the sum over rays
    double *d_grid;                                              // likewise
    double d_sky[VW_SKY_COLUMNS][3];                             // likewise
    uint32_t view;                                               // the view whose photo it is, in training
    double d_code[REFERENCE_CODE];                               // gradient of the sum over rays, by its code
    double d_code_weights[REFERENCE_WIDTH_MAX * REFERENCE_CODE]; // likewise
    double (*places)[2],
        *visible; // per ray: where in its photo, which the caller sets; how visible or certain, 1 outside training
    double (*features)[REFERENCE_FEATURES];      // per ray, which the caller sets with the effect uncertainty
    double size_weight, certain_loss;            // reference_size_weight() and reference_certain_loss() of the step
    double d_uncertainty[REFERENCE_UNCERTAINTY]; // sum over rays
    double d_visibility[REFERENCE_VISIBILITY], d_visibility_code[REFERENCE_VISIBILITY_CODE]; // sums over rays
};

struct reference_params *reference_params_create(const struct vw_model *model,
                                                 const float *params); // the whole params block
struct reference_step *reference_step_create(const struct vw_model *model, const struct vw_ray *rays,
                                             uint32_t ray_count);
// Goes through the field with jittered samples of step `number` in `training`, with the strata's centres otherwise.
void reference_step_forward(struct reference_step *step, const struct reference_params *params, bool training,
                            uint64_t number);
void reference_step_backward(struct reference_step *step, const struct reference_params *params);

// Takes over the device's ReLU decisions (slot RELU, four words per slot). Returns how many differ although the
// reference's value before the ReLU is farther than `tolerance` from 0: rounding does not explain such a difference.
uint64_t reference_adopt_gates(struct reference_step *step, const vw_uint4 *bits, double tolerance);

#endif
