#include "reference.h"

#include <math.h>

double reference_loss(const struct vw_specialization *s, double error, double *slope) {
    double huber_length = s->huber_length;
    double sign = error > 0.0 ? 1.0 : error < 0.0 ? -1.0 : 0.0;
    if (s->loss == LOSS_L2) {
        *slope = 2.0 * error;
        return error * error;
    }
    if (s->loss == LOSS_HUBER && fabs(error) < huber_length) {
        *slope = error / huber_length;
        return error * error / (2.0 * huber_length);
    }
    *slope = sign;
    return fabs(error) - (s->loss == LOSS_HUBER ? huber_length / 2.0 : 0.0);
}

double reference_curvature(const struct vw_specialization *s, double error) {
    double edge = s->loss == LOSS_HUBER ? s->huber_length : 0.05;
    return s->loss == LOSS_L2 ? 2.0 : 1.0 / (edge * pow(1.0 + error * error / (edge * edge), 1.5));
}
