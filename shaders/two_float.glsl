// Sums that do not lose the last bits: a number as an unevaluated sum high + low of two floats (Knuth's two-sum,
// Dekker's product). `precise` forbids the contractions and reorderings that would break the error terms.
#ifndef TWO_FLOAT_GLSL
#define TWO_FLOAT_GLSL

// Returns (x, y) such that a + b = x + y exactly.
vec2 two_sum(float a, float b) {
    precise float sum = a + b;
    precise float b_part = sum - a;
    precise float a_part = sum - b_part;
    precise float error = (a - a_part) + (b - b_part);
    return vec2(sum, error);
}

// Returns (x, y) such that a * a = x + y exactly, barring underflow.
vec2 two_square(float a) {
    precise float product = a * a;
    precise float scaled = 4097.0 * a;
    precise float high = scaled - (scaled - a);
    precise float low = a - high;
    precise float error = ((high * high - product) + 2.0 * high * low) + low * low;
    return vec2(product, error);
}

// Accumulates `value` into `sum`; the relative error of a sum of n stays near n * 2^-47.
vec2 two_add(vec2 sum, vec2 value) {
    vec2 exact = two_sum(sum.x, value.x);
    precise float low = exact.y + (sum.y + value.y);
    precise float high = exact.x + low;
    precise float rest = low - (high - exact.x);
    return vec2(high, rest);
}

// Adds with a third float, so that the error stays near n * 2^-70: equal values round the same way every time, and over
// millions of values the errors of two floats would add up.
vec3 three_add(vec3 sum, vec3 value) {
    vec2 first = two_sum(sum.x, value.x);
    vec2 second = two_sum(sum.y, value.y);
    vec2 carried = two_sum(second.x, first.y);
    precise float rest = (sum.z + value.z) + (second.y + carried.y);
    vec2 high = two_sum(first.x, carried.x);
    vec2 low = two_sum(high.y, rest);
    return vec3(high.x, low);
}

#endif
