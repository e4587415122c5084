#include "report/results.h"

#include <stdlib.h>

#include "base/memory.h"

bool vw_results_have_matrix(const struct vw_results *results) {
    return results->matrix.view_count > 0 && results->matrix.visit_count > 0;
}

enum vw_status vw_results_measure(struct vw_ledger *ledger, struct vw_results *results) {
    struct vw_matrix *matrix = &results->matrix;
    enum vw_status status = vw_value_matrix(ledger, &results->input, matrix);
    if (!status)
        status = vw_ranking_agreement_measure(&results->input, matrix, results->scores, results->score_count,
                                              &results->agreement);
    if (status) return status;
    results->views = vw_allocate(matrix->view_count, sizeof *results->views);
    results->standard_errors = vw_allocate(matrix->photo_count, sizeof *results->standard_errors);
    if (!results->views || !results->standard_errors) return VW_ERROR_MEMORY;
    return vw_results_have_matrix(results) ? vw_matrix_jackknife(matrix, results->views, results->standard_errors)
                                           : VW_OK;
}

void vw_results_free(struct vw_results *results) {
    vw_matrix_clear(&results->matrix);
    free(results->advice.photos);
    free(results->findings);
    free(results->views);
    free(results->standard_errors);
    json_decref(results->map);
    json_decref(results->residuals);
    json_decref(results->next);
    *results = (struct vw_results){0};
}
