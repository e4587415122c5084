// The shape of every splat on every view of the list, and how many tiles of the list it colours.
#include "splats/coverage.glsl"
#include "splats/projection.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_CAMERAS) readonly buffer Cameras { vw_gpu_camera cameras[]; };
BUFFER(VW_SLOT_SPLATS) readonly buffer Splats { vec4 splats[]; };
BUFFER(VW_SLOT_SPLAT_SHAPES) writeonly buffer Shapes { vw_splat_shape shapes[]; };
BUFFER(VW_SLOT_SIGHTING_PAIRS) writeonly buffer Counts { uint sighting_pairs[]; };
PUSH uniform Push { vw_push_splats push; };

vw_splat_shape shape_of(splat_projection p, float opacity) {
    vw_splat_shape shape;
    vec3 conic = conic_of(p);
    float rim = log(255.0 * opacity);
    shape.centre_conic = vec4(p.centre, conic.xy);
    shape.conic_depth = vec4(conic.z, opacity, p.at.z, 0.0);
    vec2 extent = sqrt(2.0 * (rim + RIM_MARGIN) * p.covariance.xz) * 1.001;
    shape.extent = vec4(min(extent, vec2(1e7)), rim, 0.0);
    return shape;
}

void main() {
    // One row of workgroups per view, which is thus the same for a whole workgroup: lavapipe loads it once, not per
    // lane.
    uint splat = gl_WorkGroupID.x * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    vw_splat_view view = views[push.first_view + gl_WorkGroupID.y];
    vw_gpu_camera camera = cameras[view.camera];
    if (splat >= push.count) return;
    vec4 mean = splats[SPLAT_MEAN * push.stride + splat];
    float opacity = opacity_of(mean.w);
    splat_projection p = project(camera, view, mean.xyz, splats[SPLAT_SCALE * push.stride + splat],
                                 splats[SPLAT_TURN * push.stride + splat]);
    bool shown = is_shown(p, opacity);
    vw_splat_shape shape = shape_of(p, opacity);
    uint pairs = 0u, sighting = gl_WorkGroupID.y * push.count + splat;
    cell_walk walk = begin_walk(view, shape, push.walked_tiles);
    for (; shown && has_tile(walk); walk.tile++) pairs += uint(reaches_tile(shape, walk, push.first_tile));
    for (; shown && has_cell(walk); next_cell(walk))
        pairs += uint(covered_tile(view, shape, walk.at, push.first_tile, push.tile_count) != NO_TILE);
    sighting_pairs[sighting] = pairs;
    shapes[sighting] = shape;
}
