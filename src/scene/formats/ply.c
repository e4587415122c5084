#include "scene/formats/ply.h"

#include <math.h>

#include "base/csv.h"

static const char vertex_properties[] = "property double x\nproperty double y\nproperty double z\n"
                                        "property uchar red\nproperty uchar green\nproperty uchar blue\n";

static void print_vertex(FILE *stream, const double position[3], const uint32_t rgb[3]) {
    vw_csv_print(stream, "r r r u u u\n", position[0], position[1], position[2], rgb[0], rgb[1], rgb[2]);
}

void vw_point_rgb(const struct vw_point *point, uint32_t rgb[3]) {
    for (int c = 0; c < 3; c++) rgb[c] = (uint32_t)lroundf(255 * fminf(fmaxf(point->rgb[c], 0), 1));
}

void vw_ply_print_points(FILE *stream, const void *context) {
    const struct vw_scene *scene = context;
    fprintf(stream, "ply\nformat ascii 1.0\nelement vertex %u\n%send_header\n", scene->point_count, vertex_properties);
    for (uint32_t i = 0; i < scene->point_count; i++) {
        uint32_t rgb[3];
        vw_point_rgb(&scene->points[i], rgb);
        print_vertex(stream, scene->points[i].position_world, rgb);
    }
}

// ---- Cameras -------------------------------------------------------------------------------------------------------

static const double DEPTH_SHARE = 0.06; // the mean distance of cameras from their centre is 1

double vw_camera_pyramid_depth(const struct vw_scene *scene) {
    double mean[3] = {0}, distance = 0, count = scene->view_count;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int axis = 0; axis < 3; axis++) mean[axis] += scene->views[v].camera_to_world[axis][3] / count;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const double(*pose)[4] = scene->views[v].camera_to_world;
        distance += hypot(hypot(pose[0][3] - mean[0], pose[1][3] - mean[1]), pose[2][3] - mean[2]) / count;
    }
    return DEPTH_SHARE * (distance > 0 ? distance : scene->box.half_extent_world);
}

void vw_rank_colour(double share, uint32_t rgb[3]) {
    static const double anchors[3][3] = {{68, 1, 84}, {33, 145, 140}, {253, 231, 37}};
    int low = share < 0.5 ? 0 : 1;
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint32_t)lround(anchors[low][c] + (2 * share - low) * (anchors[low + 1][c] - anchors[low][c]));
}

// Prints the corner (x, y) of the image, in photo sizes, at a depth; depth 0 is the centre.
static void print_corner(FILE *stream, const struct vw_view *view, const int at[2], double depth,
                         const uint32_t rgb[3]) {
    const struct vw_camera *camera = &view->camera;
    double world[3],
        direction[3] = {(at[0] * (double)camera->width_px - camera->centre_x_px) / camera->focal_x_px,
                        (camera->centre_y_px - at[1] * (double)camera->height_px) / camera->focal_y_px, -1};
    for (int axis = 0; axis < 3; axis++) {
        const double *row = view->camera_to_world[axis];
        world[axis] = row[3] + depth * (row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2]);
    }
    print_vertex(stream, world, rgb);
}

void vw_ply_print_cameras(FILE *stream, const void *context) {
    static const int corners[5][2] = {{0, 0}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
    static const uint32_t faces[6][3] = {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}, {1, 2, 3}, {1, 3, 4}};
    const struct vw_camera_pyramids *cameras = context;
    fprintf(stream, "ply\nformat ascii 1.0\nelement vertex %u\n%s", 5 * cameras->count, vertex_properties);
    fprintf(stream, "element face %u\nproperty list uchar int vertex_indices\nend_header\n", 6 * cameras->count);
    for (uint32_t i = 0; i < cameras->count; i++)
        for (int k = 0; k < 5; k++)
            print_corner(stream, cameras->pyramids[i].view, corners[k], k ? cameras->depth_world : 0,
                         cameras->pyramids[i].rgb);
    for (uint32_t i = 0; i < cameras->count; i++)
        for (int f = 0; f < 6; f++)
            vw_csv_print(stream, "3 u u u\n", 5 * i + faces[f][0], 5 * i + faces[f][1], 5 * i + faces[f][2]);
}
