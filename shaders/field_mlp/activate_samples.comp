// Computes rgb and density from the last layers of the field mlp, one sample per invocation; in the variant VW_BACK the
// gradients of the layers from those of rgb and raw density.
#include "networks/activations.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

PUSH uniform Push { vw_push_heads push; };
#ifdef VW_BACK
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_D_FIELD) readonly buffer DField { vec4 d_field[]; };
BUFFER(VW_SLOT_D_LAYER_ROWS) writeonly buffer DLayerRows { vec4 d_layer_rows[]; };

void main() {
    uint slot = invocation_index();
    d_layer_rows[VW_ROW_PLACE(D_LAYER_ROWS, push.logit_row, slot)] = logit_gradient(field[slot], d_field[slot]);
    d_layer_rows[VW_ROW_PLACE(D_LAYER_ROWS, push.density_row, slot)] =
        vec4(raw_gradient(field[slot], d_field[slot]), 0.0, 0.0, 0.0);
}
#else
BUFFER(VW_SLOT_LAYER_ROWS) readonly buffer LayerRows { vec4 layer_rows[]; };
BUFFER(VW_SLOT_FIELD) writeonly buffer Field { vec4 field[]; };

void main() {
    uint slot = invocation_index();
    vec4 logit = layer_rows[VW_ROW_PLACE(LAYER_ROWS, push.logit_row, slot)];
    float raw = layer_rows[VW_ROW_PLACE(LAYER_ROWS, push.density_row, slot)].x;
    field[slot] = vec4(sigmoid(logit.x), sigmoid(logit.y), sigmoid(logit.z), density_of(raw));
}
#endif
