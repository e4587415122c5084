// The way from a splat to its ellipse on a photo, and back: the local affine approximation of the projection
// (Zwicker et al., "EWA splatting", 2002), with a low pass (Yu et al., 2024). Camera axes here are x right, y down,
// z ahead.
//   V = J W R S, covariance = V V^T + low pass
// J is that of the lens at the mean times that of a pinhole. S has standard deviations, at least those of the filter.
#ifndef PROJECTION_GLSL
#define PROJECTION_GLSL
#include "splats/constants.glsl"
#include "splats/lens.glsl"

const float SPLAT_FAR = 1e10;            // box edges from the camera to the farthest splat that it shows
const float LOW_PASS = 0.1;              // px^2, added to the variance of a splat on the photo
const float TURN_LEAST = 1e-12;          // squared norm of the shortest quaternion that turns
const float OPACITY_LEAST = 1.0 / 255.0; // least opacity that is drawn
const float DETERMINANT_MOST = 1e30;     // px^4: beyond it floats overflow

mat3 turn_matrix(vec4 q) { // columns; q is of length 1: w, x, y, z
    float w = q.x, x = q.y, y = q.z, z = q.w;
    return mat3(1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y), //
                2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x), //
                2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y));
}

// Returns the gradient by a quaternion of length 1 from that by its matrix. It is not yet orthogonal to it.
vec4 turn_back(vec4 q, mat3 d) {
    float w = q.x, x = q.y, y = q.z, z = q.w;
    return 2.0 *
           vec4(x * (d[1].z - d[2].y) + y * (d[2].x - d[0].z) + z * (d[0].y - d[1].x),
                -2.0 * x * (d[1].y + d[2].z) + y * (d[0].y + d[1].x) + z * (d[0].z + d[2].x) + w * (d[1].z - d[2].y),
                x * (d[0].y + d[1].x) - 2.0 * y * (d[0].x + d[2].z) + z * (d[1].z + d[2].y) + w * (d[2].x - d[0].z),
                x * (d[0].z + d[2].x) + y * (d[1].z + d[2].y) - 2.0 * z * (d[0].x + d[1].y) + w * (d[0].y - d[1].x));
}

float opacity_of(float logit) { return 1.0 / (1.0 + exp(-logit)); }

struct splat_projection {
    vec3 right, down, ahead; // the camera's axes
    vec3 seen;               // from the camera, along the box's axes
    vec3 at;                 // the same along the camera's axes
    vec2 focal, slope;       // slope: x / z and y / z for J
    bvec2 inside;            // whether these are the centre's own
    vec3 w0, w1;             // rows of J W of a pinhole of focal length 1
    vec3 u0, u1;             // rows of J W
    vec3 own, held;          // derivatives of the lens at the centre and at `slope`
    vec4 bends;              // its second derivatives at `slope`
    bool in_reach;           // the lens has an inverse there
    mat3 turn;
    vec4 unit;               // the quaternion at length 1
    float norm;              // its length
    vec3 scale, scale_slope; // standard deviations, and their derivatives by the logarithms
    vec3 v0, v1;             // rows of V
    vec2 centre;             // px
    vec3 covariance;         // xx, xy, yy
    float determinant;       // determinant of the covariance
};

// Computes what the lens does to the centre, whose place it leaves in focal lengths, and to J.
void place_in_lens(vw_gpu_camera camera, vw_splat_view view, vec2 slope, inout splat_projection p) {
    p.centre = slope;
    p.u0 = p.focal.x * p.w0;
    p.u1 = p.focal.y * p.w1;
    p.in_reach = true;
    if (EFFECT_DISTORTION == DISTORTION_NONE) return;
    lens_point own = distort_point(camera, slope), held = distort_point(camera, p.slope);
    p.centre = own.at;
    p.own = own.slopes;
    p.held = held.slopes;
    p.bends = held.bends;
    p.u0 = p.focal.x * (p.held.x * p.w0 + p.held.y * p.w1);
    p.u1 = p.focal.y * (p.held.y * p.w0 + p.held.z * p.w1);
    p.in_reach = dot(slope, slope) <= view.reach * view.reach;
}

splat_projection project(vw_gpu_camera camera, vw_splat_view view, vec3 mean, vec4 log_scale_filter, vec4 quaternion) {
    splat_projection p;
    p.right = camera.right.xyz;
    p.down = -camera.up.xyz;
    p.ahead = -camera.back.xyz;
    vec3 offset = mean - camera.reference.xyz; // from a point near the box, so that far cameras lose no bits
    p.at = vec3(dot(offset, p.right), dot(offset, p.down), dot(offset, p.ahead) + camera.reference.w);
    p.seen = offset + camera.reference.w * p.ahead;
    p.focal = vec2(camera.right.w, camera.up.w);
    vec2 middle = vec2(camera.back.w, camera.more.x);
    float nearness = 1.0 / p.at.z;
    vec2 slope = p.at.xy * nearness;
    p.slope = clamp(slope, view.slopes.xy, view.slopes.zw);
    p.inside = equal(p.slope, slope);
    p.w0 = nearness * (p.right - p.slope.x * p.ahead);
    p.w1 = nearness * (p.down - p.slope.y * p.ahead);
    place_in_lens(camera, view, slope, p);
    p.centre = p.focal * p.centre + middle;
    p.norm = sqrt(dot(quaternion, quaternion));
    p.unit = quaternion / p.norm;
    p.turn = turn_matrix(p.unit);
    vec3 own = exp(log_scale_filter.xyz);
    p.scale = sqrt(own * own + log_scale_filter.w);
    p.scale_slope = own * own / max(p.scale, 1e-18); // not 0
    p.v0 = (p.u0 * p.turn) * p.scale;
    p.v1 = (p.u1 * p.turn) * p.scale;
    vec3 across = cross(p.v0, p.v1);
    float sharp = dot(across, across), xx = dot(p.v0, p.v0),
          yy = dot(p.v1, p.v1); // sharp: determinant before the low pass
    p.covariance = vec3(xx + LOW_PASS, dot(p.v0, p.v1), yy + LOW_PASS);
    // Not as the difference of two products, which a needle makes as large as each other: all terms are positive here.
    p.determinant = sharp + LOW_PASS * (xx + yy + LOW_PASS);
    return p;
}

// Says whether a view shows the splat. Every comparison fails for NaN.
bool is_shown(splat_projection p, float opacity) {
    return p.in_reach && p.at.z >= SPLAT_NEAR && p.at.z <= SPLAT_FAR && p.norm * p.norm >= TURN_LEAST &&
           p.norm <= 1e15 && p.determinant > 0.0 && p.determinant <= DETERMINANT_MOST && opacity >= OPACITY_LEAST &&
           abs(p.centre.x) <= 1e7 && abs(p.centre.y) <= 1e7;
}

vec3 conic_of(splat_projection p) { return vec3(p.covariance.z, -p.covariance.y, p.covariance.x) / p.determinant; }

struct splat_gradient {
    vec3 mean, scale;
    vec4 turn;
};

// Goes back from the gradients by centre and by the rows of J W to the one by the mean, along the camera's axes.
vec3 mean_back(splat_projection p, vec2 d_centre, vec3 d_u0, vec3 d_u1) {
    float nearness = 1.0 / p.at.z;
    vec2 d_own = p.focal * d_centre, d_slope = vec2(0.0);
    vec3 d_w0 = p.focal.x * d_u0, d_w1 = p.focal.y * d_u1;
    if (EFFECT_DISTORTION != DISTORTION_NONE) {
        vec3 by_held = vec3(dot(d_w0, p.w0), dot(d_w0, p.w1) + dot(d_w1, p.w0), dot(d_w1, p.w1));
        d_slope = vec2(dot(by_held, p.bends.xyz), dot(by_held, p.bends.yzw));
        vec3 through = p.held.x * d_w0 + p.held.y * d_w1;
        d_w1 = p.held.y * d_w0 + p.held.z * d_w1;
        d_w0 = through;
        d_own = lens_times(p.own, d_own);
    }
    d_slope -= nearness * vec2(dot(d_w0, p.ahead), dot(d_w1, p.ahead));
    d_slope = mix(vec2(0.0), d_slope, p.inside) + d_own;
    vec2 own = p.at.xy * nearness;
    return vec3(d_slope, -dot(d_slope, own) - dot(d_u0, p.u0) - dot(d_u1, p.u1)) * nearness;
}

// Goes back from the gradient by centre and inverse covariance. The latter comes as `moment` (xx, xy, yy): minus twice
// the gradient by that symmetric matrix.
splat_gradient project_back(splat_projection p, vec2 d_centre, vec3 moment) {
    vec3 conic = conic_of(p);
    mat2 inverse = mat2(conic.x, conic.y, conic.y, conic.z);
    mat2 twice = inverse * mat2(moment.x, moment.y, moment.y, moment.z) * inverse; // the gradient by the covariance
    vec3 d_v0 = twice[0].x * p.v0 + twice[1].x * p.v1, d_v1 = twice[0].y * p.v0 + twice[1].y * p.v1;
    vec3 d_u0 = p.turn * (d_v0 * p.scale), d_u1 = p.turn * (d_v1 * p.scale);
    mat3 d_matrix = outerProduct(p.u0, d_v0) + outerProduct(p.u1, d_v1); // by R S
    vec3 d_at = mean_back(p, d_centre, d_u0, d_u1);
    splat_gradient g;
    g.mean = p.right * d_at.x + p.down * d_at.y + p.ahead * d_at.z;
    g.scale =
        p.scale_slope * vec3(dot(p.turn[0], d_matrix[0]), dot(p.turn[1], d_matrix[1]), dot(p.turn[2], d_matrix[2]));
    mat3 d_turn = mat3(d_matrix[0] * p.scale.x, d_matrix[1] * p.scale.y, d_matrix[2] * p.scale.z);
    vec4 along = turn_back(p.unit, d_turn);
    g.turn = (along - p.unit * dot(p.unit, along)) / p.norm;
    return g;
}

#endif
