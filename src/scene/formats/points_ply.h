// Points as PLY files.
#ifndef VIEWWORTH_SCENE_FORMATS_POINTS_PLY_H
#define VIEWWORTH_SCENE_FORMATS_POINTS_PLY_H

#include <stdint.h>
#include <stdio.h>

#include "viewworth/scene.h"

extern const char vw_ply_vertex_properties[]; // lines of the header: a position and a colour
void vw_ply_print_vertex(FILE *stream, const double position[3], const uint32_t rgb[3]);
// Returns the channels of a point's colour as bytes.
void vw_point_rgb(const struct vw_point *point, uint32_t rgb[3]);
// Prints the points of a struct vw_scene: a vw_csv_printer.
void vw_ply_print_points(FILE *stream, const void *scene);

#endif
