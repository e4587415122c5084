// Benchmark: how well every scoring method does where ground truth is known. Some runs are valued; with other seeds,
// retrainings on random subsets of the photos, and on what removal curves leave of them, show what the scores predict.
#ifndef VIEWWORTH_LAB_BENCHMARK_H
#define VIEWWORTH_LAB_BENCHMARK_H

#include <stdbool.h>
#include <stdint.h>

#include "experiment/experiment.h"
#include "lab/evaluation/evaluation.h"
#include "lab/method_scorers.h"
#include "viewworth/status.h"

// Scorers that have removal and addition curves; VW_CURVES_GAIN: all of them, but only their point removal_low/20.
enum vw_curves {
    VW_CURVES_DEFAULT, // dv_psnr and ground_truth
    VW_CURVES_NONE,
    VW_CURVES_ALL,
    VW_CURVES_GAIN,
    VW_CURVES_LISTED
};

enum { VW_BENCHMARK_WORTHS = 6, VW_BENCHMARK_NAME_BYTES = 24 };
struct vw_benchmark_params {
    struct vw_experiment_params common; // seeds: as many runs are valued
    struct vw_method_params evaluated;
    uint32_t retraining_seeds; // seeds of each subset and of each set of a curve; these follow the valued runs' seeds
    uint32_t subsets;          // to retrain on: one half of them are halves of the photos, one of random sizes
    bool all_subsets;          // instead all subsets of at most VW_SUBSETS_ALL_PHOTOS_MAX photos
    enum vw_equal equal;       // steps or epochs, which are equal in all retrainings
    uint32_t worth_retrainings[VW_BENCHMARK_WORTHS]; // worth from so many retrainings of its own is a method, too
    uint32_t worth_count;
    bool leave_one_out; // also retrain without each photo, with the larger of both numbers of seeds
    enum vw_curves curves;
    const char *curve_scorers; // with VW_CURVES_LISTED: names with commas between
};

struct vw_benchmark_method {
    const char *name; // lives as long as the benchmark
    // Cost of one set of its scores:
    double trainings; // run-equivalents
    double seconds;   // CPU time; NaN: unknown
};

struct vw_benchmark {
    const struct vw_benchmark_params *params; // borrowed
    struct vw_benchmark_method *methods;      // owned
    uint32_t method_count;
    uint32_t photo_count, half_count, size_count; // subsets of either kind; with all subsets, size_count is of all
    uint32_t truth_epochs;                        // the truth is a mean over the ends of so many epochs
    bool has_tests;                               // the scene has test photos
    struct vw_metrics metrics;                    // rows are owned
    double training_seconds;                      // CPU time of a training on all photos; NaN: unknown
    char *csv_path;                               // owned
    char worth_names[VW_BENCHMARK_WORTHS][VW_BENCHMARK_NAME_BYTES]; // "worth_24"
    char (*method_names)[VW_METHOD_NAME_BYTES];                     // owned
};

// Makes the benchmark, or resumes it. Writes to OUT: seed_<seed>/ (experiment/experiment.h), retrainings.db, and the
// files of benchmark_files.h. VW_ERROR_USAGE names a wrong option. Free the result also after a failure.
enum vw_status vw_benchmark_make(const struct vw_benchmark_params *params, struct vw_benchmark *benchmark);
void vw_benchmark_free(struct vw_benchmark *benchmark);

#endif
