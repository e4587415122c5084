// Entropic optimal transport between two small distributions (Sinkhorn's algorithm in the log domain, with a falling
// temperature: Peyre and Cuturi, "Computational optimal transport", 2019, 4.2 and 4.4). In double, deterministic.
#ifndef VIEWWORTH_LAB_METHODS_OPTIMAL_TRANSPORT_H
#define VIEWWORTH_LAB_METHODS_OPTIMAL_TRANSPORT_H

#include <stdbool.h>
#include <stdint.h>

struct vw_transport {
    const double *costs; // [source][target], finite
    uint32_t source_count, target_count;
    const double *source_masses, *target_masses; // > 0, either sum is 1; NULL: equal ones
    double temperature;                          // > 0, in units of the costs: the weight of the plan's entropy
};

// Finds the dual potentials at that temperature: sums of masses times potentials approach the cost of the best plan,
// and sources[i] + targets[j] a lower bound of costs[i][j], as the temperature falls. Returns false if 20,000 rounds
// were too few for a plan whose masses are right to 1e-9 in sum: the potentials are then those of the last round.
bool vw_transport_solve(const struct vw_transport *transport, double *sources, double *targets);

// Computes calibrated gradients (Just et al., "LAVA", ICLR 2023): gradients[i] = sources[i] - the mean of the others.
// This is the rise of the cost of transport with the mass of source i, which is taken from all others. 0 for a single
// source.
void vw_transport_calibrate(const double *sources, uint32_t count, double *gradients);

#endif
