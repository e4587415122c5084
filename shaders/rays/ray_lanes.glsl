// RAY_LANES neighbours in a workgroup share a ray: each has a run of its samples, and they add what they found in an
// order that only RAY_LANES decides. With one lane per ray all of it folds away. Passes with it have workgroups of
// RAY_GROUP.
#ifndef RAY_LANES_GLSL
#define RAY_LANES_GLSL

const uint RAY_GROUP = 64u;

shared vec4 of_lanes[RAY_LANES > 1u ? RAY_GROUP : 1u];

uint ray_lane() { return RAY_LANES > 1u ? gl_LocalInvocationID.x % RAY_LANES : 0u; }

// Finds the run of this lane among `count` samples.
void lane_run(uint count, out uint first, out uint end) {
    first = 0u;
    end = count;
    if (RAY_LANES == 1u) return;
    uint each = (count + RAY_LANES - 1u) / RAY_LANES;
    first = min(ray_lane() * each, count);
    end = min(first + each, count);
}

// Returns the sum over the lanes before this one, or `behind`, after it; `all` is the sum over all of them. Every
// invocation of the workgroup calls it.
vec4 sum_beside(vec4 own, bool behind, out vec4 all) {
    all = own;
    if (RAY_LANES == 1u) return vec4(0.0);
    uint lane = ray_lane(), begin = gl_LocalInvocationID.x - lane;
    uint rank = behind ? RAY_LANES - 1u - lane : lane;
    of_lanes[begin + rank] = own;
    barrier();
    for (uint distance = 1u; distance < RAY_LANES; distance *= 2u) {
        vec4 before = rank >= distance ? of_lanes[begin + rank - distance] : vec4(0.0);
        barrier();
        of_lanes[begin + rank] += before;
        barrier();
    }
    all = of_lanes[begin + RAY_LANES - 1u];
    vec4 beside = rank > 0u ? of_lanes[begin + rank - 1u] : vec4(0.0);
    barrier();
    return beside;
}

#endif
