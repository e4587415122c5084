// The thumbnail of the picture that a step has rendered, for the consistency loss beside the effect appearance_encoder:
// area means of 2 rgb - 1, all of which count. One pixel per invocation.
#include "effects/appearance_encoder/picture.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_SEEN_AHEAD) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_THUMBNAILS) writeonly buffer Thumbnails { vec4 thumbnails[]; };
PUSH uniform Push { vw_push_picture push; };

void main() {
    uint index = invocation_index();
    if (index >= THUMBNAIL_PIXELS) return;
    uvec2 at = uvec2(index % THUMBNAIL_SIDE, index / THUMBNAIL_SIDE);
    uvec2 first = overlapped(at, THUMBNAIL_SIDE, push.side), end = overlapped_end(at, THUMBNAIL_SIDE, push.side);
    vec3 sum = vec3(0.0);
    for (uint y = first.y; y < end.y; y++)
        for (uint x = first.x; x < end.x; x++)
            sum += share_of(at.x, x, push.side) * share_of(at.y, y, push.side) *
                   (2.0 * colours[push.side * y + x].rgb - 1.0);
    thumbnails[index] = vec4(sum, 1.0);
}
