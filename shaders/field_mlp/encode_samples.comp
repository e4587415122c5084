// Writes the inputs of the field mlp, one sample per invocation: positional encodings of the sample's position and of
// the ray's direction.
#include "field_mlp/positional_encoding.glsl"
#include "rays/sample_places.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_LAYER_ROWS) writeonly buffer LayerRows { vec4 layer_rows[]; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint slot = invocation_index();
    uint ray_index = push.first_ray + slot / SAMPLES;
    uint sample_in_ray = slot - slot / SAMPLES * SAMPLES;
    vw_ray ray = rays[ray_index];
    vec3 position = position_at(ray, sample_place(slot, ray_index, sample_in_ray, push.key));
    const uint position4 = VW_ENCODED4(POSITION_FREQUENCIES), direction4 = VW_ENCODED4(VW_DIRECTION_FREQUENCIES);
    precise vec3 centred = 2.0 * position - 1.0;
    [[unroll]] for (uint row = 0u; row < position4; row++) layer_rows[VW_ROW_PLACE(LAYER_ROWS, row, slot)] =
        encoded_row(centred, row, POSITION_FREQUENCIES);
    [[unroll]] for (uint row = 0u; row < direction4; row++)
        layer_rows[VW_ROW_PLACE(LAYER_ROWS, position4 + row, slot)] =
            encoded_row(ray.direction_stride.xyz, row, VW_DIRECTION_FREQUENCIES);
}
