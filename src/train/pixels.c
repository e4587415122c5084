#include "train/pixels.h"

#include <math.h>

#include "base/random.h"
#include "image/image.h"

// Beyond this distance from the box's centre (in box edges), rays start near the box instead of at the camera: see
// interface.h.
static const double FAR_CAMERA_EDGES = 4.0;

enum { SQUARES_MAX = 256 }; // 65,536 rays in squares of 16 x 16

struct vw_gpu_camera vw_pixels_camera(const struct vw_view *view, const struct vw_box *box) {
    const struct vw_camera *camera = &view->camera;
    double edge = 2.0 * box->half_extent_world;
    double axis[3][3], position[3], depth = 0.0, distance2 = 0.0; // axis[c]: column c of the rotation, unit length
    for (int column = 0; column < 3; column++) {
        double length = 0.0;
        for (int row = 0; row < 3; row++)
            length += view->camera_to_world[row][column] * view->camera_to_world[row][column];
        for (int row = 0; row < 3; row++) axis[column][row] = view->camera_to_world[row][column] / sqrt(length);
    }
    for (int row = 0; row < 3; row++) {
        double from_centre = (view->camera_to_world[row][3] - box->centre_world[row]) / edge;
        position[row] = from_centre + 0.5;
        depth += axis[2][row] * from_centre; // along -z, towards the centre
        distance2 += from_centre * from_centre;
    }
    if (distance2 < FAR_CAMERA_EDGES * FAR_CAMERA_EDGES || depth < 0.0) depth = 0.0;
    for (int row = 0; row < 3; row++) position[row] -= depth * axis[2][row];
    bool depths_known = view->far_world > 0.0;
    double near = depths_known ? PIXELS_NEAR_MARGIN * view->near_world / edge - depth : 0.0;
    double far = depths_known ? PIXELS_FAR_MARGIN * view->far_world / edge - depth : 0.0;
    return (struct vw_gpu_camera){
        .right = {(float)axis[0][0], (float)axis[0][1], (float)axis[0][2], (float)camera->focal_x_px},
        .up = {(float)axis[1][0], (float)axis[1][1], (float)axis[1][2], (float)camera->focal_y_px},
        .back = {(float)axis[2][0], (float)axis[2][1], (float)axis[2][2], (float)camera->centre_x_px},
        .reference = {(float)position[0], (float)position[1], (float)position[2], (float)depth},
        .distortion = {(float)camera->k1, (float)camera->k2, (float)camera->p1, (float)camera->p2},
        .higher = {(float)camera->k3, (float)camera->k4, (float)camera->k5, (float)camera->k6},
        .more = {.x = (float)camera->centre_y_px,
                 .y = (float)near,
                 .z = (float)far,
                 .w = camera->lens == VW_LENS_FISHEYE},
    };
}

static bool counts(const struct vw_view *view, bool masks, uint32_t x_px, uint32_t y_px) {
    return masks ? vw_view_keeps(view, x_px, y_px) : vw_view_can_use(view, x_px, y_px);
}

struct vw_pixel vw_pixels_at(const struct vw_scene *scene, uint32_t view, bool masks, uint32_t x_px, uint32_t y_px) {
    float rgba[4];
    const struct vw_image *image = &scene->views[view].image;
    vw_image_pixel(image, x_px, y_px, rgba);
    return (struct vw_pixel){
        .x_px = (float)x_px + 0.5f,
        .y_px = (float)y_px + 0.5f,
        .view = view,
        .weight = counts(&scene->views[view], masks, x_px, y_px) ? 1.0f : 0.0f,
        .rgba = {rgba[0], rgba[1], rgba[2], rgba[3]},
    };
}

// Returns the beginning of part `index` of `parts` nearly equal parts of `total`.
static uint32_t part_begin(uint32_t index, uint32_t parts, uint32_t total) {
    return (uint32_t)((uint64_t)index * total / parts);
}

static uint32_t draw_within(uint32_t word, uint32_t begin, uint32_t end) {
    return begin + vw_random_below(word, end > begin ? end - begin : 1);
}

bool vw_pixels_are_sorted(const struct vw_scene *scene, bool masks) { return masks && scene->masked_view_count > 0; }

uint32_t vw_pixels_draw(const struct vw_scene *scene, uint32_t view, const struct vw_pixel_draw *draw, uint32_t count,
                        struct vw_pixel *pixels) {
    const struct vw_image *image = &scene->views[view].image;
    uint32_t side = draw->picture_side, first = 0, last = count; // places of pixels with weight, and without
    bool sorts = vw_pixels_are_sorted(scene, draw->masks) && !side;
    for (uint32_t ray = 0; ray < count; ray++) {
        bool in_cell = ray < side * side;
        uint32_t words[4], parts = in_cell ? side : 1, x = in_cell ? ray % side : 0, y = in_cell ? ray / side : 0;
        vw_random_words(draw->seed, VW_RANDOM_PIXEL, draw->step, ray, draw->draw, words);
        const struct vw_pixel pixel = vw_pixels_at(
            scene, view, draw->masks,
            draw_within(words[0], part_begin(x, parts, image->width_px), part_begin(x + 1, parts, image->width_px)),
            draw_within(words[1], part_begin(y, parts, image->height_px), part_begin(y + 1, parts, image->height_px)));
        pixels[pixel.weight > 0.0f || !sorts ? first++ : --last] = pixel;
    }
    return first;
}

struct vw_pixel_columns vw_pixels_all_columns(const struct vw_scene *scene, uint32_t view) {
    return (struct vw_pixel_columns){0, scene->views[view].image.width_px};
}

// The places of some strata of a grid, one after another.
struct strata {
    uint32_t width, height, count; // the grid's sides; its strata, or all places when there are no more
    uint64_t seed;
    uint32_t view, bands, band, stratum, written;
};

static struct strata strata_of(uint32_t width, uint32_t height, uint32_t count, uint64_t seed, uint32_t view) {
    // Bands of rows whose height is near the width of the strata in them; band b takes its share of the count.
    uint32_t bands = (uint32_t)fmin(fmax(round(sqrt((double)count * height / width)), 1.0), fmin(height, count));
    return (struct strata){
        .width = width, .height = height, .count = count, .seed = seed, .view = view, .bands = bands};
}

static bool takes_all(const struct strata *s) { return (uint64_t)s->width * s->height <= s->count; }

static bool has_stratum(const struct strata *s) {
    return s->written < (takes_all(s) ? s->width * s->height : s->count);
}

static uint32_t strata_in_band(const struct strata *s) {
    return part_begin(s->band + 1, s->bands, s->count) - part_begin(s->band, s->bands, s->count);
}

struct place {
    uint32_t x, y;
};

// Returns the place of the stratum that is `further` after the drawn one, in turn.
static struct place place_of(const struct strata *s, uint32_t further) {
    if (takes_all(s)) return (struct place){s->written % s->width, s->written / s->width};
    uint32_t strata = strata_in_band(s), words[4];
    uint32_t left = part_begin(s->stratum, strata, s->width), right = part_begin(s->stratum + 1, strata, s->width),
             top = part_begin(s->band, s->bands, s->height), bottom = part_begin(s->band + 1, s->bands, s->height);
    vw_random_words(s->seed, VW_RANDOM_VALIDATION, 0, s->view, s->written, words);
    struct place drawn = {draw_within(words[0], left, right), draw_within(words[1], top, bottom)};
    if (!further) return drawn;
    uint32_t columns = right > left ? right - left : 1, rows = bottom > top ? bottom - top : 1,
             index = ((drawn.y - top) * columns + drawn.x - left + further) % (columns * rows);
    return (struct place){left + index % columns, top + index / columns};
}

// Returns how many places the stratum has to choose from.
static uint32_t count_places(const struct strata *s) {
    if (takes_all(s)) return 1;
    uint32_t strata = strata_in_band(s),
             columns = part_begin(s->stratum + 1, strata, s->width) - part_begin(s->stratum, strata, s->width),
             rows = part_begin(s->band + 1, s->bands, s->height) - part_begin(s->band, s->bands, s->height);
    return (columns ? columns : 1) * (rows ? rows : 1);
}

static void next_stratum(struct strata *s) {
    s->written++;
    if (++s->stratum == strata_in_band(s)) s->band++, s->stratum = 0;
}

// Returns whether any pixel of a square counts.
static bool shows(const struct vw_view *view, bool masks, uint32_t left_px, uint32_t top_px, uint32_t side) {
    for (uint32_t y = top_px; y < top_px + side && y < view->image.height_px; y++)
        for (uint32_t x = left_px; x < left_px + side && x < view->image.width_px; x++)
            if (counts(view, masks, x, y)) return true;
    return false;
}

// Writes the pixels of a square that lie in the photo; returns how many.
static uint32_t take_square(const struct vw_scene *scene, uint32_t view, bool masks, uint32_t left_px, uint32_t top_px,
                            uint32_t side, struct vw_pixel *pixels) {
    const struct vw_image *image = &scene->views[view].image;
    uint32_t written = 0;
    for (uint32_t y = top_px; y < top_px + side && y < image->height_px; y++)
        for (uint32_t x = left_px; x < left_px + side && x < image->width_px; x++)
            pixels[written++] = vw_pixels_at(scene, view, masks, x, y);
    return written;
}

uint32_t vw_pixels_stratify_squares(const struct vw_scene *scene, uint32_t view, struct vw_pixel_columns columns,
                                    uint64_t seed, bool masks, uint32_t side, uint32_t count, struct vw_pixel *pixels) {
    uint32_t first = (columns.begin + side - 1) / side, end = columns.end / side, written = 0;
    if (columns.end == scene->views[view].image.width_px) end = (columns.end + side - 1) / side;
    if (end <= first) end = first + 1; // narrower than a square
    uint32_t height = (scene->views[view].image.height_px + side - 1) / side, squares = count / (side * side);
    struct strata strata = strata_of(end - first, height, squares ? squares : 1, seed, view);
    for (; has_stratum(&strata); next_stratum(&strata)) {
        struct place at = place_of(&strata, 0);
        for (uint32_t further = 1, places = count_places(&strata); side > 1 && further < places; further++) {
            if (shows(&scene->views[view], masks, (first + at.x) * side, at.y * side, side)) break;
            at = place_of(&strata, further);
        }
        written += take_square(scene, view, masks, (first + at.x) * side, at.y * side, side, pixels + written);
    }
    return written;
}

// Draws one of `squares` that is not among the first `drawn` of the list: Floyd's sampling.
static uint32_t draw_square(const struct vw_pixel_draw *draw, uint32_t squares, uint32_t wanted, const uint32_t *list,
                            uint32_t drawn) {
    uint32_t words[4], last = squares - wanted + drawn;
    vw_random_words(draw->seed, VW_RANDOM_PIXEL, draw->step, drawn, draw->draw, words);
    uint32_t square = vw_random_below(words[0], last + 1);
    for (uint32_t i = 0; i < drawn; i++)
        if (list[i] == square) return last;
    return square;
}

void vw_pixels_take_tile(const struct vw_scene *scene, uint32_t view, bool masks, struct vw_photo_tile tile,
                         uint32_t side, struct vw_pixel *pixels) {
    const struct vw_image *image = &scene->views[view].image;
    for (uint32_t i = 0; i < side * side; i++) {
        uint32_t x = tile.left_px + i % side, y = tile.top_px + i / side;
        bool inside = x < image->width_px && y < image->height_px;
        pixels[i] = inside ? vw_pixels_at(scene, view, masks, x, y)
                           : (struct vw_pixel){.x_px = (float)x + 0.5f, .y_px = (float)y + 0.5f, .view = view};
    }
}

uint32_t vw_pixels_draw_squares(const struct vw_scene *scene, uint32_t view, const struct vw_pixel_draw *draw,
                                uint32_t side, uint32_t tile, uint32_t count, struct vw_photo_tile *tiles) {
    const struct vw_image *image = &scene->views[view].image;
    uint32_t columns = (image->width_px + side - 1) / side, rows = (image->height_px + side - 1) / side,
             squares = columns * rows, wanted = count / (side * side), written = 0, list[SQUARES_MAX];
    if (wanted > squares) wanted = squares;
    for (uint32_t i = 0; i < wanted; i++) {
        list[i] = draw_square(draw, squares, wanted, list, i);
        uint32_t left_px = list[i] % columns * side, top_px = list[i] / columns * side;
        for (uint32_t y = top_px; y < top_px + side && y < image->height_px; y += tile)
            for (uint32_t x = left_px; x < left_px + side && x < image->width_px; x += tile)
                tiles[written++] = (struct vw_photo_tile){x, y};
    }
    return written;
}
