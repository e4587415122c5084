// Everything host and shaders share about splats, a part of interface.h. VW_SLOT_* of splats are in that file.
#ifndef VIEWWORTH_SPLAT_INTERFACE_H
#define VIEWWORTH_SPLAT_INTERFACE_H

// Further constants of the passes of splats (shaders/splats/constants.glsl), which no other pass declares.
#define VW_SPLAT_SPECIALIZATION(X) \
    X(92, SPLAT_SIDE, side, uint, 8)               /* pixels along a side of a tile */ \
    X(93, SPLAT_LANES, lanes, uint, 1)             /* invocations that share a tile, each of which has as many of its pixels */ \
    X(94, SPLAT_GROUP, group, uint, 8)             /* workgroup of blend_tiles: SPLAT_LANES, or any where these are 1 */ \
    X(95, SORT_LANES, sort_lanes, uint, 16)        /* workgroup of the sort; each invocation sorts SORT_KEYS pairs */ \
    X(96, SORT_KEYS, sort_keys, uint, 64) \
    X(97, SORT_DIGITS, sort_digits, uint, 256)     /* values of a digit: a power of two */ \
    X(98, PLACE_LANES, place_lanes, uint, 64)      /* workgroup of place_pairs */ \
    X(99, SSIM_WEIGHT, ssim_weight, float, 0.0)    /* share of the loss that is 1 - SSIM; above 0, compare_windows has run */

#ifndef VULKAN
#define uint uint32_t
struct vw_splat_specialization {
    struct vw_specialization run;
    VW_SPLAT_SPECIALIZATION(VW_CONSTANT_MEMBER)
};
#define VW_CHECK_CONSTANT(id, upper, lower, type, value) \
    _Static_assert(offsetof(struct vw_splat_specialization, lower) == 4 * (id), "specialization constant " #upper " is out of place");
VW_SPLAT_SPECIALIZATION(VW_CHECK_CONSTANT)
#undef VW_CHECK_CONSTANT
#undef uint
enum { VW_SPLAT_SPECIALIZATION_COUNT = sizeof(struct vw_splat_specialization) / 4 };
#endif

// A splat is vec4 columns: mean (box coordinates) and logit of opacity; log scales (box edges) and the variance of its filter, which
// stays as it began; quaternion w, x, y, z of any length; then rgb of one harmonic each, w unused, (degree + 1)^2 of them.
VW_ENUM(SPLAT_MEAN, 0)
VW_ENUM(SPLAT_SCALE, 1)
VW_ENUM(SPLAT_TURN, 2)
VW_ENUM(SPLAT_HARMONICS, 3)
VW_ENUM(VW_SPLAT_DEGREE_MAX, 3)
VW_ENUM(VW_SPLAT_SQUARE, 16) // side in px of the squares of a photo that a step draws
#define VW_SPLAT_COLUMNS(degree) (SPLAT_HARMONICS + ((degree) + 1u) * ((degree) + 1u))
VW_ENUM(VW_SPLAT_DRAWN4, 3)
VW_ENUM(VW_SPLAT_PAIR4, 3)
VW_ENUM(VW_SPLAT_DEPTH_BITS, 20)     // low bits of a pair's key; those of its tile are above
VW_ENUM(VW_SPLAT_TILES_MAX, 4095)    // per dispatch, so that the key of no tile is all ones
VW_ENUM(VW_SPLAT_CELLS_MAX, 60000)   // tiles of a view: an invocation may have 65,535 trips through loops
VW_ENUM(VW_SPLAT_TILE_PAIRS_MAX, 60000) // likewise pairs of a tile; more are an overflow

struct vw_splat_view {           // a view as a grid of tiles from its top left corner
    vw_uint camera;              // its vw_gpu_camera
    vw_uint first_cell, columns, rows;
    vw_float4 slopes;            // least and most x / z and y / z at which J is that of the centre, and not of the nearest of these
    float reach;                 // most of their length where the lens has an inverse: nothing further out is seen
    vw_uint first_tile, tiles;   // the view's range of the dispatch's tiles, each of which is tried; 0: all cells in the box
    float unused;
};

// Ray tile * SPLAT_SIDE^2 + y * SPLAT_SIDE + x of the rays is that of the pixel in row y and column x of the tile; rays of weight 0 stand
// for pixels that the photo lacks or that do not count. No two tiles of a dispatch are of the same cell.
struct vw_splat_tile {
    vw_uint view;                // in the list of views
    vw_uint corner;              // its place in the grid: row << 16 | column
    vw_uint cell;                // first_cell + row * columns + column
};

struct vw_splat_shape {          // on the photo
    vw_float4 centre_conic;      // x, y in px; xx and xy of the inverse covariance
    vw_float4 conic_depth;       // yy; opacity; depth in box edges; w unused
    vw_float4 extent;            // x, y: half the size in px of the box around all it can colour; z: exponent at its rim
};

struct vw_splat_seen {           // a sighting with pairs
    vw_uint sighting, first_pair, pairs;
};

struct vw_tile_range {           // sorted pairs of a tile
    vw_uint first, drawn_end, end; // from drawn_end on, no pixel had light left
};

struct vw_splat_state {
    vw_uint3 seen_groups;        // workgroups of 64 over the ranks
    vw_uint3 sort_groups;        // blocks of the sort
    vw_uint3 tile_groups;        // workgroups of blend_tiles over the tiles
    vw_uint3 square_groups;      // workgroups of compare_windows, one per square
    vw_uint seen, pairs;
    vw_uint overflow;            // not 0: there were more pairs than have room, and none is listed; or too many in one tile
};

// ---- Push blocks ----
struct vw_push_splats {      // the passes of splats but update_splats
    vw_uint count, stride;   // splats, and the room for them in a column
    vw_uint degree;          // degree of the harmonics that count
    vw_uint first_view, view_count; // range in the list of views
    vw_uint first_tile, tile_count; // range in the list of tiles
    vw_uint walked_tiles;    // tile_count of a single view, if it is small enough that each is tried; else 0
    vw_uint squares;         // squares of the photo that have the tiles; 0 outside training
    vw_uint pair_capacity;
    vw_uint shift;           // bits of the key below the digit that is sorted by
    vw_uint4 key;            // slope_pixels, in training
};
struct vw_push_splat_update { // update_splats
    vw_uint stride, columns;
    float mean, scale, turn, opacity, colour, harmonics; // rates, in units of the learning rate
    float extra;             // as of vw_push_update
    vw_adam adam;
};
struct vw_push_shown {       // show_pixels
    vw_uint first, count;    // range in the list of pixels
};

#endif
