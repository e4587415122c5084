#include "lab/methods/optimal_transport.h"

#include <math.h>
#include <stddef.h>

enum { ROUNDS_MOST = 20000 };
static const double MASS_ERROR_MOST = 1e-9;
static const double COOLING = 0.5; // factor of the temperature, from the largest cost down

static double mass_of(const double *masses, uint32_t count, uint32_t place) {
    return masses ? masses[place] : 1.0 / count;
}

// One side of the problem as the other side sees it.
struct side {
    const double *costs;
    size_t own_stride, other_stride; // costs[own * own_stride + other * other_stride]
    const double *own_masses, *other_masses, *other_potentials;
    uint32_t own_count, other_count;
};

// Returns -temperature log(sum over others of mass exp((potential - cost) / temperature)): the potential that gives the
// place its mass.
static double soft_minimum(const struct side *side, uint32_t own, double temperature) {
    const double *costs = side->costs + own * side->own_stride;
    double best = INFINITY, sum = 0;
    for (uint32_t i = 0; i < side->other_count; i++)
        best = fmin(best, costs[i * side->other_stride] - side->other_potentials[i]);
    for (uint32_t i = 0; i < side->other_count; i++)
        sum += mass_of(side->other_masses, side->other_count, i) *
               exp((best - costs[i * side->other_stride] + side->other_potentials[i]) / temperature);
    return best - temperature * log(sum);
}

// Gives every place its mass. Returns by how much the masses were wrong.
static double balance(const struct side *side, double temperature, double *potentials) {
    double wrong = 0;
    for (uint32_t i = 0; i < side->own_count; i++) {
        double right = soft_minimum(side, i, temperature);
        wrong += mass_of(side->own_masses, side->own_count, i) * fabs(exp((potentials[i] - right) / temperature) - 1);
        potentials[i] = right;
    }
    return wrong;
}

bool vw_transport_solve(const struct vw_transport *transport, double *sources, double *targets) {
    uint32_t rows = transport->source_count, columns = transport->target_count;
    const struct side of_sources = {transport->costs,         columns, 1,    transport->source_masses,
                                    transport->target_masses, targets, rows, columns};
    const struct side of_targets = {transport->costs,         1,       columns, transport->target_masses,
                                    transport->source_masses, sources, columns, rows};
    double temperature = transport->temperature;
    for (size_t i = 0; i < (size_t)rows * columns; i++) temperature = fmax(temperature, transport->costs[i]);
    for (uint32_t i = 0; i < rows; i++) sources[i] = 0;
    for (uint32_t i = 0; i < columns; i++) targets[i] = 0;
    bool converged = false;
    for (uint32_t round = 0; !converged && round < ROUNDS_MOST; round++) {
        balance(&of_targets, temperature, targets);
        bool right = balance(&of_sources, temperature, sources) <= MASS_ERROR_MOST;
        converged = right && temperature == transport->temperature;
        temperature = fmax(COOLING * temperature, transport->temperature); // the rounds at the last one decide
    }
    return converged;
}

void vw_transport_calibrate(const double *sources, uint32_t count, double *gradients) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += sources[i];
    for (uint32_t i = 0; i < count; i++) gradients[i] = count > 1 ? sources[i] - (sum - sources[i]) / (count - 1) : 0;
}
