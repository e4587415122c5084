// The way of photos to the GPU: camera structs in box coordinates, and which pixels a step or the validation looks at
// (decision 9).
#ifndef VIEWWORTH_TRAIN_PIXELS_H
#define VIEWWORTH_TRAIN_PIXELS_H

#include "interface.h"
#include "viewworth/scene.h"

// Points are sparse: surfaces lie somewhat nearer and farther than the points of a view say. A tenth of the depth on
// either side is more than the 6 % of a view's depth range that its points may miss (scene/bounds.c), and costs little
// sampling.
#define PIXELS_NEAR_MARGIN 0.9
#define PIXELS_FAR_MARGIN 1.1

// Returns the camera of a view in box coordinates, computed in double.
struct vw_gpu_camera vw_pixels_camera(const struct vw_view *view, const struct vw_box *box);

// Returns one pixel with its target. Its weight is 0 if the pixel is left out; `masks`, here and below: also if a mask
// file hides it.
struct vw_pixel vw_pixels_at(const struct vw_scene *scene, uint32_t view, bool masks, uint32_t x_px, uint32_t y_px);

// Returns whether pixels are sorted: where masks are obeyed that hide some.
bool vw_pixels_are_sorted(const struct vw_scene *scene, bool masks);

// The `count` pixels of one training step, drawn uniformly with replacement; a function of (seed, step, draw). Draw 0
// is the step's own; the others are for whoever tries a step on other pixels. The first picture_side^2 of them make a
// picture of the photo: one in each of so many equal cells, row by row from the top (0: none do). Where pixels
// are sorted, those without weight come last, unless there is a picture. Returns how many come before them.
struct vw_pixel_draw {
    uint64_t seed, step;
    uint32_t draw, picture_side;
    bool masks;
};
uint32_t vw_pixels_draw(const struct vw_scene *scene, uint32_t view, const struct vw_pixel_draw *draw, uint32_t count,
                        struct vw_pixel *pixels);

// A square tile of a photo, by its first pixel.
struct vw_photo_tile {
    uint32_t left_px, top_px;
};
// Draws `count` / side^2 different squares of a photo, of `side` pixels from a grid at its corner. Lists them one after
// another, each in tiles of `tile` pixels along a side, row by row, without tiles beyond the photo. A photo that has
// fewer squares gives all of them. Returns how many tiles it listed.
uint32_t vw_pixels_draw_squares(const struct vw_scene *scene, uint32_t view, const struct vw_pixel_draw *draw,
                                uint32_t side, uint32_t tile, uint32_t count, struct vw_photo_tile *tiles);
// Writes all pixels of a tile, row by row; those beyond the photo weigh 0.
void vw_pixels_take_tile(const struct vw_scene *scene, uint32_t view, bool masks, struct vw_photo_tile tile,
                         uint32_t side, struct vw_pixel *pixels);

struct vw_pixel_columns {
    uint32_t begin, end;
};
struct vw_pixel_columns vw_pixels_all_columns(const struct vw_scene *scene, uint32_t view);

// Chooses fixed pixels of some columns of a view, of squares of `side` pixels from a grid at the photo's corner: one
// square in each of so many strata of nearly equal area that they hold `count` pixels, but at least one; all when there
// are no more. A square of which no pixel has weight is not chosen where its stratum has another. Squares at the
// photo's edge have fewer pixels. `seed` is 0 in all runs that are measured on the same pixels. Returns how many were
// written.
uint32_t vw_pixels_stratify_squares(const struct vw_scene *scene, uint32_t view, struct vw_pixel_columns columns,
                                    uint64_t seed, bool masks, uint32_t side, uint32_t count, struct vw_pixel *pixels);

#endif
