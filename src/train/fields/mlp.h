// The field of NeRF (Mildenhall et al., ECCV 2020): positional encodings and one network.
//   position -> trunk of `depth` layers with ReLU; behind layer 4, if it is not the last, the encoding joins again
//   (skip) trunk -> raw density; trunk -> feature (no ReLU) feature and encoded direction -> half as wide with ReLU ->
//   rgb
// A layer is one matrix, or two that add up where it takes in two things. A matrix is stored as 4x4 blocks, row of
// blocks by row of blocks, a block as four vec4 columns (as in shaders/mlp.glsl); behind that of a layer's first matrix
// stand its biases, a vec4 for each row of blocks. The passes (shaders/multiply_layer.comp) walk a list of matrices,
// forward in its order, back against it.
// The density is exp(raw), cut, as the hash grid's, in place of NeRF's ReLU, which dies of unlucky beginnings.
#ifndef VIEWWORTH_TRAIN_FIELDS_MLP_H
#define VIEWWORTH_TRAIN_FIELDS_MLP_H

#include <stdbool.h>

#include "train/model.h"

enum { MLP_DEPTH_MAX = 16, MLP_MATRICES_MAX = MLP_DEPTH_MAX + 6, MLP_NONE = UINT32_MAX };

struct mlp_matrix {
    uint32_t first_weight, first_bias;   // vec4 of the range weights; first_bias: MLP_NONE for a layer's second matrix
    uint32_t in_row, in4, out_row, out4; // rows of VW_SLOT_LAYER_ROWS
    uint32_t in, out;                    // numbers that count, without padding
    uint32_t d_in_row, d_out_row;        // rows of VW_SLOT_D_LAYER_ROWS; d_in_row: MLP_NONE where encodings come in
    uint32_t fan_in;                     // of the whole layer
    bool ends_layer;                     // its last matrix
    bool rectifies;                      // the layer has a ReLU
    bool shifts;                         // a photo's code shifts its biases
    bool adds_back;                      // what comes in has a gradient already
    bool gates_back;                     // that is complete with this one, and stands behind a ReLU
};

struct mlp_list {
    struct mlp_matrix matrices[MLP_MATRICES_MAX];
    uint32_t count;
    uint32_t columns, row_count, d_row_count; // vec4 of weights; rows of a sample
    struct vw_push_heads heads, d_heads;      // raw density and logits, and their gradients
    uint32_t shift_column;                    // first bias that a code shifts
};

// A function of model->depth, model->trunk4 and the frequencies of the specialization.
void mlp_list(const struct model *model, struct mlp_list *list);

#endif
