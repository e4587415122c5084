#include "reference.h"

#include <math.h>

bool reference_camera_line(const struct vw_view *view, const struct vw_box *box, double x_px, double y_px,
                           double origin[3], double direction[3]) {
    double in_camera[3], length = 0.0;
    if (!vw_camera_unproject(&view->camera, x_px, y_px, in_camera)) return false;
    for (int row = 0; row < 3; row++) {
        direction[row] = 0.0;
        for (int column = 0; column < 3; column++)
            direction[row] += view->camera_to_world[row][column] * in_camera[column];
        origin[row] = (view->camera_to_world[row][3] - box->centre_world[row]) / (2.0 * box->half_extent_world) + 0.5;
        length += direction[row] * direction[row];
    }
    for (int row = 0; row < 3; row++) direction[row] /= sqrt(length);
    return true;
}

bool reference_box_span(const double origin[3], const double direction[3], double least, double margin, double *near,
                        double *far) {
    *near = least;
    *far = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        double low = -margin - origin[axis], high = 1.0 + margin - origin[axis];
        if (direction[axis] == 0.0) {
            if (low > 0.0 || high < 0.0) return false;
            continue;
        }
        *near = fmax(*near, fmin(low / direction[axis], high / direction[axis]));
        *far = fmin(*far, fmax(low / direction[axis], high / direction[axis]));
    }
    return *near < *far;
}

struct reference_ray reference_ray_of(const struct vw_ray *ray) {
    return (struct reference_ray){
        .origin = {ray->origin_near.x, ray->origin_near.y, ray->origin_near.z},
        .near = ray->origin_near.w,
        .direction = {ray->direction_stride.x, ray->direction_stride.y, ray->direction_stride.z},
        .stride = ray->direction_stride.w,
        .far = ray->direction_stride.w,
        .target = {ray->target_weight.x, ray->target_weight.y, ray->target_weight.z},
        .weight = ray->target_weight.w,
    };
}
