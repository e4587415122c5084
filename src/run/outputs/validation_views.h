// The part of validation photos in the scores: the matrix, how far the ranking depends on each, and which look wrong.
#ifndef VIEWWORTH_RUN_OUTPUTS_VALIDATION_VIEWS_H
#define VIEWWORTH_RUN_OUTPUTS_VALIDATION_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "run/outputs/checksums.h"
#include "run/scoring.h"
#include "scene/view_distance.h"
#include "value/matrix.h"
#include "value/ranking_agreement.h"

struct vw_validation_views {
    const struct vw_scene *scene; // borrowed
    struct vw_matrix matrix;
    struct vw_ranking_agreement agreement;
    struct vw_view_evidence *views; // one per column
    double *standard_errors;        // one per row
    struct vw_view_distance *distances;
    uint32_t distance_count;
    char *matrix_path; // owned
};

// Computes everything, writes OUT/matrix.csv where there are validated steps after burn-in, and warns of validation
// views that look corrupted or lie far from every training view. Notes the file in `made`. Free it also after a
// failure.
enum vw_status vw_validation_views_make(const struct vw_scene *scene, struct vw_ledger *ledger,
                                        const struct vw_scoring *scoring, const char *out, struct vw_checksums *made,
                                        struct vw_validation_views *validation);
// Returns the name of a view of the scene.
const char *vw_validation_views_name(const struct vw_validation_views *validation, uint32_t view);
// Returns whether there are validated steps after burn-in.
bool vw_validation_views_have_matrix(const struct vw_validation_views *validation);
void vw_validation_views_free(struct vw_validation_views *validation);

#endif
