// Distances between points, lines and the box, in box coordinates, where the box is the unit cube.
#ifndef VIEWWORTH_TESTS_SUPPORT_BOX_GEOMETRY_H
#define VIEWWORTH_TESTS_SUPPORT_BOX_GEOMETRY_H

#include <math.h>

static inline double distance(const double a[3], const double b[3]) {
    return sqrt(pow(a[0] - b[0], 2.0) + pow(a[1] - b[1], 2.0) + pow(a[2] - b[2], 2.0));
}

// Returns the distance of a point to a line whose `direction` has unit length.
static inline double distance_to_line(const double point[3], const double origin[3], const double direction[3]) {
    double along = 0.0, foot[3];
    for (int i = 0; i < 3; i++) along += (point[i] - origin[i]) * direction[i];
    for (int i = 0; i < 3; i++) foot[i] = origin[i] + along * direction[i];
    return distance(point, foot);
}

// Returns the distance of a point to the box's surface, inside or outside.
static inline double distance_to_face(const double point[3]) {
    double outside = 0.0, inside = 1.0;
    for (int i = 0; i < 3; i++) {
        outside = fmax(outside, fmax(-point[i], point[i] - 1.0));
        inside = fmin(inside, fmax(fmin(point[i], 1.0 - point[i]), 0.0));
    }
    return fmax(outside, inside);
}

#endif
