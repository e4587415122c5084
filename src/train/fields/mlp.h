// The field of NeRF (Mildenhall et al., ECCV 2020): positional encodings and one network.
//   position -> trunk of `depth` layers with ReLU; after layer 4, if it is not the last, the encoding joins (skip)
//   trunk -> raw density
//   trunk -> feature (no ReLU)
//   feature and encoded direction -> half as wide with ReLU -> rgb
// A layer is one matrix, or two that add up where it takes in two things. A matrix is stored as 4x4 blocks, row of
// blocks by row of blocks, a block as four vec4 columns (as in shaders/networks/mlp.glsl); after that of a layer's
// first matrix come its biases, a vec4 for each row of blocks. The passes (shaders/field_mlp/multiply_layer.comp) walk
// a list of matrices, forward in its order, back against it. The density is exp(raw), cut, as the hash grid's, in place
// of NeRF's ReLU, which can die from an unlucky initialisation.
#ifndef VIEWWORTH_TRAIN_FIELDS_MLP_H
#define VIEWWORTH_TRAIN_FIELDS_MLP_H

#include <stdbool.h>

#include "train/fields/registry.h"
#include "train/model.h"

enum { MLP_HEAD_DEPTH = 4 }; // layers of the effect transient's head, half as wide, as in NeRF-W
enum { MLP_DEPTH_MAX = 16, MLP_MATRICES_MAX = MLP_DEPTH_MAX + 8 + MLP_HEAD_DEPTH, MLP_NONE = UINT32_MAX };

struct vw_mlp_matrix {
    uint32_t first_weight, first_bias;   // vec4 of the range weights; first_bias: MLP_NONE for a layer's second matrix
    uint32_t in_row, in4, out_row, out4; // rows of VW_SLOT_LAYER_ROWS
    uint32_t in, out;                    // numbers that count, without padding
    uint32_t d_in_row, d_out_row;        // rows of VW_SLOT_D_LAYER_ROWS; d_in_row: MLP_NONE where encodings come in
    uint32_t fan_in;                     // inputs of the whole layer
    bool ends_layer;                     // its last matrix
    bool rectifies;                      // the layer has a ReLU
    bool shifts;                         // a photo's code shifts its biases
    bool adds_to_gradient;               // its input has a gradient already
    bool gates_back;                     // this one completes that gradient, and the input comes from a ReLU
};

struct vw_mlp_list {
    struct vw_mlp_matrix matrices[MLP_MATRICES_MAX];
    uint32_t count;
    uint32_t columns, row_count, d_row_count; // vec4 of weights, where the list ends; rows of a sample
    struct vw_push_heads heads, d_heads;      // raw density and logits, and their gradients
    uint32_t shift_column;                    // first bias that a code shifts
    uint32_t head_depth;                      // layers of the head of the effect transient before its last
};

// The input or output of a layer.
struct vw_mlp_operand {
    uint32_t row, numbers, d_row; // numbers: without padding; d_row: MLP_NONE where no gradient is wanted
};

// Lists the matrices: a function of the model's depth, its width and the frequencies of the specialization.
// `transient`: with the head of that effect after the other matrices, in further rows; its place is written into the
// specialization. `first_column`: the column with which the network begins; 0, or coarse_column for the coarse one.
void vw_mlp_list(const struct vw_model *model, bool transient, uint32_t first_column, struct vw_mlp_list *list);

// ---- Layers, also of the head of the effect transient, which both fields have ---------------------------------------

// Counts the vec4 columns of partial sums that the largest gradient of a matrix takes, and the params without padding.
void vw_mlp_count(const struct vw_mlp_list *list, uint32_t *partial_columns, uint64_t *param_count);
// Draws the initial values of the whole list; `weights`: from column 0 on.
void vw_mlp_initialise(const struct vw_mlp_list *list, const struct vw_drawn *drawn, float *weights);

// The passes of a list among those of a field: gradient_weights and reduce_weights, then multiply_layer for each size
// of tile, first those for the forward pass, then those for the backward pass.
enum { MLP_GRADIENT, MLP_REDUCE, MLP_MULTIPLY };
struct vw_mlp_passes {
    struct vw_pass **passes;
    uint32_t multiply_count; // places for sizes of tiles, forward, and as many back
};
enum vw_status vw_mlp_create_layers(const struct vw_field_pass_params *params,
                                    const struct vw_specialization *specialization, const struct vw_mlp_list *list,
                                    struct vw_mlp_passes places);
// Records all layers of a list forward, for so many samples; or back, through those of a chunk of rays, as many per ray
// as the specialization says.
void vw_mlp_record_layers(const struct vw_mlp_list *list, struct vw_mlp_passes places, struct vw_submission *submission,
                          uint64_t samples);
void vw_mlp_record_layers_back(const struct vw_specialization *specialization, const struct vw_mlp_list *list,
                               struct vw_mlp_passes places, struct vw_submission *submission,
                               const struct vw_push_samples *rays);
// Appends the head of the effect transient: code and outputs take the next rows, then come `depth` layers of `width`
// with ReLU, and one of logits of rgb, raw density, and raw uncertainty.
void vw_mlp_append_head(struct vw_mlp_list *list, struct vw_mlp_operand features, uint32_t depth, uint32_t width);
// Tells passes where it is. The list ends with the head.
void vw_mlp_specialise_head(const struct vw_mlp_list *list, struct vw_specialization *specialization);

#endif
