#include "scene/formats/points_ply.h"

#include <math.h>

#include "base/csv.h"

const char vw_ply_vertex_properties[] = "property double x\nproperty double y\nproperty double z\n"
                                        "property uchar red\nproperty uchar green\nproperty uchar blue\n";

void vw_ply_print_vertex(FILE *stream, const double position[3], const uint32_t rgb[3]) {
    vw_csv_print(stream, "r r r u u u\n", position[0], position[1], position[2], rgb[0], rgb[1], rgb[2]);
}

void vw_point_rgb(const struct vw_point *point, uint32_t rgb[3]) {
    for (int c = 0; c < 3; c++) rgb[c] = (uint32_t)lroundf(255 * fminf(fmaxf(point->rgb[c], 0), 1));
}

void vw_ply_print_points(FILE *stream, const void *context) {
    const struct vw_scene *scene = context;
    fprintf(stream, "ply\nformat ascii 1.0\nelement vertex %u\n%send_header\n", scene->point_count,
            vw_ply_vertex_properties);
    for (uint32_t i = 0; i < scene->point_count; i++) {
        uint32_t rgb[3];
        vw_point_rgb(&scene->points[i], rgb);
        vw_ply_print_vertex(stream, scene->points[i].position_world, rgb);
    }
}
