#include "lab/evaluation/evaluation.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/memory.h"

const char vw_reference_scorer[] = "dv_psnr";
const enum vw_outcome vw_truths[VW_TRUTH_COUNT] = {VW_OUTCOME_VAL_PSNR, VW_OUTCOME_TEST_PSNR};
const char vw_noise_ceiling_name[] = "noise ceiling", vw_chance_name[] = "chance";

enum vw_status vw_metrics_add(struct vw_metrics *metrics, const char *group, const char *name, struct vw_metric row) {
    enum vw_status status =
        vw_grow((void **)&metrics->rows, &metrics->capacity, metrics->count + 1, sizeof *metrics->rows);
    if (status) return status;
    snprintf(row.metric, sizeof row.metric, "%s/%s", group, name);
    metrics->rows[metrics->count++] = row;
    return VW_OK;
}

const struct vw_metric *vw_metrics_find(const struct vw_metrics *metrics, const char *group, const char *name,
                                        const char *method) {
    char metric[VW_METRIC_BYTES];
    snprintf(metric, sizeof metric, "%s/%s", group, name);
    for (size_t i = 0; i < metrics->count; i++)
        if (!strcmp(metrics->rows[i].metric, metric) && !strcmp(metrics->rows[i].method, method))
            return &metrics->rows[i];
    return NULL;
}

const struct vw_scorer *vw_find_scorer(const struct vw_evaluation *evaluation, const char *name) {
    for (uint32_t i = 0; i < evaluation->scorer_count; i++)
        if (!strcmp(evaluation->scorers[i].name, name)) return &evaluation->scorers[i];
    return NULL;
}

void vw_mean_of_rows(const double *values, uint32_t row_count, uint32_t column_count, double *means) {
    for (uint32_t i = 0; i < column_count; i++) {
        means[i] = 0;
        for (uint32_t row = 0; row < row_count; row++) means[i] += values[(size_t)row * column_count + i] / row_count;
    }
}

void vw_mean_over_seeds(const struct vw_evaluation *evaluation, const double *scores, double *means) {
    vw_mean_of_rows(scores, evaluation->seed_count, evaluation->photo_count, means);
}
