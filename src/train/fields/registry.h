// The registry of fields: what turns samples of rays into rgb and density, and takes the gradients by these back to
// its params. A field is a row of a table in renderers/volume/volume.c, chosen by --field (vw_config.field). Its file
// lays out its params and records its passes. Rays, compositing, losses, effects, the optimiser of weights, validation,
// the adjoint and all files are the same for every field.
#ifndef VIEWWORTH_TRAIN_FIELDS_REGISTRY_H
#define VIEWWORTH_TRAIN_FIELDS_REGISTRY_H

#include "gpu/compute.h"
#include "interface.h"
#include "train/model.h"
#include "train/passes.h"
#include "viewworth/train.h"

struct vw_radiance_field; // train/field.h
struct vw_field_kind;

enum { VW_GRID_PAIR_BYTES = 8 }; // a feature pair: two floats

// Levels of the grid whose gradient and params fit one storage binding.
struct vw_grid_window {
    uint32_t first_level, level_count;
    uint32_t first_pair, pair_count;
};

// The layout of a field, of a model (vw_model.of_renderer of the renderer `volume`).
struct vw_volume_model {
    const struct vw_field_kind *kind;
    struct vw_param_range grid; // VW_GRID_PAIR_BYTES per feature pair, empty without one
    // The network for the even samples alone (--coarse-network own), empty without it: vec4 columns as the
    // field lays them out, moved as weights are.
    struct vw_param_range coarse;
    uint32_t coarse_columns, coarse_column; // how many, which the field says; which is its first
    uint32_t ray_samples;                   // samples of the kind of which a ray has more: the room of a chunk
    uint32_t pair_count;                    // pairs of all levels, with padding
    uint32_t partial_columns;               // columns whose partial sums are stored at a time
    uint32_t weight_tiles;                  // tiles of 2x2 blocks over the four matrices, see gradient_weights.comp
    uint32_t row_count, row_bytes;          // activation rows of a sample, and the bytes of one
    uint32_t grid_row_count;                // rows of the field hash
    uint32_t head_row_count; // field hash: rows of the effect transient's head, as those of the field mlp
    uint32_t d_row_count;    // rows of layers, of the field mlp or that head
    uint32_t depth, trunk4;  // field mlp: layers of the trunk, their width / 4
    enum vw_scatter_form scatter;
    struct vw_grid_window windows[VW_LEVELS_MAX];
    uint32_t window_count;
};
static inline struct vw_volume_model *vw_volume_of(const struct vw_model *model) { return model->of_renderer; }

enum { FIELD_PASSES_MAX = 32 };

// The passes of a field; which is which is the field's own. Several sets, each with its specialization, may share the
// buffers of a step.
struct vw_field_passes {
    struct vw_specialization specialization;
    uint32_t first_column; // the first column of weights of the network: 0, or vw_volume_model.coarse_column
    struct vw_pass *passes[FIELD_PASSES_MAX];
};

struct vw_field_pass_params {
    struct vw_gpu_objects *objects; // own the passes
    struct vw_pass_params common; // bindings: rays, samples and vw_field_bind(), then those of the step, with backward
    struct vw_buffer *d_grid;     // with backward: of a field with a grid
    bool backward;
};

struct vw_field_kind {
    bool renders_in_rows; // it needs the rows of a training chunk to render, too
    // Lays out the ranges grid and weights of the params, counts them, and says how many rows a sample has, and how
    // many columns a coarse network. The first to be called; the specialization has config and effects.
    void (*lay_out)(struct vw_model *model);
    // Lays out what depends on the device and on the samples of a chunk, which are known by then.
    enum vw_status (*fit)(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model);
    // Initial values of both ranges, and of the range coarse.
    void (*initialise)(const struct vw_model *model, const struct vw_drawn *drawn, void *params);
    // Creates a set whose specialization is set.
    enum vw_status (*create_passes)(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    struct vw_field_passes *passes);
    // Reads VW_SLOT_RAYS and writes VW_SLOT_FIELD.
    void (*record_forward)(const struct vw_model *model, const struct vw_field_passes *passes,
                           struct vw_submission *submission, const struct vw_push_samples *rays);
    // Reads VW_SLOT_D_FIELD and writes VW_SLOT_D_WEIGHTS and VW_SLOT_D_GRID.
    void (*record_backward)(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, const struct vw_push_samples *rays);
};

extern const struct vw_field_kind field_hash, field_mlp;

// ---- The field hash -------------------------------------------------------------------------------------------------

// The parts of the field `hash` that tests and benchmarks use.

// Places of its passes in a set; the last begins those of the grid's windows.
enum { HASH_FORWARD, HASH_BACKWARD, HASH_GRADIENT, HASH_REDUCE, HASH_SCATTER };

// Records the passes that add the encoding gradients of the chunk's `samples` to the grid's gradient.
void vw_hash_record_scatter(const struct vw_model *model, const struct vw_field_passes *passes,
                            struct vw_submission *submission, uint32_t samples);

#endif
