// The results of the laboratory's commands on stdout, as tables or as one JSON object: VW_ERROR_MEMORY, or VW_ERROR_IO
// when stdout cannot be written.
#ifndef VIEWWORTH_LAB_OUTPUT_RESULTS_H
#define VIEWWORTH_LAB_OUTPUT_RESULTS_H

#include <jansson.h>
#include <stdbool.h>

#include "lab/benchmark.h"
#include "lab/lasting_seeds.h"
#include "lab/reproduction.h"

enum vw_status vw_benchmark_print(const struct vw_benchmark *benchmark, bool json);
enum vw_status vw_reproduction_print(const struct vw_reproduction *reproduction, bool json);

// Prints the photos at both ends, and which are told apart. `first_seed`: seed of the first of seeds->gates.
void vw_lasting_seeds_print(const struct vw_lasting_seeds *seeds, uint64_t first_seed);
json_t *vw_lasting_seeds_to_json(const struct vw_lasting_seeds *seeds); // NULL when memory is short

#endif
