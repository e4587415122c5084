// Lasting credit of several seeds, as text and JSON.
#ifndef VIEWWORTH_LAB_OUTPUT_LASTING_SEEDS_OUTPUT_H
#define VIEWWORTH_LAB_OUTPUT_LASTING_SEEDS_OUTPUT_H

#include <jansson.h>

#include "lab/lasting_seeds.h"

// Prints the photos at both ends, and which are told apart. `first_seed`: seed of the first of seeds->gates.
void vw_lasting_seeds_print(const struct vw_lasting_seeds *seeds, uint64_t first_seed);
json_t *vw_lasting_seeds_to_json(const struct vw_lasting_seeds *seeds);

#endif
