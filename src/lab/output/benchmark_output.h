// The result of `viewworth benchmark` on stdout, as tables or as one JSON object.
#ifndef VIEWWORTH_LAB_OUTPUT_BENCHMARK_OUTPUT_H
#define VIEWWORTH_LAB_OUTPUT_BENCHMARK_OUTPUT_H

#include <stdbool.h>

#include "lab/benchmark.h"
#include "viewworth/status.h"

// Prints the benchmark. Returns VW_ERROR_MEMORY, or VW_ERROR_IO when the JSON cannot be written to stdout.
enum vw_status vw_benchmark_print(const struct vw_benchmark *benchmark, bool json);

#endif
