#include "train/pixels.h"

#include <math.h>

#include "base/random.h"
#include "image/image.h"

// Beyond this distance from the box's centre (in box edges), rays start near the box instead of at the camera: see
// interface.h.
static const double FAR_CAMERA_EDGES = 4.0;

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

struct vw_pixel vw_pixels_at(const struct vw_scene *scene, uint32_t view, uint32_t x_px, uint32_t y_px) {
    float rgba[4];
    const struct vw_image *image = &scene->views[view].image;
    vw_image_pixel(image, x_px, y_px, rgba);
    return (struct vw_pixel){
        .x_px = (float)x_px + 0.5f,
        .y_px = (float)y_px + 0.5f,
        .view = view,
        .weight = vw_view_keeps(&scene->views[view], x_px, y_px) ? 1.0f : 0.0f,
        .rgba = {rgba[0], rgba[1], rgba[2], rgba[3]},
    };
}

void vw_pixels_unmask(const struct vw_scene *scene, struct vw_pixel *pixels, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        pixels[i].weight =
            vw_view_can_use(&scene->views[pixels[i].view], (uint32_t)pixels[i].x_px, (uint32_t)pixels[i].y_px) ? 1.0f
                                                                                                               : 0.0f;
}

// Returns the beginning of part `index` of `parts` nearly equal parts of `total`.
static uint32_t part_begin(uint32_t index, uint32_t parts, uint32_t total) {
    return (uint32_t)((uint64_t)index * total / parts);
}

static uint32_t draw_within(uint32_t word, uint32_t begin, uint32_t end) {
    return begin + vw_random_below(word, end > begin ? end - begin : 1);
}

void vw_pixels_draw(const struct vw_scene *scene, uint32_t view, const struct vw_pixel_draw *draw, uint32_t count,
                    struct vw_pixel *pixels) {
    const struct vw_image *image = &scene->views[view].image;
    uint32_t side = draw->picture_side;
    for (uint32_t ray = 0; ray < count; ray++) {
        bool in_cell = ray < side * side;
        uint32_t words[4], parts = in_cell ? side : 1, x = in_cell ? ray % side : 0, y = in_cell ? ray / side : 0;
        vw_random_words(draw->seed, VW_RANDOM_PIXEL, draw->step, ray, draw->draw, words);
        pixels[ray] = vw_pixels_at(
            scene, view,
            draw_within(words[0], part_begin(x, parts, image->width_px), part_begin(x + 1, parts, image->width_px)),
            draw_within(words[1], part_begin(y, parts, image->height_px), part_begin(y + 1, parts, image->height_px)));
    }
}

struct vw_pixel_columns vw_pixels_all_columns(const struct vw_scene *scene, uint32_t view) {
    return (struct vw_pixel_columns){0, scene->views[view].image.width_px};
}

uint32_t vw_pixels_stratify(const struct vw_scene *scene, uint32_t view, struct vw_pixel_columns columns, uint64_t seed,
                            uint32_t count, struct vw_pixel *pixels) {
    uint32_t width = columns.end - columns.begin, height = scene->views[view].image.height_px;
    if ((uint64_t)width * height <= count) {
        for (uint32_t i = 0; i < width * height; i++)
            pixels[i] = vw_pixels_at(scene, view, columns.begin + i % width, i / width);
        return width * height;
    }
    // Bands of rows whose height is near the width of the strata in them; band b takes its share of the count.
    uint32_t bands = (uint32_t)fmin(fmax(round(sqrt((double)count * height / width)), 1.0), fmin(height, count));
    uint32_t written = 0;
    for (uint32_t band = 0; band < bands; band++) {
        uint32_t strata = part_begin(band + 1, bands, count) - part_begin(band, bands, count);
        for (uint32_t stratum = 0; stratum < strata; stratum++, written++) {
            uint32_t words[4];
            vw_random_words(seed, VW_RANDOM_VALIDATION, 0, view, written, words);
            uint32_t x_px =
                draw_within(words[0], part_begin(stratum, strata, width), part_begin(stratum + 1, strata, width));
            uint32_t y_px = draw_within(words[1], part_begin(band, bands, height), part_begin(band + 1, bands, height));
            pixels[written] = vw_pixels_at(scene, view, columns.begin + x_px, y_px);
        }
    }
    return written;
}
