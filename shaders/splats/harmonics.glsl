// A splat's colour by direction, forward and backward: real spherical harmonics of bands 0 to 3, in the order and with
// the signs of the files that viewers read (Kerbl et al., 2023).
//   colour = max(0, 0.5 + sum over k of basis_k(direction) coefficient_k)
#ifndef HARMONICS_GLSL
#define HARMONICS_GLSL

const uint HARMONICS_MOST = (VW_SPLAT_DEGREE_MAX + 1u) * (VW_SPLAT_DEGREE_MAX + 1u);

// Returns the value of basis k (w) and its gradient by the direction (xyz), as a polynomial of it.
vec4 harmonic(uint k, vec3 d) {
    float x = d.x, y = d.y, z = d.z, xx = x * x, yy = y * y, zz = z * z;
    switch (k) {
    case 0u: return vec4(0.0, 0.0, 0.0, 0.28209479177387814);
    case 1u: return 0.48860251190291987 * vec4(0.0, -1.0, 0.0, -y);
    case 2u: return 0.48860251190291987 * vec4(0.0, 0.0, 1.0, z);
    case 3u: return 0.48860251190291987 * vec4(-1.0, 0.0, 0.0, -x);
    case 4u: return 1.0925484305920792 * vec4(y, x, 0.0, x * y);
    case 5u: return -1.0925484305920792 * vec4(0.0, z, y, y * z);
    case 6u: return 0.31539156525252005 * vec4(-2.0 * x, -2.0 * y, 4.0 * z, 2.0 * zz - xx - yy);
    case 7u: return -1.0925484305920792 * vec4(z, 0.0, x, x * z);
    case 8u: return 0.54627421529603959 * vec4(2.0 * x, -2.0 * y, 0.0, xx - yy);
    case 9u: return -0.59004358992664352 * vec4(6.0 * x * y, 3.0 * (xx - yy), 0.0, y * (3.0 * xx - yy));
    case 10u: return 2.8906114426405538 * vec4(y * z, x * z, x * y, x * y * z);
    case 11u:
        return -0.45704579946446572 *
               vec4(-2.0 * x * y, 4.0 * zz - xx - 3.0 * yy, 8.0 * y * z, y * (4.0 * zz - xx - yy));
    case 12u:
        return 0.3731763325901154 *
               vec4(-6.0 * x * z, -6.0 * y * z, 6.0 * zz - 3.0 * xx - 3.0 * yy, z * (2.0 * zz - 3.0 * xx - 3.0 * yy));
    case 13u:
        return -0.45704579946446572 *
               vec4(4.0 * zz - 3.0 * xx - yy, -2.0 * x * y, 8.0 * x * z, x * (4.0 * zz - xx - yy));
    case 14u: return 1.4453057213202769 * vec4(2.0 * x * z, -2.0 * y * z, xx - yy, z * (xx - yy));
    }
    return -0.59004358992664352 * vec4(3.0 * (xx - yy), -6.0 * x * y, 0.0, x * (xx - 3.0 * yy));
}

#endif
