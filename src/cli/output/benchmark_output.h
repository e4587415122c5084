// What a benchmark found: as a table on stdout, as JSON, and as OUT/benchmark.csv.
#ifndef VIEWWORTH_CLI_BENCHMARK_OUTPUT_H
#define VIEWWORTH_CLI_BENCHMARK_OUTPUT_H

#include "experiment/scorers.h"
#include "value/evaluation/evaluation.h"

struct vw_benchmark_output {
    const char *scene; // as the command line names it
    const struct vw_scorers *scorers;
    const struct vw_metrics *metrics;
    uint32_t subset_count;
    double training_seconds; // CPU time of a training on all photos; NaN when unknown
    const char *csv_path;
};

// Header scene,metric,method,value,ci_low,ci_high,count; a row per metric, in their order. It holds no times, so that
// equal benchmarks give equal files.
enum vw_status vw_benchmark_write_csv(const struct vw_benchmark_output *output);
void vw_benchmark_print(const struct vw_benchmark_output *output);
enum vw_status vw_benchmark_print_json(const struct vw_benchmark_output *output);

#endif
