// What the scores owe to the validation views: the matrix, how far the ranking hangs on one of them, and which of them
// look wrong.
#ifndef VIEWWORTH_VALIDATION_REPORT_H
#define VIEWWORTH_VALIDATION_REPORT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/scoring.h"
#include "run/training_run.h"
#include "value/matrix.h"
#include "scene/view_distance.h"

struct vw_validation_report {
    const struct vw_scene *scene; // borrowed
    struct vw_matrix matrix;
    struct vw_view_evidence *views; // of each column
    double *standard_errors;        // of each row
    struct vw_view_distance *distances;
    uint32_t distance_count;
    char *matrix_path; // owned
};

// Works it out, writes matrix.csv where there are validated steps after burn-in, and warns of validation views that
// look corrupted or lie far from every training view. Free it also after a failure.
enum vw_status vw_validation_report_make(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                         struct vw_validation_report *report);
void vw_validation_report_print(const struct vw_validation_report *report);
// Adds matrix and validation_views to `root`; false when memory is short.
bool vw_validation_report_add_json(const struct vw_validation_report *report, json_t *root);
void vw_validation_report_free(struct vw_validation_report *report);

#endif
