// Real spherical harmonics of a unit direction, bands 0 to 2 (the same constants as Sloan, "Stupid spherical harmonics
// tricks", 2008).
#ifndef SPHERICAL_HARMONICS_GLSL
#define SPHERICAL_HARMONICS_GLSL

const float SH_BAND0 = 0.28209479177387814;

// Bands 1 and 2 in two vec4.
void spherical_harmonics(vec3 d, out vec4 low, out vec4 high) {
    low = vec4(-0.48860251190291987 * d.y, 0.48860251190291987 * d.z, -0.48860251190291987 * d.x,
               1.0925484305920792 * d.x * d.y);
    high = vec4(-1.0925484305920792 * d.y * d.z, 0.31539156525252005 * (3.0 * d.z * d.z - 1.0),
                -1.0925484305920792 * d.x * d.z, 0.54627421529603959 * (d.x * d.x - d.y * d.y));
}

#endif
