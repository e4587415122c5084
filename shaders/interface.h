// Everything host and shaders share, read by the C compiler and by glslang: specialization constants, binding slots, structs, sizes.
// Nothing of it is written a second time but LOSS_*, OPTIMIZER_* and RANDOM_*, which are checked. All buffers use scalar layout.
#ifndef VIEWWORTH_INTERFACE_H
#define VIEWWORTH_INTERFACE_H

#ifdef VULKAN // glslang
#define VW_ENUM(name, value) const uint name = value;
#define VW_NUMBER(name, value) const float name = value;
#define vw_float4 vec4
#define vw_uint4 uvec4
#define vw_uint3 uvec3
#define vw_uint uint
#else
#include <stddef.h>
#include <stdint.h>
#define VW_ENUM(name, value) enum { name = value };
#define VW_NUMBER(name, value) static const double name = value;
typedef struct { float x, y, z, w; } vw_float4;
typedef struct { uint32_t x, y, z, w; } vw_uint4;
typedef struct { uint32_t x, y, z; } vw_uint3;
typedef uint32_t vw_uint;
typedef struct vw_adam vw_adam;
#endif

// ---- Specialization constants: X(id, GLSL name, C field, type, default) ----------------------------------------------
// The bytes of one struct vw_specialization are the same for all shared passes of a run; TRAINING tells the two uses of the field code
// apart. An effect that is off is 0 here and folds away (decision 7).
#define VW_SPECIALIZATION(X) VW_CONSTANTS_OF_FORM(X) VW_CONSTANTS_OF_SUMS(X) VW_LEVEL_CONSTANTS(X) VW_FURTHER_CONSTANTS(X)
#define VW_CONSTANTS_OF_FORM(X) \
    X(0, SAMPLES, samples, uint, 32)             /* per ray */ \
    X(1, LEVELS, levels, uint, 8)                /* of the hash grid */ \
    X(2, FEATURE_PAIRS, feature_pairs, uint, 1)  /* features per entry / 2 */ \
    X(3, DENSE_LEVELS, dense_levels, uint, 0)    /* levels below this are dense lattices, the others hashed */ \
    X(4, TABLE_MASK, table_mask, uint, 16383)    /* entries of a hashed level - 1 */ \
    X(5, WIDTH4, width4, uint, 8)                /* hidden width / 4 */ \
    X(6, TRAINING, training, uint, 0)            /* 1: jittered samples, drawn backgrounds, the photo's code */ \
    X(7, CHUNK_SAMPLES, chunk_samples, uint, 4096) /* samples whose activations are held at a time */ \
    X(8, LOSS, loss, uint, 0)                    /* VW_LOSS_* */ \
    X(9, OPTIMIZER, optimizer, uint, 0)          /* VW_OPTIMIZER_* */ \
    X(10, MOMENTUM, momentum, uint, 0)           /* 1: beta1 > 0, first moments exist */ \
    X(11, WIDE_GRADIENT, wide_gradient, uint, 0) /* 1: one 64-bit word per feature, 0: one per feature pair (decision 3) */ \
    X(12, GRID_TEXEL, grid_texel, uint, 1)       /* 1: the grid is gathered through a texel buffer, 0: storage buffer */ \
    X(13, ROWS_TEXEL, rows_texel, uint, 1)       /* likewise both kinds of activation rows */ \
    X(14, EFFECT_APPEARANCE_CODE, effect_appearance_code, uint, 0) \
    X(15, RAY_LANES, ray_lanes, uint, 1)         /* that share a ray and its samples: 1 to 32, a power of two */ \
    X(16, EFFECT_DISTORTION, effect_distortion, uint, 0) /* DISTORTION_* */ \
    X(17, EFFECT_BACKGROUND, effect_background, uint, 0) /* BACKGROUND_NONE, _FIXED or _RANDOM */ \
    X(18, BACKGROUND_RED, background_red, float, 0.0) \
    X(19, BACKGROUND_GREEN, background_green, float, 0.0) \
    X(20, BACKGROUND_BLUE, background_blue, float, 0.0)
#define VW_CONSTANTS_OF_SUMS(X) \
    X(24, GRADIENT_QUANTUM, gradient_quantum, float, 0.0001) /* loss gradient of one fixed-point unit, of a sum over rays */ \
    X(25, GRADIENT_CLAMP, gradient_clamp, float, 1.0)  /* largest fixed-point contribution of one sample, in the same unit */ \
    X(26, INVERSE_RAYS, inverse_rays, float, 0.002)    /* 1 / rays: turns the sum over rays into the mean */
#define VW_FURTHER_CONSTANTS(X) \
    X(59, EFFECT_SKY, effect_sky, uint, 0) \
    X(60, EFFECT_UNBOUNDED, effect_unbounded, uint, 0) \
    X(61, EFFECT_APPEARANCE, effect_appearance, uint, 0) \
    X(62, SLICE_SAMPLES, slice_samples, uint, 128) /* per partial sum of the weight gradient: VW_FIELD_GROUP or a part of it */ \
    X(63, SKIP_ZEROS, skip_zeros, uint, 0)         /* 1: scatter_grid adds no zeros, in its atomic forms */ \
    X(64, STORES_ROWS, stores_rows, uint, 0)       /* 1: activations are stored for the backward pass */ \
    X(65, HUBER_LENGTH, huber_length, float, 0.1)  /* colour difference beyond which LOSS_HUBER is linear */ \
    X(66, SHIFT_COLUMN, shift_column, uint, 0)     /* weight column that holds the biases of the first four units that a code shifts */ \
    X(67, SHIFT_STRIDE, shift_stride, uint, 0)     /* from there to that of the next four */ \
    X(68, FIELD_COLUMNS, field_columns, uint, 0)   /* weight columns of the field; the sky's follow */ \
    X(69, POSITION_FREQUENCIES, position_frequencies, uint, 10) /* of the field mlp, as all that follow */ \
    X(70, LAYER_ROWS, layer_rows, uint, 1)         /* rows of a sample's activations */ \
    X(71, D_LAYER_ROWS, d_layer_rows, uint, 1)     /* and of their gradients */ \
    X(72, TILE_TO4, tile_to4, uint, 1)             /* rows that an invocation of multiply_layer writes */ \
    X(73, TILE_FROM4, tile_from4, uint, 1)         /* and reads */ \
    X(74, EFFECT_VISIBILITY, effect_visibility, uint, 0) \
    X(75, VISIBILITY_COLUMN, visibility_column, uint, 0) /* weight column with which the network of visibility or uncertainty begins */ \
    X(76, STRATA, strata, uint, 32)                /* of a ray, each with one even sample: SAMPLES without importance samples */ \
    X(77, IMPORTANCE, importance, uint, 0)         /* 1: the SAMPLES are importance samples, whose places are listed */ \
    VW_TRANSIENT_CONSTANTS(X) \
    X(87, EFFECT_POSE, effect_pose, uint, 0) \
    X(88, EFFECT_APPEARANCE_ENCODER, effect_appearance_encoder, uint, 0) \
    X(89, ENCODER_COLUMN, encoder_column, uint, 0) /* weight column with which its network begins */ \
    X(90, SLICE_PARTS, slice_parts, uint, 1)       /* lanes of gradient_weights that share a slice: 1 to 64, a power of two */ \
    X(91, EFFECT_UNCERTAINTY, effect_uncertainty, uint, 0)

// The effect transient, and places of its head: rows of VW_SLOT_LAYER_ROWS and of VW_SLOT_D_LAYER_ROWS, columns of weights.
#define VW_TRANSIENT_CONSTANTS(X) \
    X(78, EFFECT_TRANSIENT, effect_transient, uint, 0) \
    X(79, BETA_MIN, beta_min, float, 0.1)                  /* least uncertainty of a ray, a standard deviation of colours */ \
    X(80, TRANSIENT_ROW, transient_row, uint, 0)           /* of logits and raw density; raw uncertainty in the next row */ \
    X(81, D_TRANSIENT_ROW, d_transient_row, uint, 0)       /* of the gradients by both */ \
    X(82, D_FEATURE_ROW, d_feature_row, uint, 0)           /* of those by the features of the field hash */ \
    X(83, TRANSIENT_CODE_ROW, transient_code_row, uint, 0) /* of the photo's code */ \
    X(84, TRANSIENT_COLUMN, transient_column, uint, 0)     /* of the matrix that the code is multiplied by */ \
    X(85, TRANSIENT_BIAS, transient_bias, uint, 0)         /* of the same layer's biases */ \
    X(86, TRANSIENT_WIDTH4, transient_width4, uint, 1)     /* its units / 4 */

VW_ENUM(VW_LEVELS_MAX, 16)
// Per level: cells per axis, and the index of its first feature pair in the grid.
#define VW_LEVEL(X, i) X(27 + i, RESOLUTION_##i, resolution[i], uint, 8) X(43 + i, FIRST_PAIR_##i, first_pair[i], uint, 0)
#define VW_LEVEL_CONSTANTS(X) \
    VW_LEVEL(X, 0) VW_LEVEL(X, 1) VW_LEVEL(X, 2) VW_LEVEL(X, 3) VW_LEVEL(X, 4) VW_LEVEL(X, 5) VW_LEVEL(X, 6) VW_LEVEL(X, 7) \
    VW_LEVEL(X, 8) VW_LEVEL(X, 9) VW_LEVEL(X, 10) VW_LEVEL(X, 11) VW_LEVEL(X, 12) VW_LEVEL(X, 13) VW_LEVEL(X, 14) VW_LEVEL(X, 15)

#ifdef VULKAN
#define VW_DECLARE_CONSTANT(id, upper, lower, type, value) layout(constant_id = id) const type upper = value;
VW_SPECIALIZATION(VW_DECLARE_CONSTANT)
#else
#define uint uint32_t
#define VW_CONSTANT_MEMBER(id, upper, lower, type, value) type lower;
struct vw_specialization {
    VW_CONSTANTS_OF_FORM(VW_CONSTANT_MEMBER)
    float learning_rate, beta1, beta2; // no constants: passes take them as vw_adam
    VW_CONSTANTS_OF_SUMS(VW_CONSTANT_MEMBER)
    uint resolution[VW_LEVELS_MAX], first_pair[VW_LEVELS_MAX];
    VW_FURTHER_CONSTANTS(VW_CONSTANT_MEMBER)
};
// Word i of the struct is constant i, if there is one.
#define VW_CHECK_CONSTANT(id, upper, lower, type, value) \
    _Static_assert(offsetof(struct vw_specialization, lower) == 4 * (id), "specialization constant " #upper " is out of place");
VW_SPECIALIZATION(VW_CHECK_CONSTANT)
#undef VW_CHECK_CONSTANT
#undef uint
enum { VW_SPECIALIZATION_COUNT = sizeof(struct vw_specialization) / 4 };
#endif

// Values of LOSS and OPTIMIZER; train.h has the same order (asserted in src/train/model.c).
VW_ENUM(LOSS_L1, 0)
VW_ENUM(LOSS_L2, 1)
VW_ENUM(LOSS_HUBER, 2)
VW_ENUM(LOSS_GIVEN, 3) // the target contains the slope; only the adjoint uses it
VW_ENUM(OPTIMIZER_LAZY_ADAM, 0)
VW_ENUM(OPTIMIZER_DENSE_ADAM, 1)
VW_ENUM(OPTIMIZER_SGD, 2)

// Values of EFFECT_DISTORTION: the cheapest that undoes every lens of the scene.
VW_ENUM(DISTORTION_NONE, 0)
VW_ENUM(DISTORTION_BASIC, 1)    // polynomial lenses with k1, k2, p1, p2 alone
VW_ENUM(DISTORTION_ANY_LENS, 2) // further coefficients or fisheyes, told apart by camera

// Values of EFFECT_BACKGROUND. Validation and rendering take the fixed colour in either form (decision 1).
VW_ENUM(BACKGROUND_NONE, 0)
VW_ENUM(BACKGROUND_FIXED, 1)
VW_ENUM(BACKGROUND_RANDOM, 2)
// EFFECT_APPEARANCE
VW_ENUM(APPEARANCE_GIVEN, 1)  // by the points of structure from motion: nothing moves it
VW_ENUM(APPEARANCE_FITTED, 2) // by fit_photo at every visit

// The ridge of fits of a gain and a bias, in squared errors: as if one ray were off by 0.3 for a gain or bias of 1. In fit_views ten times
// as much cost 0.15 dB, a tenth gave none.
VW_NUMBER(FIT_RIDGE, 0.1)
// All codes of photos could drift, where the code 0 of rendering is unknown: a ridge pulls them to 0. Gradient of the mean loss per unit.
VW_NUMBER(PHOTO_RIDGE, 0.01)

// Purposes of random numbers on the GPU; random.h has the same values (asserted in src/train/model.c).
VW_ENUM(RANDOM_PIXEL, 2)
VW_ENUM(RANDOM_JITTER, 3)
VW_ENUM(RANDOM_BACKGROUND, 6)
VW_ENUM(RANDOM_IMPORTANCE, 9)

// ---- Binding slots (descriptor set 0) --------------------------------------------------------------------------------
VW_ENUM(VW_SLOT_CAMERAS, 0)          // vw_gpu_camera per view
VW_ENUM(VW_SLOT_PIXELS, 1)           // vw_pixel per ray, written by the host or by draw_pixels
VW_ENUM(VW_SLOT_RAYS, 2)             // vw_ray per ray
VW_ENUM(VW_SLOT_GRID, 3)             // vec2 per feature pair: a range of the params
VW_ENUM(VW_SLOT_GRID_TEXEL, 4)       // the same as RG32F texels
VW_ENUM(VW_SLOT_WEIGHTS, 5)          // vec4 columns of 4x4 blocks (mlp.glsl, src/train/fields/mlp.h), then those of effects
VW_ENUM(VW_SLOT_FIELD, 6)            // vec4 per sample: rgb and density (per box edge length)
VW_ENUM(VW_SLOT_D_FIELD, 7)          // vec4 per sample: d_rgb and d_raw density; overwritten
VW_ENUM(VW_SLOT_ROWS, 8)             // activation rows of one chunk, what the networks leave: four bfloats (bfloat.glsl) at VW_ROW_PLACE
VW_ENUM(VW_SLOT_ROWS_TEXEL, 9)       // the same as RG32UI texels
VW_ENUM(VW_SLOT_GRID_ROWS, 10)       // vec4 rows of one chunk, what scatter_grid reads, at VW_ROW_PLACE
VW_ENUM(VW_SLOT_COLOURS, 11)         // vec4 per ray: rendered rgb and remaining transmittance
VW_ENUM(VW_SLOT_RAY_LOSS, 12)        // float per ray
VW_ENUM(VW_SLOT_WEIGHT_PARTIALS, 13) // vec4 [slice of SLICE_SAMPLES samples of a chunk][weight]; overwritten
VW_ENUM(VW_SLOT_D_WEIGHTS, 14)       // vec4 per weight column, the first chunk overwrites, the others accumulate; then the sky's
VW_ENUM(VW_SLOT_D_GRID, 15)          // 64-bit fixed-point words; accumulated, cleared by update_grid
VW_ENUM(VW_SLOT_GRID_MOMENT1, 16)    // vec2 per pair, only with momentum
VW_ENUM(VW_SLOT_GRID_MOMENT2, 17)    // vec2 per pair
VW_ENUM(VW_SLOT_GRID_VISITS, 18)     // uint per pair: its own step count
VW_ENUM(VW_SLOT_WEIGHT_MOMENTS, 19)  // vec4 moment1 then vec4 moment2 per column of weights and sky
VW_ENUM(VW_SLOT_STEP_STATE, 20)      // vw_step_state of the step under way
VW_ENUM(VW_SLOT_VAL_VIEWS, 21)       // vw_ray_range per validation view
VW_ENUM(VW_SLOT_SCALARS, 22)         // vec4 [step in submission][1 + validation views], for the host: see reduce_loss, reduce_views
VW_ENUM(VW_SLOT_RECIPE_SHAPES, 23)   // vw_recipe_shape: trace_recipe
VW_ENUM(VW_SLOT_RECIPE_PIXELS, 24)   // vw_recipe_pixel per pixel: trace_recipe
VW_ENUM(VW_SLOT_SKY, 25)            // vec4 [VW_SKY_COLUMNS]: rgb coefficients, a range of the params; a stub without the effect
VW_ENUM(VW_SLOT_D_SKY, 26)          // vec4 per ray: gradient by the sky's logit; likewise
VW_ENUM(VW_SLOT_APPEARANCE, 27)      // vw_appearance per view: a range of the params
VW_ENUM(VW_SLOT_RENDERED, 28)        // vec4 per ray: rgb rendered, w its weight; only with APPEARANCE_FITTED, as the next
VW_ENUM(VW_SLOT_PHOTO_SUMS, 29)      // vw_photo_sums per view
VW_ENUM(VW_SLOT_FITS, 30)            // vw_appearance per validation view; overwritten by fit_views
VW_ENUM(VW_SLOT_CODE_WEIGHTS, 31)    // vec4 [hidden unit][CODE4]: a range of the params
VW_ENUM(VW_SLOT_CODES, 32)           // vec4 [view][CODE4]: a range of the params
VW_ENUM(VW_SLOT_CODE_SHIFT, 33)      // float per hidden unit: code weights times the code of the step's photo
VW_ENUM(VW_SLOT_CODE_WEIGHT_MOMENTS, 34) // vec4 moment1 then vec4 moment2 per vec4 of the code weights
VW_ENUM(VW_SLOT_CODE_MOMENTS, 35)    // vw_code_moments per view
VW_ENUM(VW_SLOT_PLACES, 36)         // float per sample of a chunk: its place, only with importance samples
VW_ENUM(VW_SLOT_GRID_ROWS_TEXEL, 37) // VW_SLOT_GRID_ROWS as RGBA32F texels
VW_ENUM(VW_SLOT_OVERFLOW, 38)     // uint, not 0 where a param would not be finite; one per pass, VW_OVERFLOW_STRIDE apart
// The rest only in the adjoint (src/train/adjoint/). A block has a float for every param, laid out as the params are.
VW_ENUM(VW_SLOT_GATHERED, 39)        // a range of a block: what gather_* writes or adds to
VW_ENUM(VW_SLOT_PARAMS, 40)          // the params as one block
VW_ENUM(VW_SLOT_PARAMS_BEFORE, 41)   // block: the params before a step
VW_ENUM(VW_SLOT_PARAMS_AFTER, 42)    // block: and after it
VW_ENUM(VW_SLOT_STEP_GRADIENT, 43)   // block: gradient of the step's mean loss
VW_ENUM(VW_SLOT_STEP_MOMENT, 44)     // block: first moment after the step, only with momentum
VW_ENUM(VW_SLOT_ADJOINT, 45)         // block: lambda
VW_ENUM(VW_SLOT_ADJOINT_MOMENT, 46)  // block: the adjoint of the first moments, only with momentum
VW_ENUM(VW_SLOT_DIRECTION, 47)       // block: along which colours are differentiated; overwritten
VW_ENUM(VW_SLOT_ADJOINT_SUMS, 48)      // vec4 pairs: partial sums of direct_adjoint or multiply_blocks
VW_ENUM(VW_SLOT_ADJOINT_STATE, 49)     // vw_adjoint_state
VW_ENUM(VW_SLOT_SEEN_AHEAD, 50)      // vec4 per ray: colours seen ahead along the direction, or of the picture of the consistency loss
VW_ENUM(VW_SLOT_GATHERED_CODES, 51)  // gather_code's second range, of the codes
VW_ENUM(VW_SLOT_FIT_VIEWS, 52)       // vw_ray_range per validation view: its rays that it is fitted on
// The next four only with the field mlp or the effect transient: rows of one chunk at VW_ROW_PLACE, four floats each.
VW_ENUM(VW_SLOT_LAYER_ROWS, 53)         // inputs and outputs of layers
VW_ENUM(VW_SLOT_LAYER_ROWS_TEXEL, 54)   // the same as RGBA32F texels
VW_ENUM(VW_SLOT_D_LAYER_ROWS, 55)       // gradients by it, of the layers that the backward pass is at
VW_ENUM(VW_SLOT_D_LAYER_ROWS_TEXEL, 56) // likewise
// The rest only with the effect visibility, see visibility.glsl; the first and the last also with uncertainty.
VW_ENUM(VW_SLOT_VISIBILITY, 57)          // vec2 per ray: how visible or certain it is, and the gradient by that; overwritten
VW_ENUM(VW_SLOT_PHOTO_SCALES, 58)        // vec2 per view: 2 / width and 2 / height in px
VW_ENUM(VW_SLOT_VISIBILITY_CODES, 59)    // vec4 [view][VISIBILITY_CODE4]: a range of the params
VW_ENUM(VW_SLOT_VISIBILITY_MOMENTS, 60)  // vw_visibility_moments per view
VW_ENUM(VW_SLOT_VISIBILITY_PARTIALS, 61) // vec4 [VISIBILITY_GROUP rays][columns of the network]: shares of its gradient; overwritten
// The rest only with the effect transient.
VW_ENUM(VW_SLOT_TRANSIENT_CODES, 62)        // vec4 [view][TRANSIENT_CODE4]: a range of the params
VW_ENUM(VW_SLOT_TRANSIENT_CODE_MOMENTS, 63) // vw_transient_moments per view
// The rest only with the effect pose, see pose.glsl.
VW_ENUM(VW_SLOT_POSES, 64)        // vw_pose per view: a range of the params
VW_ENUM(VW_SLOT_POSE_MOMENTS, 65) // vw_pose_moments per view
VW_ENUM(VW_SLOT_D_POSITIONS, 66)  // vec4 per sample of a chunk: gradient by its position, of the sum over rays; overwritten
VW_ENUM(VW_SLOT_D_POSES, 67)      // vw_pose per ray: its force and its torque; overwritten
// The rest only with the effect appearance_encoder, see encoder.glsl.
VW_ENUM(VW_SLOT_THUMBNAILS, 68)     // vec4 [view][THUMBNAIL_PIXELS]: what the encoder sees of photos; or of a picture alone
VW_ENUM(VW_SLOT_ENCODER_ROWS, 69)   // vec4 [ENCODER_ROWS]: activations of the photo that was encoded last; overwritten
VW_ENUM(VW_SLOT_D_ENCODER_ROWS, 70) // vec4 [ENCODER_ROW_MEAN]: gradients by the sums in its convolutions; overwritten
// And of the consistency loss:
VW_ENUM(VW_SLOT_GIVEN_ROWS, 71)     // as VW_SLOT_ENCODER_ROWS: of the photo whose code rays are rendered with
VW_ENUM(VW_SLOT_OWN_D_WEIGHTS, 72)  // as VW_SLOT_D_WEIGHTS: of this loss alone
// The rest only with splats (src/train/renderers/splats/). A sighting is a splat as one view of the list shows it.
VW_ENUM(VW_SLOT_SPLATS, 73)          // vec4 [column][stride]: the params, see below
VW_ENUM(VW_SLOT_SPLAT_VIEWS, 74)     // vw_splat_view
VW_ENUM(VW_SLOT_SPLAT_TILES, 75)     // vw_splat_tile
VW_ENUM(VW_SLOT_TILE_MAP, 76)        // uint per cell: its tile, where that tile names the cell; else it means nothing
VW_ENUM(VW_SLOT_SPLAT_SHAPES, 77)    // vw_splat_shape per sighting; overwritten
VW_ENUM(VW_SLOT_SIGHTING_PAIRS, 78)  // uint per sighting: its tiles, after place_pairs its first pair; pairs; sightings with pairs
VW_ENUM(VW_SLOT_SPLATS_SEEN, 79)     // vw_splat_seen per rank
VW_ENUM(VW_SLOT_SPLATS_DRAWN, 80)    // vec4 [rank][VW_SPLAT_DRAWN4]: x, y, conic xx, xy | conic yy, opacity, red, green | blue
VW_ENUM(VW_SLOT_SPLAT_STATE, 81)     // vw_splat_state
VW_ENUM(VW_SLOT_PAIR_SPLATS, 82)     // uint per pair: rank of its splat
VW_ENUM(VW_SLOT_SORT_FROM, 83)       // uvec2 per pair: key and pair
VW_ENUM(VW_SLOT_SORT_TO, 84)         // the same, by one more digit in order
VW_ENUM(VW_SLOT_SORT_COUNTS, 85)     // uint [digit][block of SORT_LANES * SORT_KEYS pairs]
VW_ENUM(VW_SLOT_TILE_RANGES, 86)     // vw_tile_range per tile
VW_ENUM(VW_SLOT_D_COLOURS, 87)       // vec4 per ray: gradient by rgb and by what is left, of the sum over rays
VW_ENUM(VW_SLOT_D_PAIRS, 88)         // vec4 [pair][VW_SPLAT_PAIR4]: moments and colour, see blending.glsl; overwritten
VW_ENUM(VW_SLOT_D_SPLATS, 89)        // vec4 [column][stride]: by rank; w of the column of scales is 1 where a pixel shows it
VW_ENUM(VW_SLOT_SPLAT_MOMENT1, 90)   // vec4 [column][stride], only with momentum
VW_ENUM(VW_SLOT_SPLAT_MOMENT2, 91)   // vec4 [column][stride]; w of scales and of harmonics: their own step counts
VW_ENUM(VW_SLOT_BLENDED, 92)         // VW_SLOT_COLOURS of a drawing, where show_pixels copies from
VW_ENUM(VW_SLOT_SHOWN, 93)           // uvec2 per pixel that is looked at: its place among these, and its ray of the drawing
VW_ENUM(VW_SLOT_D_WINDOWS, 94)      // vec4 per ray: gradient by its seen rgb, of the sum over rays, and loss of its window
VW_ENUM(VW_SLOT_FEATURES, 95)       // vec4 [as VW_SLOT_PIXELS][FEATURE4], written by the host; only with the effect uncertainty
VW_ENUM(VW_SLOT_PHOTOS, 96)         // uint: photos as the host has them, see src/train/device_photos.h
VW_ENUM(VW_SLOT_COUNT, 97)

// ---- Structs ---------------------------------------------------------------------------------------------------------
// Rays are made in box coordinates. So that a camera far from the box loses no bits, a ray starts on the plane through
// `reference` = position + reference_depth * forward, near the box, computed in double on the host: its origin is
// reference + reference_depth * R (x, y, 0), and the camera itself lies at ray parameter -reference_depth * |(x, y, -1)|. What is `d`
// deeper than that plane lies at ray parameter d * |(x, y, -1)|.
struct vw_gpu_camera {
    vw_float4 right;     // R's first column in box axes (camera x); w: focal_x_px
    vw_float4 up;        // R's second column (camera y); w: focal_y_px
    vw_float4 back;      // R's third column (camera z, looking along -z); w: centre_x_px
    vw_float4 reference; // box coordinates; w: reference_depth in box edges
    vw_float4 distortion; // k1, k2, p1, p2
    vw_float4 higher;    // k3, k4, k5, k6
    vw_float4 more;      // x: centre_y_px; y, z: rays are sampled between these depths beyond the reference plane, in box edges,
                         // everywhere when both are 0; w: 1 for a fisheye.
                         // With the effect unbounded y and z are depths from the camera itself, 0 < y <= z
};

struct vw_pixel {
    float x_px, y_px;    // position in the photo; centres at +0.5
    vw_uint view;        // index of its camera
    float weight;        // 0: padding or an excluded pixel, else 1
    vw_float4 rgba;      // target, straight alpha, [0,1]
};

// With the effect unbounded the two lengths of a ray are distances from the camera, between which its strata lie (sampling.glsl), and the
// ray's origin is the point at the near one: so a camera far from the box loses no bits here either.
struct vw_ray {
    vw_float4 origin_near;      // box coordinates; w: ray parameter of the first stratum's near edge, in box edges
    vw_float4 direction_stride; // unit vector; w: length of one stratum, 0 when the ray misses the box
    vw_float4 target_weight;    // rgb composited on the background; w: weight
};

struct vw_step_state {
    vw_uint nonfinite;   // not 0: the step must be skipped; reduce_loss sets it to 0, and `clamped`
    vw_uint clamped;     // gradient contributions clamped
    vw_uint view;        // the photo of the step, for the effects that have params of its own
    vw_uint skipped;     // not 0: the step that reduce_loss reported last was skipped, or what was cleared since not finite
};

// A photo's gain and bias: it shows colours as (1 + gain) * colour + bias, per channel. All 0: no change. w is unused.
struct vw_appearance {
    vw_float4 gain, bias;
};

// Sums over the rays of a photo's visits, older ones faded: of rendered colours L, L L, missing colours d (the photo's less L) and
// L d. w of `rendered`: of the rays.
struct vw_photo_sums {
    vw_float4 rendered, squares, missing, products;
    vw_float4 gain, bias; // the last fit, before it is centred; gain.w: visits
};

VW_ENUM(CODE4, 12) // numbers of a photo's code / 4: 48, as in NeRF-W (Martin-Brualla et al., CVPR 2021)

struct vw_code_moments { // likewise
    vw_float4 moment1[CODE4], moment2[CODE4];
    vw_uint visits;
};

// The network of visibility, in vec4 columns after all others that update_weights moves: 4x4 blocks of the first layer, as in mlp.glsl,
// those of the second, its biases, the weights of the logit, and its bias.
VW_ENUM(VISIBILITY4, 4)            // width of both hidden layers / 4
VW_ENUM(VISIBILITY_FREQUENCIES, 5) // frequencies of the encoding of a pixel's place
VW_ENUM(VISIBILITY_PLACE4, 6)      // inputs / 4: the place and a constant 1, then the waves of each frequency,
VW_ENUM(VISIBILITY_CODE4, 4)       // and the photo's code
VW_ENUM(VISIBILITY_INPUT4, 10)     // inputs / 4 in all
VW_ENUM(VISIBILITY_LAYER2, 160)    // first column of the second layer
VW_ENUM(VISIBILITY_BIAS2, 224)     // first column of the biases of the second layer
VW_ENUM(VISIBILITY_LOGIT, 228)     // first column of the logit
VW_ENUM(VISIBILITY_COLUMNS, 233)
// The network of uncertainty likewise, whose inputs are a pixel's features and a constant 1.
VW_ENUM(FEATURE4, 8)
VW_ENUM(UNCERTAINTY_LAYER2, 128)
VW_ENUM(UNCERTAINTY_BIAS2, 192)
VW_ENUM(UNCERTAINTY_LOGIT, 196)
VW_ENUM(UNCERTAINTY_COLUMNS, 201)
VW_ENUM(VISIBILITY_GROUP, 32)      // rays whose gradients one workgroup sums, of either: as many as fit 16 KiB of shared memory

struct vw_visibility_moments { // as vw_code_moments
    vw_float4 moment1[VISIBILITY_CODE4], moment2[VISIBILITY_CODE4];
    vw_uint visits;
};

VW_ENUM(TRANSIENT_CODE4, 4) // numbers of its code for what it alone shows / 4: 16, as in NeRF-W

struct vw_transient_moments { // likewise
    vw_float4 moment1[TRANSIENT_CODE4], moment2[TRANSIENT_CODE4];
    vw_uint visits;
};

// The correction of a photo's camera: its shift in box edges, and its turn, see pose.glsl. All 0: no change. w is unused.
struct vw_pose {
    vw_float4 shift, turn;
};

struct vw_pose_moments { // likewise
    vw_float4 shift1, shift2, turn1, turn2;
    vw_uint visits;
};

// The network of appearance_encoder, in vec4 columns after all others that update_weights moves: its convolutions, each as blocks of 4x4
// weights [place in the kernel][out / 4][in / 4], as in mlp.glsl, then its biases; the matrix from the mean to the code and its biases; the
// matrix from the code to the shift of the colour network, without biases. Rows: outputs of each convolution [pixel][out / 4], mean, code.
VW_ENUM(THUMBNAIL_SIDE, 32)      // pixels of a thumbnail per axis
VW_ENUM(THUMBNAIL_PIXELS, 1024)
VW_ENUM(ENCODER_LAYERS, 3)       // convolutions, each of which halves the side
VW_ENUM(ENCODER4, 4)             // channels of each / 4
VW_ENUM(ENCODER_TAPS, 9)         // places in a kernel
VW_ENUM(ENCODER_LAYER2, 148)     // first columns of the others
VW_ENUM(ENCODER_LAYER3, 728)
VW_ENUM(ENCODER_CODE, 1308)
VW_ENUM(ENCODER_CODE_BIAS, 1500)
VW_ENUM(ENCODER_SHIFT, 1512)
#define VW_ENCODER_COLUMNS(width4) (ENCODER_SHIFT + 4u * CODE4 * (width4))
VW_ENUM(ENCODER_ROW_LAYER2, 1024) // first rows of the others
VW_ENUM(ENCODER_ROW_LAYER3, 1280)
VW_ENUM(ENCODER_ROW_MEAN, 1344)
VW_ENUM(ENCODER_ROW_CODE, 1348)
VW_ENUM(ENCODER_ROWS, 1360)

struct vw_adjoint_state {
    float epsilon;   // half the distance of the two states between which colours are differentiated, in directions
    float unscale;   // divisor of gradients, which makes them fit the fixed-point range
};

struct vw_ray_range {
    vw_uint first, count;
};

// Numbers of the optimiser, a part of push blocks, so that another learning rate compiles nothing.
struct vw_adam { float learning_rate, beta1, beta2, log2_beta1, log2_beta2; };

#include "recipe/recipe_interface.h"
#include "splats/splat_interface.h"

// ---- Push blocks -----------------------------------------------------------------------------------------------------
// `key` is what random numbers are keyed by: seed and step, low word first. No constant, so that trainings with other seeds share
// their pipelines.
struct vw_push_draw {        // draw_pixels; side: vw_pixel_draw.picture_side, or that of tiles; first_mask_word 0: none
    vw_uint4 key;
    vw_uint first_pixel, count, listed, view, width_px, height_px; // pixels beyond those listed weigh nothing
    vw_uint first_word, pixel_words, first_mask_word, mask_bit, side, draw, first_tile;
};
struct vw_push_rays {        // generate_rays, predict_visibility, gradient_visibility
    vw_uint first_pixel;     // where this step's pixels start in the pixel buffer
    vw_uint ray_count;       // rays to make; the padding repeats the last with weight 0
    vw_uint4 key;            // in training
};
struct vw_push_samples {     // place_samples, forward_field, composite_rays, backward_rays, backward_transient, gradient_weights,
                             // reduce_weights, gradient_pose
    vw_uint first_ray;       // the chunk's first ray
    vw_uint ray_count;       // the chunk's rays, a whole number of workgroups of samples
    vw_uint4 key;            // in training
};
// One matrix of the field mlp (src/train/fields/mlp.h): rows of 4x4 blocks, then a vec4 of biases per row of blocks if it has any.
struct vw_push_multiply {    // multiply_layer: to += matrix * from
    vw_uint first_weight;    // first weight of the block that the first rows multiply
    vw_uint to_stride, from_stride; // blocks from one that belongs to a row to that of the next row
    vw_uint from_row, to_row, to4; // first row read; first row written and how many there are
    vw_uint first_bias;      // first bias of the rows written
    vw_uint gate_row;        // back: the activations that gate the rows written
    vw_uint form;            // VW_MULTIPLY_*
};
struct vw_push_matrix {      // gradient_weights and reduce_weights in their layer form
    vw_uint first_weight;
    vw_uint in_row, out_row, in4, out4; // out_row: of gradients
    vw_uint biases;          // 1: it has biases
    vw_uint samples;         // samples of the chunk
    vw_uint first_ray;       // the chunk's first ray: 0 begins the step's sums
};
struct vw_push_heads {       // activate_samples: the rows of raw density and of the logits of rgb, back of their gradients
    vw_uint density_row, logit_row;
};
struct vw_push_scatter {     // scatter_grid
    vw_uint sample_count;    // samples of the chunk
    vw_uint first_level, level_count; // levels of the window of the grid's gradient that is bound
    vw_uint first_pair;      // where that window begins
};
struct vw_push_reduce {      // reduce_loss, reduce_views, fit_views, gradient_sky, reduce_visibility
    vw_uint count;           // rays; views; groups of rays
    vw_uint scalar_row;      // first vec4 of this step in the scalars; fit_views, gradient_sky and reduce_visibility have none.
                             // VW_NO_ROW: reduce_loss only clears the flags
};
struct vw_push_update {      // update_grid, update_weights, fit_photo, update_code, update_visibility, update_transient, update_pose
    vw_uint count;           // pairs of the window; columns of weights and sky; rays; unused
    vw_uint step_low;        // the step's number, from 1; saturated
    float extra;             // share by which the step is longer than at the learning rate, for its decay and for the gate of
                             // lasting credit
    vw_adam adam;
};
struct vw_push_gather {      // gather_grid, gather_weights, gather_code
    vw_uint count;           // pairs of the window; columns of weights and sky; rays; unused
    vw_uint adds;            // 1: add the gradient, unscaled, and clear it; 0: write it, as the step that follows takes it
};
struct vw_push_block {       // direct_adjoint, perturb_params
    vw_uint count;           // vec4 of a block
    float sign;              // perturb_params: to which side
    float beta1;             // direct_adjoint: Adam's
};
struct vw_push_product {     // multiply_blocks
    vw_uint count;           // vec4 of a block
    vw_uint by_gradient;     // 1: the adjoint times the step's gradient, 0: times what the step moved
};
struct vw_push_difference {  // difference_rays
    vw_uint first_ray, ray_count; // as of vw_push_samples
    vw_uint4 key;
    vw_uint ahead;           // 1: colours ahead along the direction, 0: behind, and their difference
};
struct vw_push_slopes {      // normalise_slopes, slope_views
    vw_uint count;           // rays; views
    vw_uint scalar_row;      // slope_views: of the measurement
    vw_uint measure;         // slope_views: 0 PSNR, 1 minus L1
    vw_uint only_view;       // slope_views: index of the view that counts alone; VW_ALL_VIEWS: all of them count
    float unscale;           // normalise_slopes: what the slopes are to be multiplied by beside
};

struct vw_push_photo {       // convolve_photo
    vw_uint layer;           // from 0
    vw_uint view;            // outside of training, where it is the step's
};

struct vw_push_picture {     // shrink_colours, spread_colours
    vw_uint side;            // side of the square picture that the first side^2 rays make, row by row from the top
};
struct vw_push_codes {       // spread_photo in its codes form
    float slope;             // slope of the sum over rays by one number of a code
};

VW_ENUM(VW_MULTIPLY_ADDS, 1)  // to what the rows hold; else to the biases, and back to 0
VW_ENUM(VW_MULTIPLY_GATES, 2) // and then takes the ReLU, or back lets pass where it was above 0
VW_ENUM(VW_MULTIPLY_SHIFTS, 4) // to the biases as the photo's code shifts them

// ---- Sizes -----------------------------------------------------------------------------------------------------------
VW_ENUM(VW_FIELD_GROUP, 256)     // workgroup of the passes that hold the weights in shared memory: pads samples
VW_ENUM(VW_WALK_GROUP, 4)        // workgroup of the scatter_grid that walks levels: so few that two cores share the usual 8 levels
VW_ENUM(VW_DIRECTION_FREQUENCIES, 4) // frequencies of the encoding of a direction by the field mlp
VW_ENUM(GEO4, 4)                 // density MLP outputs / 4: raw density and 15 features
VW_ENUM(COLOUR4, 6)              // colour MLP inputs / 4: SH band 0, 15 features, SH bands 1 and 2
VW_ENUM(VW_SKY_COLUMNS, 9)       // coefficients of spherical harmonics of bands 0 to 2
VW_ENUM(VW_ALL_VIEWS, 0x7fffffff) // in place of a view's index
VW_ENUM(VW_NO_ROW, 0x7fffffff)    // in place of a row of the scalars
VW_ENUM(VW_ADJOINT_GROUPS, 128)    // workgroups of direct_adjoint and multiply_blocks, whose partial sums reduce_adjoint adds
VW_ENUM(VW_OVERFLOW_STRIDE, 64)  // words, so that each has a binding of its own: 256 bytes fit every device's alignment

// The place of a sample's part of a row among the activation rows: workgroup by workgroup of VW_FIELD_GROUP samples, so that a workgroup
// writes one piece of memory. Its rows lie a little more than a power of two apart, since otherwise a sample's values in all rows would
// compete for the same few lines of a cache. VW_ROWS_SIZE is the number of parts in whole workgroups of samples.
VW_ENUM(VW_ROW_STRIDE, 260)
VW_ENUM(VW_ROW_BYTES, 8)         // size of a part: four bfloats
VW_ENUM(VW_GRID_ROW_BYTES, 16)   // four floats
VW_ENUM(VW_LAYER_ROW_BYTES, 16)  // likewise
#define VW_ROW_PLACE(row_count, row, slot) \
    (((slot) / VW_FIELD_GROUP * (row_count) + (row)) * VW_ROW_STRIDE + (slot) % VW_FIELD_GROUP)
#define VW_ROWS_SIZE(row_count, samples) ((samples) / VW_FIELD_GROUP * (row_count) * VW_ROW_STRIDE)

// Rows of four numbers that hold three numbers and the sines and cosines of each at so many frequencies.
#define VW_ENCODED4(frequencies) ((6u * (frequencies) + 6u) / 4u)

// Sizes of an encoding of 4 * encoding4 numbers with hidden layers of 4 * width4: the 4x4 blocks of the four weight matrices (mlp.glsl),
// the tiles of 2x2 blocks that gradient_weights walks, and the rows of a chunk (mlp.glsl).
#define VW_WEIGHT_BLOCKS(encoding4, width4) ((width4) * ((encoding4) + GEO4 + COLOUR4 + 1u))
#define VW_TILES(out4, in4) (((out4) + 1u) / 2u * (((in4) + 1u) / 2u))
#define VW_WEIGHT_TILES(encoding4, width4) \
    (VW_TILES(width4, encoding4) + VW_TILES(GEO4, width4) + VW_TILES(width4, COLOUR4) + VW_TILES(1u, width4))
#define VW_ROW_COUNT(encoding4, width4) ((encoding4) + 4u * (width4) + COLOUR4 + GEO4 + 3u)
#define VW_GRID_ROW_COUNT(encoding4) ((encoding4) + 1u)

#endif
