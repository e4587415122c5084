// The inner product of the adjoint with what a step moved the params by, or with the step's gradient: of methods that
// ask what a step does to validation there and then. Each of VW_ADJOINT_GROUPS workgroups sums its share in a fixed
// order; reduce_adjoint adds them.
#include "two_float.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PARAMS_BEFORE) readonly buffer Before { vec4 before[]; };
BUFFER(VW_SLOT_PARAMS_AFTER) readonly buffer After { vec4 after[]; };
BUFFER(VW_SLOT_STEP_GRADIENT) readonly buffer StepGradient { vec4 step_gradient[]; };
BUFFER(VW_SLOT_ADJOINT) readonly buffer Adjoint { vec4 adjoint[]; };
BUFFER(VW_SLOT_ADJOINT_SUMS) writeonly buffer Sums { vec4 sums[]; };
PUSH uniform Push { vw_push_product push; };

shared vec2 products[64];
shared float squares[64];

void main() {
    uint lane = gl_LocalInvocationID.x, group = workgroup_index();
    vec2 product = vec2(0.0);
    float square = 0.0;
    for (uint i = group * 64u + lane; i < push.count; i += VW_ADJOINT_GROUPS * 64u) {
        vec4 other = push.by_gradient != 0u ? step_gradient[i] : after[i] - before[i];
        product = two_add(product, vec2(dot(adjoint[i], other), 0.0));
        square += dot(adjoint[i], adjoint[i]);
    }
    products[lane] = product;
    squares[lane] = square;
    barrier();
    if (lane != 0u) return;
    for (uint i = 1u; i < 64u; i++) {
        product = two_add(product, products[i]);
        square += squares[i];
    }
    sums[2u * group] = vec4(product, 0.0, 0.0);
    sums[2u * group + 1u] = vec4(0.0, 0.0, square, 0.0);
}
