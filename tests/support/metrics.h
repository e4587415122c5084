// The metrics that a test of the laboratory evaluates, and what it expects of them. For programs whose tests begin with
// an empty list and free its rows.
#ifndef VIEWWORTH_TESTS_SUPPORT_METRICS_H
#define VIEWWORTH_TESTS_SUPPORT_METRICS_H

#include "support/cmocka_test.h"

#include "lab/evaluation/evaluation.h"

static struct vw_metrics metrics;

static inline const struct vw_metric *find_metric(const char *group, const char *name, const char *method) {
    const struct vw_metric *row = vw_metrics_find(&metrics, group, name, method);
    if (!row) fail_msg("no row %s/%s of %s", group, name, method);
    return row;
}

static inline void assert_metric(const char *group, const char *name, const char *method, double expected,
                                 double tolerance) {
    double value = find_metric(group, name, method)->value;
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%s/%s of %s is %.17g, not %.17g", group, name, method, value, expected);
}

#endif
