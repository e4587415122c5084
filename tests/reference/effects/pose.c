#include "reference/effects/pose.h"

#include <math.h>
#include <string.h>

#include "train/pixels.h"

const double reference_pose_ridge = 0.01;

double reference_pose_rate(uint64_t visits) { return 0.5 / sqrt((double)visits); }

void reference_pose_of(const struct vw_model *model, const float *params, uint32_t view, double pose[REFERENCE_POSE]) {
    const float *own = params + model->ranges[VW_SLOT_POSES].offset_bytes / sizeof *params + 8 * (size_t)view;
    for (int i = 0; i < REFERENCE_POSE; i++) pose[i] = own[i / 3 * 4 + i % 3];
}

// Returns the unit of turns: for a camera far from the box they are in box edges.
static double turn_unit(const struct vw_view *view, const struct vw_box *box) {
    return 1.0 / fmax(1.0, vw_pixels_camera(view, box).reference.w);
}

// Turns a vector by the angle 2 atan(|turn| / 2) about the axis of `turn` (Rodrigues' formula).
static void turn_vector(const double turn[3], const double v[3], double turned[3]) {
    double length = sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]), angle = 2.0 * atan(0.5 * length),
           along = 0.0;
    for (int i = 0; i < 3; i++) along += length > 0.0 ? turn[i] / length * v[i] : 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        turned[i] = v[i];
        if (length > 0.0)
            turned[i] = cos(angle) * v[i] + sin(angle) * (turn[j] * v[k] - turn[k] * v[j]) / length +
                        (1.0 - cos(angle)) * along * turn[i] / length;
    }
}

struct vw_view reference_pose_apply(const struct vw_view *view, const struct vw_box *box,
                                    const double pose[REFERENCE_POSE]) {
    struct vw_view moved = *view;
    double unit = turn_unit(view, box), turn[3] = {unit * pose[3], unit * pose[4], unit * pose[5]};
    for (int column = 0; column < 3; column++) {
        double before[3], after[3];
        for (int row = 0; row < 3; row++) before[row] = view->camera_to_world[row][column];
        turn_vector(turn, before, after);
        for (int row = 0; row < 3; row++) moved.camera_to_world[row][column] = after[row];
    }
    for (int row = 0; row < 3; row++) moved.camera_to_world[row][3] += 2.0 * box->half_extent_world * pose[row];
    return moved;
}

void reference_pose_gradient(const struct vw_view *view, const struct vw_box *box, const double pose[REFERENCE_POSE],
                             const double force[3], const double torque[3], double gradient[REFERENCE_POSE]) {
    double unit = turn_unit(view, box), h[3], size2 = 0.0;
    for (int i = 0; i < 3; i++) h[i] = 0.5 * unit * pose[3 + i];
    for (int i = 0; i < 3; i++) size2 += h[i] * h[i];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        gradient[i] = force[i];
        gradient[3 + i] = unit / (1.0 + size2) * (torque[i] - (h[j] * torque[k] - h[k] * torque[j]));
    }
}

// Finds the cell as the device rounds it, and the exact place in it.
static void locate(const struct vw_specialization *s, const double position[3], uint32_t level, uint32_t cell[3],
                   double fraction[3]) {
    for (int axis = 0; axis < 3; axis++) {
        double scaled = (float)position[axis] * (float)s->resolution[level];
        cell[axis] = (uint32_t)fmin(floor(scaled), s->resolution[level] - 1.0);
        fraction[axis] = position[axis] * s->resolution[level] - cell[axis];
    }
}

static double share_of(const double fraction[3], uint32_t corner, int axis) {
    return corner >> axis & 1 ? fraction[axis] : 1.0 - fraction[axis];
}

void reference_encode_smoothly(const struct vw_specialization *s, const double *grid, const double position[3],
                               double *encoding, uint32_t cells[VW_LEVELS_MAX][3]) {
    uint32_t features = 2 * s->feature_pairs;
    memset(encoding, 0, s->levels * features * sizeof *encoding);
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        double fraction[3];
        locate(s, position, level, cells[level], fraction);
        reference_grid_corners(s, position, level, corners);
        for (uint32_t i = 0; i < 8; i++)
            for (uint32_t f = 0; f < features; f++)
                encoding[level * features + f] += share_of(fraction, i, 0) * share_of(fraction, i, 1) *
                                                  share_of(fraction, i, 2) * grid[corners[i].first_feature + f];
    }
}

double reference_encode_back(const struct vw_specialization *s, const double *grid, const double position[3],
                             const double *d_encoding, double d_position[3]) {
    uint32_t features = 2 * s->feature_pairs;
    double size = 0.0;
    memset(d_position, 0, 3 * sizeof *d_position);
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        uint32_t cell[3];
        double fraction[3];
        locate(s, position, level, cell, fraction);
        reference_grid_corners(s, position, level, corners);
        for (uint32_t i = 0; i < 8 * features; i++) {
            uint32_t corner = i / features, f = i % features;
            double by =
                s->resolution[level] * grid[corners[corner].first_feature + f] * d_encoding[level * features + f];
            size += fabs(by);
            for (int axis = 0; axis < 3; axis++)
                d_position[axis] += (corner >> axis & 1 ? by : -by) * share_of(fraction, corner, (axis + 1) % 3) *
                                    share_of(fraction, corner, (axis + 2) % 3);
        }
    }
    return size;
}
