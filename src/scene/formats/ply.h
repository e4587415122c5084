// Points and cameras as PLY files.
#ifndef VIEWWORTH_SCENE_FORMATS_PLY_H
#define VIEWWORTH_SCENE_FORMATS_PLY_H

#include <stdint.h>
#include <stdio.h>

#include "viewworth/scene.h"

// Returns the channels of a point's colour as bytes.
void vw_point_rgb(const struct vw_point *point, uint32_t rgb[3]);
// Prints the points of a struct vw_scene: a vw_csv_printer.
void vw_ply_print_points(FILE *stream, const void *scene);

// A camera as a pyramid, in the colour of its rank.
struct vw_camera_pyramid {
    const struct vw_view *view; // borrowed; its camera and camera_to_world
    uint32_t rgb[3];
};

struct vw_camera_pyramids {
    const struct vw_camera_pyramid *pyramids;
    uint32_t count;
    double depth_world;
};

// Returns the depth of the pyramids of a scene's cameras: a share of their mean distance from their centre.
double vw_camera_pyramid_depth(const struct vw_scene *scene);
// Returns the colour of a rank, from violet (share 0, the least) over green to yellow (1, the most): outliers would
// leave one colour for all others.
void vw_rank_colour(double share, uint32_t rgb[3]);
// Prints a struct vw_camera_pyramids, five corners and six faces each: a vw_csv_printer.
void vw_ply_print_cameras(FILE *stream, const void *pyramids);

#endif
