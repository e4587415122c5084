#include "value/evaluation/evaluation.h"

#include <stdio.h>
#include <string.h>

#include "base/memory.h"

const char vw_reference_scorer[] = "dv_psnr";

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
