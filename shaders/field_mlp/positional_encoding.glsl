// Positional encoding (Mildenhall et al., "NeRF", ECCV 2020, equation 4): of three numbers v in [-1, 1] the numbers
// themselves, then for k = 0, 1, ... the sines of 2^k pi v and their cosines. In half turns the multiples 2^k v are
// exact, and so is the rest after whole turns: however high the frequency, only v's own rounding is amplified. Drivers'
// own sin and cos promise nothing beyond pi.
#ifndef POSITIONAL_ENCODING_GLSL
#define POSITIONAL_ENCODING_GLSL

// Returns sin(pi r) for r in [-1/2, 1/2], to 1e-7.
float sine_of_quarter(float r) {
    float y = 3.14159265358979 * r, square = y * y;
    float series = 1.0 / 362880.0 - square * (1.0 / 39916800.0);
    series = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0 - square * (1.0 / 5040.0 - square * series)));
    return y * series;
}

// Returns number `index` of an encoding; 0 beyond its `frequencies`.
float encoded(vec3 v, uint index, uint frequencies) {
    uint beyond = max(index, 3u) - 3u, of_frequency = beyond % 6u;
    precise float turns = float(1u << min(beyond / 6u, 30u)) * v[of_frequency % 3u]; // halves of them
    precise float left = turns - 2.0 * roundEven(0.5 * turns);
    float folded = mix(left, sign(left) - left, abs(left) > 0.5);
    float wave = sine_of_quarter(mix(0.5 - abs(left), folded, of_frequency < 3u));
    return mix(mix(wave, v[min(index, 2u)], index < 3u), 0.0, index >= 3u + 6u * frequencies);
}

// Returns row `row` of an encoding.
vec4 encoded_row(vec3 v, uint row, uint frequencies) {
    return vec4(encoded(v, 4u * row, frequencies), encoded(v, 4u * row + 1u, frequencies),
                encoded(v, 4u * row + 2u, frequencies), encoded(v, 4u * row + 3u, frequencies));
}

#endif
