// The determinant of a matrix of 3 rows and 3 columns.
#ifndef VIEWWORTH_SCENE_DETERMINANT_H
#define VIEWWORTH_SCENE_DETERMINANT_H

// Returns the determinant of the first three numbers of the rows x, y and z.
static inline double vw_determinant(const double *x, const double *y, const double *z) {
    return x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
}

#endif
