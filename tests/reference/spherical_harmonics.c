#include "reference.h"

#include <math.h>

void reference_spherical_harmonics(const double direction[3], double values[9]) {
    double x = direction[0], y = direction[1], z = direction[2];
    double band1 = sqrt(3.0 / (4.0 * M_PI)), band2 = sqrt(15.0 / (4.0 * M_PI));
    values[0] = sqrt(1.0 / (4.0 * M_PI));
    values[1] = -band1 * y;
    values[2] = band1 * z;
    values[3] = -band1 * x;
    values[4] = band2 * x * y;
    values[5] = -band2 * y * z;
    values[6] = sqrt(5.0 / (16.0 * M_PI)) * (3.0 * z * z - 1.0);
    values[7] = -band2 * x * z;
    values[8] = 0.5 * band2 * (x * x - y * y);
}
