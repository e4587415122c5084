// Structural similarity (Wang et al., 2004) of what is seen and the photo: its loss, and the gradient by what is seen.
// Every pixel that counts has a window: 11 x 11 pixels about it, a Gaussian, of which those of its square that count
// share the weight. So windows lie within what is drawn, and neither a square's rim nor a mask leaves out a pixel. A
// workgroup per square. An invocation has a pixel of it and, in between, a line of one of 16 planes, which it filters.
#include "effects/seen.glsl"
#include "splats/constants.glsl"
layout(local_size_x = 256) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_SPLAT_VIEWS) readonly buffer Views { vw_splat_view views[]; };
BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
BUFFER(VW_SLOT_D_WINDOWS) writeonly buffer DWindows { vec4 d_windows[]; };
PUSH uniform Push { vw_push_splats push; };

#ifdef VW_RAY_EFFECTS // the gradient is of windows times the weights of their rays
#include "effects/ray_weights.glsl"
#endif

const uint SIDE = VW_SPLAT_SQUARE, PIXELS = SIDE * SIDE, TILES_ALONG = SIDE / SPLAT_SIDE;
const float C1 = 0.01 * 0.01, C2 = 0.03 * 0.03;
// Weights exp(-d^2 / (2 * 1.5^2)) by the distance in px.
const float GAUSSIAN[] = float[](1.0, 0.800737403, 0.411112291, 0.135335283, 0.0285655008, 0.00386592014);
const uint REACH = 5u;

// Planes of the pixels themselves, a channel each.
const uint ONES = 0u, SEEN = 3u, PHOTO = 6u, WEIGHT = 9u;
// Moments, as products of two of these and the weight: a channel each, the weight itself last.
const uint FACTOR[] = uint[](SEEN, PHOTO, SEEN, PHOTO, SEEN, ONES);
const uint OTHER[] = uint[](ONES, ONES, SEEN, PHOTO, PHOTO, ONES);
const uint MEAN_SEEN = 0u, MEAN_PHOTO = 3u, SEEN_SEEN = 6u, PHOTO_PHOTO = 9u, SEEN_PHOTO = 12u, SHARE = 15u;
// Gradients by the first moment, the squares and the products of what is seen; a channel each.
const uint D_MEAN = 0u, D_SEEN_SEEN = 3u, D_SEEN_PHOTO = 6u, D_PLANES = 9u;

shared float planes[16u * PIXELS]; // 16 KiB

void filter_line(inout float line[SIDE]) {
    float sums[SIDE];
    [[unroll]] for (uint to = 0u; to < SIDE; to++) {
        sums[to] = 0.0;
        [[unroll]] for (uint from = 0u; from < SIDE; from++) if (from <= to + REACH && to <= from + REACH) sums[to] +=
            GAUSSIAN[from < to ? to - from : from - to] * line[from];
    }
    line = sums;
}

void put_line(uint first, uint stride, float line[SIDE]) {
    [[unroll]] for (uint i = 0u; i < SIDE; i++) planes[first + i * stride] = line[i];
}

// Filters a line in its place.
void filter_planes(uint first, uint stride) {
    float line[SIDE];
    [[unroll]] for (uint i = 0u; i < SIDE; i++) line[i] = planes[first + i * stride];
    filter_line(line);
    put_line(first, stride, line);
}

// Filters the rows of a moment, whose plane takes the place of the pixels'.
void filter_moment(uint kind, uint row) {
    uint first = row * SIDE, channel = kind % 3u;
    uint factor = (FACTOR[kind / 3u] + channel) * PIXELS + first, other = (OTHER[kind / 3u] + channel) * PIXELS + first;
    float line[SIDE];
    [[unroll]] for (uint i = 0u; i < SIDE; i++) line[i] =
        planes[WEIGHT * PIXELS + first + i] * planes[factor + i] * planes[other + i];
    filter_line(line);
    barrier();
    put_line(kind * PIXELS + first, 1u, line);
}

// Returns the similarity, and its gradient by the mean of what is seen, of its squares, and of its products with the
// photo. `second`: the means of both squares and of the products.
float similarity(vec2 mean, vec3 second, out vec3 d_moments) {
    float square = dot(mean, mean), product = 2.0 * mean.x * mean.y, means = product + C1;
    float covariance = 2.0 * second.z - product + C2, variances = max(second.x + second.y - square, 0.0) + C2;
    float share = 1.0 / ((square + C1) * variances), value = means * covariance * share;
    d_moments.x = 2.0 * mean.y * (covariance - means) * share;
    d_moments.x += 2.0 * mean.x * value * (1.0 / variances - 1.0 / (square + C1));
    d_moments.yz = vec2(-value / variances, 2.0 * means * share);
    return value;
}

// Compares the windows about a pixel: leaves their slopes, times the ray's weight, in place of the moments, and returns
// their loss.
float compare(uint place, float weight, float of_ray) {
    float whole = 1.0 / max(planes[SHARE * PIXELS + place], 1e-30), loss = 0.0;
    for (uint at = place; at < 3u * PIXELS; at += PIXELS) { // channels
        vec2 mean = vec2(planes[MEAN_SEEN * PIXELS + at], planes[MEAN_PHOTO * PIXELS + at]);
        vec3 second = vec3(planes[SEEN_SEEN * PIXELS + at], planes[PHOTO_PHOTO * PIXELS + at],
                           planes[SEEN_PHOTO * PIXELS + at]),
             d_moments;
        loss += 1.0 - similarity(whole * mean, whole * second, d_moments);
        d_moments *= -weight * of_ray * whole;
        planes[D_MEAN * PIXELS + at] = d_moments.x;
        planes[D_SEEN_SEEN * PIXELS + at] = d_moments.y;
        planes[D_SEEN_PHOTO * PIXELS + at] = d_moments.z;
    }
    return weight * loss;
}

// Filters slopes back to their pixels: `place` is that of the invocation among lines.
void filter_slopes(uint kind, uint line) {
    if (kind < D_PLANES) filter_planes(kind * PIXELS + line, SIDE);
    barrier();
    if (kind < D_PLANES) filter_planes(kind * PIXELS + line * SIDE, 1u);
    barrier();
}

// Returns the first tile of a square: its tiles are listed together, those that the photo lacks are left out.
uint find_tile(uint square_index) {
    if (TILES_ALONG == 1u) return square_index;
    const uint within = (TILES_ALONG - 1u) * 0x10001u;
    uint tile = 0u;
    for (uint met = 0u; tile < push.tile_count; tile++) {
        met += mix(0u, 1u, (tiles[push.first_tile + tile].corner & within) == 0u);
        if (met > square_index) break;
    }
    return tile;
}

vec3 channels_at(uint plane, uint place) {
    uint at = plane * PIXELS + place;
    return vec3(planes[at], planes[at + PIXELS], planes[at + 2u * PIXELS]);
}

void put_channels(uint plane, uint place, vec3 value) {
    [[unroll]] for (uint channel = 0u; channel < 3u; channel++) planes[(plane + channel) * PIXELS + place] =
        value[channel];
}

void main() {
    uint tile = find_tile(workgroup_index()), place = gl_LocalInvocationID.x, kind = place / SIDE, line = place % SIDE;
    vw_splat_tile listed = tiles[push.first_tile + tile];
    vw_splat_view view = views[listed.view];
    uvec2 corner = uvec2(listed.corner & 0xFFFFu, listed.corner >> 16);
    uvec2 there = min(uvec2(view.columns, view.rows) - corner, uvec2(TILES_ALONG)); // tiles of the square, in order
    uvec2 pixel = uvec2(line, kind), of_square = pixel / SPLAT_SIDE, in_tile = pixel % SPLAT_SIDE;
    bool drawn = all(lessThan(of_square, there));
    of_square = min(of_square, there - 1u);
    uint index = ((tile + of_square.y * there.x + of_square.x) * SPLAT_SIDE + in_tile.y) * SPLAT_SIDE + in_tile.x;
    vw_ray ray = rays[index];
    vec4 blended = colours[index];
    vec3 seen = blended.rgb + blended.a * backdrop_colour(ray, index, push.key);
    vec3 photo = ray.target_weight.rgb;
    float weight = mix(0.0, ray.target_weight.w, drawn);

    put_channels(ONES, place, vec3(1.0));
    put_channels(SEEN, place, seen);
    put_channels(PHOTO, place, photo);
    planes[WEIGHT * PIXELS + place] = weight;
    barrier();
    filter_moment(kind, line);
    barrier();
    filter_planes(kind * PIXELS + line, SIDE);
    barrier();
    float of_ray = 1.0;
#ifdef VW_RAY_EFFECTS
    if (rays_are_weighed()) of_ray = ray_weight(index);
#endif
    float loss = compare(place, weight / 3.0, of_ray);
    barrier();
    filter_slopes(kind, line);
    vec3 slope = channels_at(D_MEAN, place) + 2.0 * seen * channels_at(D_SEEN_SEEN, place);
    slope += photo * channels_at(D_SEEN_PHOTO, place);
    if (drawn) d_windows[index] = vec4(weight * slope, loss);
}
