// Computes how visible each ray of the step is or, in the variant VW_UNCERTAINTY, how certain (ray_network.glsl). One
// ray per invocation, padding as in generate_rays.
#include "effects/ray_network.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_VISIBILITY) writeonly buffer Visibility { vec2 visibility[]; };
PUSH uniform Push { vw_push_rays push; };

void main() {
    uint index = min(invocation_index(), visibility.length() - 1u);
    load_network(gl_LocalInvocationID.x, 64u);
    vec4 inputs[NETWORK_RAY4], hidden1[VISIBILITY4], hidden2[VISIBILITY4];
    encode_pixel(push.first_pixel + min(index, push.ray_count - 1u), inputs);
    visibility[index] = vec2(sigmoid(network_logit(inputs, hidden1, hidden2)), 0.0);
}
