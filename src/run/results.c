// What a run tells of itself once it is open, and of its scores once it is finished.
#include "run/run_private.h"

#include <string.h>

#include "viewworth/value.h"

const struct vw_run_results *vw_run_get_results(const struct vw_run *run) { return &run->results; }

static bool is_of_method(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0;
}

enum vw_status vw_run_scores(const struct vw_run *run, const char *method, const struct vw_ledger_score **scores,
                             uint32_t *count) {
    if (!run || !run->finished)
        return vw_fail(VW_ERROR_USAGE, "vw_run_scores: the run has no scores yet; call vw_run_finish first");
    const char *wanted = method ? method : vw_value_default_method;
    uint32_t first = 0, end;
    while (first < run->results.scoring.score_count && !is_of_method(&run->ranked[first], wanted)) first++;
    for (end = first; end < run->results.scoring.score_count && is_of_method(&run->ranked[end], wanted);) end++;
    *scores = &run->ranked[first];
    *count = end - first;
    return VW_OK;
}

enum vw_status vw_run_images(const struct vw_run *run, const struct vw_ledger_image **images, uint32_t *count) {
    if (!run || !run->ledger)
        return vw_fail(VW_ERROR_USAGE, "vw_run_images: the run has no ledger yet; call vw_run_advance first");
    return vw_ledger_get_images(run->ledger, images, count);
}
