// The passes of the effect appearance_encoder held against the reference, in a step of a bench.
#ifndef VIEWWORTH_TESTS_SUPPORT_ENCODER_CHECK_H
#define VIEWWORTH_TESTS_SUPPORT_ENCODER_CHECK_H

#include "hard_cases/hard_case.h"
#include "reference/step_bench.h"

// Returns the network's numbers in double, from a params block in floats.
double *encoder_network(const struct step_bench *bench, const float *params);
// Encodes by the reference the thumbnail of `view` that the device holds.
struct reference_photo_encoding *encoder_reference(struct step_bench *bench, const double *network, uint32_t view);
// Runs step `number` up to the gradients, and holds what the network gives, and its gradient by that of the colour
// network's weights, against the reference. All must be finite.
void encoder_check(struct hard_finding *finding, struct step_bench *bench, uint64_t number);

#endif
