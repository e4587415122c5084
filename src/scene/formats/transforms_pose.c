#include <math.h>
#include <string.h>

#include "scene/builder.h"
#include "scene/determinant.h"
#include "scene/formats/transforms.h"

static const double TOLERANCE = 1e-3; // poses are often written with few digits
enum { POLAR_STEPS = 3 };             // errors from 1e-3: 1e-6, 1e-12, exact
static const double POSITION_LIMIT_WORLD = VW_POSITION_MOST_WORLD;

static enum vw_status read_matrix(const char *where, const json_t *value, double matrix[4][4]) {
    size_t rows = json_array_size(value); // 0 for anything but an array
    bool complete = rows == 3 || rows == 4;
    for (size_t i = 0; complete && i < rows; i++) {
        const json_t *row = json_array_get(value, i);
        complete = json_array_size(row) == 4;
        for (size_t j = 0; complete && j < 4; j++) {
            complete = json_is_number(json_array_get(row, j));
            matrix[i][j] = json_number_value(json_array_get(row, j));
        }
    }
    if (complete) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: field transform_matrix is missing or not 4 rows of 4 numbers; export the pose again", where);
}

// Returns the largest deviation of the columns, divided by `scale`, from orthonormality.
static double distance_from_rotation(double m[4][4], double scale) {
    double worst = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            double product = 0;
            for (int k = 0; k < 3; k++) product += m[k][i] / scale * (m[k][j] / scale);
            worst = fmax(worst, fabs(product - (i == j)));
        }
    }
    return worst;
}

// Replaces a matrix that is almost a rotation by the nearest rotation, by Newton's iteration for the polar
// decomposition: R = (R + inverse transpose of R) / 2. Otherwise, the rounding of a matrix with few digits would
// distort rays, and other exports of the same pose would give other rays.
static void make_rotation(double m[4][4], double scale) {
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) m[i][j] /= scale;
    for (int step = 0; step < POLAR_STEPS; step++) {
        double cofactors[3][3], divisor = vw_determinant(m[0], m[1], m[2]);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                int below = (i + 1) % 3, last = (i + 2) % 3, right = (j + 1) % 3, end = (j + 2) % 3;
                cofactors[i][j] = m[below][right] * m[last][end] - m[below][end] * m[last][right];
            }
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) m[i][j] = 0.5 * (m[i][j] + cofactors[i][j] / divisor);
    }
}

static enum vw_status check_matrix(const char *where, const char *field, double m[4][4], double *scale) {
    const double last_row[4] = {0, 0, 0, 1};
    for (int j = 0; j < 4; j++)
        if (fabs(m[3][j] - last_row[j]) > TOLERANCE)
            return vw_fail(VW_ERROR_INPUT, "%s: %s: last row is not 0 0 0 1; give camera to world", where, field);
    for (int i = 0; i < 3; i++)
        if (!(fabs(m[i][3]) <= POSITION_LIMIT_WORLD))
            return vw_fail(VW_ERROR_INPUT, "%s: %s: position %g is beyond %g; correct the pose", where, field, m[i][3],
                           POSITION_LIMIT_WORLD);
    *scale = cbrt(vw_determinant(m[0], m[1], m[2]));
    if (*scale < 0)
        return vw_fail(VW_ERROR_INPUT, "%s: %s: mirrored (negative determinant); give right-handed OpenGL axes", where,
                       field);
    if (!(*scale > 0 && isfinite(*scale)) || !(distance_from_rotation(m, *scale) <= TOLERANCE))
        return vw_fail(VW_ERROR_INPUT, "%s: %s: its 3 x 3 part is not a rotation; export the pose again", where, field);
    return VW_OK;
}

enum vw_status vw_pose_of_matrix(const char *where, const char *field, double matrix[4][4],
                                 double camera_to_world[3][4]) {
    double scale = 1;
    enum vw_status status = check_matrix(where, field, matrix, &scale);
    if (status) return status;
    make_rotation(matrix, scale);
    memcpy(camera_to_world, matrix, 3 * sizeof matrix[0]);
    return VW_OK;
}

enum vw_status vw_transforms_pose(const char *where, const json_t *frame, double camera_to_world[3][4]) {
    double matrix[4][4] = {[3] = {0, 0, 0, 1}};
    enum vw_status status = read_matrix(where, json_object_get(frame, "transform_matrix"), matrix);
    return status ? status : vw_pose_of_matrix(where, "field transform_matrix", matrix, camera_to_world);
}
