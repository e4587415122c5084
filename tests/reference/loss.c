#include "reference.h"

#include <math.h>

double reference_loss(uint32_t loss, double error, double *slope) {
    static const double huber_edge = 0.1;
    double sign = error > 0.0 ? 1.0 : error < 0.0 ? -1.0 : 0.0;
    if (loss == LOSS_L2) {
        *slope = 2.0 * error;
        return error * error;
    }
    if (loss == LOSS_HUBER && fabs(error) < huber_edge) {
        *slope = error / huber_edge;
        return error * error / (2.0 * huber_edge);
    }
    *slope = sign;
    return fabs(error) - (loss == LOSS_HUBER ? huber_edge / 2.0 : 0.0);
}

double reference_curvature(const struct vw_specialization *s, double error) {
    double edge = s->loss == LOSS_HUBER ? 0.1 : 0.05;
    return s->loss == LOSS_L2 ? 2.0 : 1.0 / (edge * pow(1.0 + error * error / (edge * edge), 1.5));
}
