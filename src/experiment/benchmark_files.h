// The files that a benchmark writes to OUT. They hold no times, so that equal benchmarks give equal files.
#ifndef VIEWWORTH_BENCHMARK_FILES_H
#define VIEWWORTH_BENCHMARK_FILES_H

#include "value/evaluation/worth_regression.h"
#include "viewworth/scene.h"

// The file `path`, header scene,metric,method,value,ci_low,ci_high,count: a row per metric.
enum vw_status vw_benchmark_write_metrics(const char *path, const char *scene, const struct vw_metrics *metrics);
// worths.csv, header name,worth_db,ci_low,ci_high,test_worth_db,test_ci_low,test_ci_high: a row per photo (`photos`:
// views of the scene) with its worths by validation and by test photos, empty where they are unknown. `worths`: one per
// truth.
enum vw_status vw_benchmark_write_worths(const char *out, const struct vw_scene *scene, const uint32_t *photos,
                                         const struct vw_worths *worths);

#endif
