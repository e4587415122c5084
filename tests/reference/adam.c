#include "reference.h"

#include <math.h>

double reference_adam(const struct vw_specialization *s, double gradient, uint64_t visits, double *moment1,
                      double *moment2) {
    if (s->optimizer == OPTIMIZER_SGD) return s->learning_rate * gradient;
    double epsilon = (double)s->gradient_quantum * s->inverse_rays; // one quantum of the mean gradient
    double beta1 = s->momentum ? s->beta1 : 0.0, beta2 = s->beta2;
    *moment1 = beta1 * *moment1 + (1.0 - beta1) * gradient;
    *moment2 = beta2 * *moment2 + (1.0 - beta2) * gradient * gradient;
    double mean = *moment1 / (1.0 - pow(beta1, (double)visits)), square = *moment2 / (1.0 - pow(beta2, (double)visits));
    return s->learning_rate * mean / (sqrt(square) + epsilon);
}
