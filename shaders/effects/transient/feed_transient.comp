// Writes the inputs of the transient head, one sample per invocation: the code of the step's photo and, in the variant
// VW_FEATURES of the field hash, the features from its density network. The rows already hold those of the field mlp.
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_TRANSIENT_CODES) readonly buffer Codes { vec4 codes[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_LAYER_ROWS) writeonly buffer LayerRows { vec4 layer_rows[]; };
#ifdef VW_FEATURES
#include "networks/mlp.glsl"
#include "networks/rows.glsl"
#endif

void main() {
    uint slot = invocation_index();
    for (uint k = 0u; k < TRANSIENT_CODE4; k++)
        layer_rows[VW_ROW_PLACE(LAYER_ROWS, TRANSIENT_CODE_ROW + k, slot)] = codes[TRANSIENT_CODE4 * state.view + k];
#ifdef VW_FEATURES // the first is the constant that stands in the raw density's place
    for (uint k = 0u; k < GEO4; k++)
        layer_rows[VW_ROW_PLACE(LAYER_ROWS, k, slot)] = row_at(row_place(ROW_COLOUR_IN + k, slot));
#endif
}
