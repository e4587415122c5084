// The model of a run: from config, scene and device limits to the specialization constants, the sizes that follow from
// them, and the layout of the one block that holds all trainable numbers.
#ifndef VIEWWORTH_TRAIN_MODEL_H
#define VIEWWORTH_TRAIN_MODEL_H

#include <stdint.h>

#include "interface.h"
#include "train/device_choices.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

// A range of the params block, in bytes. Offsets suit every binding's alignment.
struct vw_param_range {
    uint64_t offset_bytes, size_bytes;
};

struct vw_effect_kind;   // effects/kind.h
struct vw_renderer_kind; // renderers/registry.h

struct vw_model {
    const struct vw_config *config; // borrowed
    const struct vw_renderer_kind *renderer;
    struct vw_specialization specialization; // with training = 1
    uint64_t seed;                           // key of what passes draw, apart from order and initialisation
    double learning_rate_decay;              // vw_config
    uint64_t planned_steps;                  // steps over which the rate falls
    struct vw_box box;                       // that the field sees: the scene's, or that of an effect (field_box.h)
    bool box_of_effect;                      // the latter
    bool awaits_params;                      // a file will bring them: no exposures are taken from the scene
    struct vw_param_range weights;           // vec4 columns
    const struct vw_effect_kind *const *effect_table;          // all of them, up to a NULL
    const struct vw_effect_kind *effects[VW_EFFECT_COUNT_MAX]; // the ones that are on, in the order of the table
    uint32_t effect_count;
    struct vw_param_range ranges[VW_SLOT_COUNT]; // the effects', by the slot that they are bound at; empty without it
    // With the consistency loss (effects/appearance_encoder.h) the side of the picture that the first rays of a step
    // make, else 0.
    uint32_t picture_side;
    uint32_t renderer_flags;     // flags of its own that the renderer's passes set when an update overflows
    bool obeys_masks;            // thumbnails leave out what mask files hide
    uint32_t view_count;         // views of the scene
    const uint32_t *train_views; // borrowed; scene indices, ascending; NULL: the scene's split train
    uint32_t train_count;
    void *of_renderer;   // owned: what the renderer lays out of its own
    uint32_t patch_side; // validation looks at squares of so many pixels along a side; 1: at single pixels
    uint64_t param_bytes;
    uint64_t param_count;          // trainable numbers, without padding
    uint64_t drawn_before_weights; // numbers, in the draws of the initial values
    uint32_t weight_columns;       // columns of the networks, including the head of the effect transient
    uint32_t moved_columns;        // by update_weights: theirs, those of effects, and coarse ones
    uint32_t followed_columns;     // the first of these, which lasting credit goes back to
    uint32_t ray_group; // rays come in multiples of this, so that their samples, of both kinds, fill whole workgroups
};

// The largest offset alignment that Vulkan allows a device to ask for.
enum { VW_PARAMS_ALIGNMENT_BYTES = 256 };
static inline uint64_t vw_round_up(uint64_t value, uint64_t multiple) {
    return (value + multiple - 1) / multiple * multiple;
}

// Creates the model; destroy it also after a failure. `train_views`: the views that are trained on (scene indices;
// NULL: the scene's split train).
enum vw_status vw_model_create(const struct vw_config *config, const struct vw_scene *scene,
                               const uint32_t *train_views, uint32_t train_count,
                               const struct vw_effect_decision *decisions, const struct vw_device_choices *choices,
                               const struct vw_gpu_limits *limits, struct vw_model *model);

void vw_model_destroy(struct vw_model *model);

// Lays out columns after all so far, which update_weights moves, with so many trainable numbers; returns the first.
uint32_t vw_model_append_columns(struct vw_model *model, uint32_t columns, uint64_t param_count);
bool vw_model_trains_on(const struct vw_model *model, const struct vw_scene *scene, uint32_t view);

// Returns where columns lie.
struct vw_param_range vw_model_columns(const struct vw_model *model, uint32_t first, uint32_t count);
// Lays out a range after all so far, with so many trainable numbers, to be bound at a slot.
void vw_model_append_range(struct vw_model *model, uint32_t slot, uint64_t size_bytes, uint64_t param_count);

// Returns what the update passes are told of the optimiser.
struct vw_adam vw_adam_of(const struct vw_specialization *specialization);
// Returns the learning rate of a step, from 1, as a share of the config's. The steps planned decide it, not those
// taken.
double vw_model_rate_factor_of_step(const struct vw_model *model, uint64_t step);

vw_uint4 vw_model_key_of_step(const struct vw_model *model, uint64_t step);

// Returns `rays` rounded up to whole groups.
uint32_t vw_model_pad_rays(const struct vw_model *model, uint32_t rays);

// ---- Initial values -------------------------------------------------------------------------------------------------

// Initial values of params: random numbers, each keyed by its place in the params block.

// Draws one uniform number in [-scale, scale) per parameter, keyed by its index in the block.
void vw_fill_uniform(float *values, uint64_t count, uint64_t first_index, float scale, uint64_t seed);

struct vw_drawn {
    const float *weights; // the first number of the range weights, which has index
    uint64_t first_index, seed;
};
// Fills `count` numbers in or after the range weights. Returns what follows them.
float *vw_fill_weights(float *values, const struct vw_drawn *drawn, uint64_t count, float scale);
// Fills a matrix of 4x4 blocks within He's bound for layers that follow a ReLU, so that the signal keeps its size.
float *vw_fill_matrix(float *values, const struct vw_drawn *drawn, uint32_t out4, uint32_t in4);
// Returns whether an effect is on, in the model and here, whose buffers are in variants of the passes over rays.
bool vw_model_has_ray_effects(const struct vw_model *model, const struct vw_specialization *specialization);

#endif
