// A pixel of a step, drawn from a photo that the device keeps, with the bits of src/train/pixels.c. Variant `tiles`:
// the pixels of listed tiles, one tile after another.
#include "common.glsl"
#include "random.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_PHOTOS) readonly buffer Photos { uint words[]; };
BUFFER(VW_SLOT_PIXELS) writeonly buffer Pixels { vw_pixel pixels[]; };
#ifdef VW_OF_TILES
BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
#endif
PUSH uniform Push { vw_push_draw push; };

// Returns the float nearest to value / (2^bits - 1), where division would leave the last bits to the device. In binary
// the quotient repeats the value's digits for ever; `digits` are the first 32 of them. No quotient is halfway between
// two floats.
float quotient(uint digits) {
    uint zeros = 31u - findMSB(digits | 1u);
    uint first = digits << zeros | digits >> (32u - zeros & 31u), mantissa = (first >> 8) + (first >> 7 & 1u);
    return float(mantissa) * uintBitsToFloat(103u - zeros << 23); // times 2^(-24 - zeros)
}

vec4 colour(uint pixel) {
    uint word = push.first_word + pixel * push.pixel_words;
    vec4 rgba;
    [[unroll]] for (int c = 0; c < 4; c++) {
        if (push.pixel_words == 1u) rgba[c] = quotient((words[word] >> 8 * c & 0xFFu) * 0x01010101u);
        else if (push.pixel_words == 2u)
            rgba[c] = quotient((words[word + uint(c / 2)] >> 16 * (c % 2) & 0xFFFFu) * 0x00010001u);
        else rgba[c] = uintBitsToFloat(words[word + uint(c)]);
    }
    return rgba;
}

float weight(uint pixel) {
    if (push.first_mask_word == 0u) return 1.0; // no pixel of the photo is left out
    uint uses = words[push.first_mask_word + pixel / 4u] >> 8u * (pixel % 4u);
    return (uses & push.mask_bit) != 0u ? 1.0 : 0.0;
}

#ifdef VW_OF_TILES
uvec2 place(uint index) {
    uint corner = tiles[push.first_tile + index / (push.side * push.side)].corner;
    index %= push.side * push.side;
    return uvec2(corner & 0xFFFFu, corner >> 16) * push.side + uvec2(index % push.side, index / push.side);
}
#else
// Draws from part `index` of `parts` of a side.
uint place_within(uint word, uint index, uint parts, uint side_px) {
    uint begin = index * side_px / parts, end = (index + 1u) * side_px / parts, high, low;
    umulExtended(word, max(end, begin + 1u) - begin, high, low);
    return begin + high;
}

uvec2 place(uint index) {
    uvec4 drawn = random_words(RANDOM_PIXEL, push.key, index, push.draw);
    bool in_cell = index < push.side * push.side;
    uint parts = in_cell ? push.side : 1u, x = in_cell ? index % parts : 0u, y = in_cell ? index / parts : 0u;
    return uvec2(place_within(drawn.x, x, parts, push.width_px), place_within(drawn.y, y, parts, push.height_px));
}
#endif

void main() {
    uint index = invocation_index();
    if (index >= push.count) return;
    vw_pixel pixel = vw_pixel(0.0, 0.0, push.view, 0.0, vec4(0.0));
    if (index < push.listed) {
        uvec2 at = place(index);
        pixel.x_px = float(at.x) + 0.5;
        pixel.y_px = float(at.y) + 0.5;
        if (at.x < push.width_px && at.y < push.height_px) { // tiles reach beyond a photo
            pixel.weight = weight(at.y * push.width_px + at.x);
            pixel.rgba = colour(at.y * push.width_px + at.x);
        }
    }
    pixels[push.first_pixel + index] = pixel;
}
