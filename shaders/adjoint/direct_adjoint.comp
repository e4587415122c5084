// The backward pass at one step, before its curvature: what the step earns, and the direction along which colours are
// differentiated. With m the first moment (without momentum the gradient g itself), the step moved the params by -q m,
// q the optimiser's rate, which is held fixed: q = (before - after) / m, whatever the optimiser. The adjoint of m is a
// = mu - q lambda, and since m = beta1 m_before + (1 - beta1) g:
//   direction = (1 - beta1) a,  the step's credit = g . direction,  mu <- beta1 a,
// and, once colours are known, lambda <- lambda + H direction.
// A param that the step left alone keeps its mu (lazy Adam). Each of VW_ADJOINT_GROUPS workgroups sums its share in a
// fixed order.
#include "two_float.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PARAMS_BEFORE) readonly buffer Before { vec4 before[]; };
BUFFER(VW_SLOT_PARAMS_AFTER) readonly buffer After { vec4 after[]; };
BUFFER(VW_SLOT_STEP_GRADIENT) readonly buffer StepGradient { vec4 step_gradient[]; };
BUFFER(VW_SLOT_STEP_MOMENT) readonly buffer StepMoment { vec4 step_moment[]; };
BUFFER(VW_SLOT_ADJOINT) readonly buffer Adjoint { vec4 adjoint[]; };
BUFFER(VW_SLOT_ADJOINT_MOMENT) buffer AdjointMoment { vec4 adjoint_moment[]; };
BUFFER(VW_SLOT_DIRECTION) writeonly buffer Direction { vec4 direction[]; };
BUFFER(VW_SLOT_ADJOINT_SUMS) writeonly buffer Sums { vec4 sums[]; };
PUSH uniform Push { vw_push_block push; };

shared vec2 credits[64];
shared vec3 squares[64];

vec4 quotient(vec4 a, vec4 b) {
    bvec4 none = equal(b, vec4(0.0));
    return mix(a / mix(b, vec4(1.0), none), vec4(0.0), none);
}

// Returns the direction at one vec4 of the block.
vec4 direct(uint i, vec4 gradient) {
    vec4 moved = before[i] - after[i];
    if (MOMENTUM == 0u) return -quotient(moved, gradient) * adjoint[i];
    vec4 moment = mix(step_moment[i], gradient, equal(step_moment[i], vec4(0.0)));
    bvec4 alone = equal(abs(moved) + abs(gradient), vec4(0.0));
    vec4 pulled = mix(adjoint_moment[i] - quotient(moved, moment) * adjoint[i], vec4(0.0), alone);
    adjoint_moment[i] = mix(push.beta1 * pulled, adjoint_moment[i], alone);
    return (1.0 - push.beta1) * pulled;
}

void main() {
    uint lane = gl_LocalInvocationID.x, group = workgroup_index();
    vec2 credit = vec2(0.0);
    vec3 square = vec3(0.0);
    for (uint i = group * 64u + lane; i < push.count; i += VW_ADJOINT_GROUPS * 64u) {
        vec4 gradient = step_gradient[i], towards = direct(i, gradient);
        direction[i] = towards;
        credit = two_add(credit, vec2(dot(gradient, towards), 0.0));
        square += vec3(dot(towards, towards), dot(before[i], before[i]), dot(adjoint[i], adjoint[i]));
    }
    credits[lane] = credit;
    squares[lane] = square;
    barrier();
    if (lane != 0u) return;
    for (uint i = 1u; i < 64u; i++) {
        credit = two_add(credit, credits[i]);
        square += squares[i];
    }
    sums[2u * group] = vec4(credit, 0.0, 0.0);
    sums[2u * group + 1u] = vec4(square, 0.0);
}
