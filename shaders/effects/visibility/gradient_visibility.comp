// The backward pass through the network of visibility or, in the variant VW_UNCERTAINTY, of uncertainty: each
// invocation takes one ray from the gradient by how visible or certain it is to those by the sums in the layers, then
// some columns of weights, over all rays of the workgroup in their order. reduce_visibility adds the groups.
#include "effects/ray_network.glsl"
layout(local_size_x = VISIBILITY_GROUP) in;

BUFFER(VW_SLOT_VISIBILITY) readonly buffer Visibility { vec2 visibility[]; };
BUFFER(VW_SLOT_VISIBILITY_PARTIALS) writeonly buffer Partials { vec4 partials[]; };
PUSH uniform Push { vw_push_rays push; };

// Rows of four numbers of each ray.
const uint ROW_HIDDEN1 = NETWORK_RAY4, ROW_HIDDEN2 = ROW_HIDDEN1 + VISIBILITY4;
const uint ROW_D_SUM1 = ROW_HIDDEN2 + VISIBILITY4, ROW_D_SUM2 = ROW_D_SUM1 + VISIBILITY4,
           ROWS = ROW_D_SUM2 + VISIBILITY4;
shared vec4 rows[ROWS * VISIBILITY_GROUP];
shared float d_logits[VISIBILITY_GROUP];

vec4 row_of(uint row, uint ray) { return rows[row * VISIBILITY_GROUP + ray]; }

// Returns a ray's contribution to a column of a matrix; `at` is relative to the matrix's first column.
vec4 matrix_gradient(uint at, uint columns, uint from_row, uint to_row, uint ray) {
    uint from = at / 4u % columns, to = at / 4u / columns;
#ifdef NETWORK_CODE4
    bool of_code = columns == NETWORK_INPUT4 && from >= NETWORK_RAY4;
    uint of_ray = min(from, NETWORK_RAY4 - 1u), of_photo = max(from, NETWORK_RAY4) - NETWORK_RAY4; // one of them counts
    vec4 input4 = of_code ? code[of_photo] : row_of(from_row + of_ray, ray);
#else
    vec4 input4 = row_of(from_row + from, ray);
#endif
    return row_of(to_row + to, ray) * input4[at % 4u];
}

vec4 column_gradient(uint column, uint ray) {
    if (column < NETWORK_LAYER2) return matrix_gradient(column, NETWORK_INPUT4, 0u, ROW_D_SUM1, ray);
    if (column < NETWORK_BIAS2)
        return matrix_gradient(column - NETWORK_LAYER2, VISIBILITY4, ROW_HIDDEN1, ROW_D_SUM2, ray);
    if (column < NETWORK_LOGIT) return row_of(ROW_D_SUM2 + column - NETWORK_BIAS2, ray);
    if (column < NETWORK_LOGIT + VISIBILITY4) return d_logits[ray] * row_of(ROW_HIDDEN2 + column - NETWORK_LOGIT, ray);
    return vec4(d_logits[ray], 0.0, 0.0, 0.0);
}

void main() {
    uint lane = gl_LocalInvocationID.x, group = workgroup_index(), ray = group * VISIBILITY_GROUP + lane;
    uint known = min(ray, visibility.length() - 1u);
    load_network(lane, VISIBILITY_GROUP);
    vec4 inputs[NETWORK_RAY4], hidden1[VISIBILITY4], hidden2[VISIBILITY4], d_sum1[VISIBILITY4], d_sum2[VISIBILITY4];
    encode_pixel(push.first_pixel + min(known, push.ray_count - 1u), inputs);
    float visible = sigmoid(network_logit(inputs, hidden1, hidden2));
    float d_logit = ray == known ? visibility[known].y * visible * (1.0 - visible) : 0.0;
    network_back(d_logit, hidden1, hidden2, d_sum1, d_sum2);
    [[unroll]] for (uint k = 0u; k < NETWORK_RAY4; k++) rows[k * VISIBILITY_GROUP + lane] = inputs[k];
    [[unroll]] for (uint k = 0u; k < VISIBILITY4; k++) {
        rows[(ROW_HIDDEN1 + k) * VISIBILITY_GROUP + lane] = hidden1[k];
        rows[(ROW_HIDDEN2 + k) * VISIBILITY_GROUP + lane] = hidden2[k];
        rows[(ROW_D_SUM1 + k) * VISIBILITY_GROUP + lane] = d_sum1[k];
        rows[(ROW_D_SUM2 + k) * VISIBILITY_GROUP + lane] = d_sum2[k];
    }
    d_logits[lane] = d_logit;
    barrier();
    for (uint column = lane; column < NETWORK_COLUMNS; column += VISIBILITY_GROUP) {
        vec4 sum = vec4(0.0);
        for (uint i = 0u; i < VISIBILITY_GROUP; i++) sum += column_gradient(column, i);
        partials[group * NETWORK_COLUMNS + column] = sum;
    }
}
