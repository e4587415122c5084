// Computes the gradients by the colours of the rays of a picture from those by the sums of the encoder's first
// convolution, which saw a thumbnail of the picture. They take the place of the rays' targets, for backward_rays with
// LOSS_GIVEN. Padding lies below the picture, where no kernel reaches. One ray per invocation.
#include "effects/appearance_encoder/picture.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_ENCODER_ROWS) readonly buffer DRows { vec4 d_rows[]; };
BUFFER(VW_SLOT_RAYS) writeonly buffer Rays { vw_ray rays[]; };
PUSH uniform Push { vw_push_picture push; };
#include "networks/kernels.glsl"

void main() {
    uint index = invocation_index();
    if (index >= rays.length()) return;
    uvec2 at = uvec2(index % push.side, index / push.side);
    uvec2 first = overlapped(at, push.side, THUMBNAIL_SIDE), end = overlapped_end(at, push.side, THUMBNAIL_SIDE);
    vec3 slope = vec3(0.0);
    for (uint y = first.y; y < end.y; y++)
        for (uint x = first.x; x < end.x; x++)
            slope +=
                share_of(x, at.x, push.side) * share_of(y, at.y, push.side) * input_gradient(0u, uvec2(x, y), 0u).rgb;
    rays[index].target_weight = vec4(2.0 * slope, 3.0); // backward_rays uses a third of the weight per channel
}
