#include "reference/reference.h"

#include <math.h>

void reference_contract(const double box[3], double field[3]) {
    double q[3], length, by = 1.0;
    for (int i = 0; i < 3; i++) q[i] = 2.0 * box[i] - 1.0;
    length = hypot(hypot(q[0], q[1]), q[2]);
    if (length > 1.0) by = (2.0 - 1.0 / length) / length;
    for (int i = 0; i < 3; i++) field[i] = by * q[i] / 4.0 + 0.5;
}
