// The files that a benchmark writes to OUT. They contain no times, so that equal benchmarks give equal files.
#ifndef VIEWWORTH_LAB_BENCHMARK_FILES_H
#define VIEWWORTH_LAB_BENCHMARK_FILES_H

#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/exact_values.h"
#include "lab/methods/photo_features.h"
#include "value/evaluation/worth_regression.h"
#include "viewworth/scene.h"

// Writes the file `path`, header scene,metric,method,value,ci_low,ci_high,count: a row per metric.
enum vw_status vw_benchmark_write_metrics(const char *path, const char *scene, const struct vw_metrics *metrics);
// The photos that are valued: views of the scene.
struct vw_benchmark_photos {
    const struct vw_scene *scene;
    const uint32_t *views;
};
// Writes worths.csv, header name,worth_db,ci_low,ci_high,test_worth_db,test_ci_low,test_ci_high: a row per photo with
// its worths by validation and by test photos, empty if they are unknown. `worths`: one per truth.
enum vw_status vw_benchmark_write_worths(const char *out, const struct vw_benchmark_photos *photos,
                                         const struct vw_worths *worths);
// Writes exact.csv, header
// name,shapley_db,banzhaf_db,leave_one_out_db,test_shapley_db,test_banzhaf_db,test_leave_one_out_db: a row per photo
// with its exact values by validation and by test photos, means over the retraining seeds.
enum vw_status vw_benchmark_write_exact(const char *out, const struct vw_benchmark_photos *photos,
                                        const struct vw_exact_values *exact);
// Writes photo_features.csv, header name,seed and the names of methods/photo_features.h: a row per valued seed and
// photo, empty if a feature is unknown.
enum vw_status vw_benchmark_write_features(const char *out, const struct vw_benchmark_photos *photos,
                                           uint64_t first_seed, const struct vw_photo_features *features);

#endif
