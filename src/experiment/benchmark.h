// Benchmark: how well every scoring method does where ground truth is known. Two runs are valued; with other seeds,
// retrainings on random halves of the photos, and on what removal curves leave of them, show what the scores predict.
#ifndef VIEWWORTH_BENCHMARK_H
#define VIEWWORTH_BENCHMARK_H

#include <stdbool.h>
#include <stdint.h>

#include "experiment/experiment.h"
#include "value/evaluation/evaluation.h"
#include "viewworth/status.h"

// Which scorers have removal and addition curves.
enum vw_curves { VW_CURVES_DEFAULT, VW_CURVES_NONE, VW_CURVES_ALL, VW_CURVES_LISTED }; // dv_psnr and ground_truth

struct vw_benchmark_params {
    struct vw_experiment_params common; // seeds is ignored: two runs are valued, and six seeds used in all
    uint32_t subsets;                   // random halves of the photos, each trained on with two seeds
    bool leave_one_out;                 // also retrain without each photo, with two seeds
    enum vw_curves curves;
    const char *curve_scorers; // with VW_CURVES_LISTED: names with commas between
};

struct vw_benchmark_method {
    const char *name;   // static
    uint32_t trainings; // that one set of its scores takes
};

struct vw_benchmark {
    const struct vw_benchmark_params *params; // borrowed
    struct vw_benchmark_method *methods;      // owned
    uint32_t method_count;
    uint32_t photo_count, subset_count;
    struct vw_metrics metrics; // rows are owned
    double training_seconds;   // CPU time of a training on all photos; NaN: unknown
    char *csv_path;            // owned
};

// Makes the benchmark, or resumes it. Writes to OUT: seed_<seed>/ (seed_runs.h), retrainings.db, and benchmark.csv with
// the header scene,metric,method,value,ci_low,ci_high,count and a row per metric. benchmark.csv holds no times, so that
// equal benchmarks give equal files. VW_ERROR_USAGE names a wrong option. Free the result also after a failure.
enum vw_status vw_benchmark_make(const struct vw_benchmark_params *params, struct vw_benchmark *benchmark);
void vw_benchmark_free(struct vw_benchmark *benchmark);

#endif
