// What a run tells of itself once it is open, and of its scores once it is finished.
#include "run/run_private.h"

#include <stdio.h>
#include <string.h>

#include "viewworth/value.h"

void vw_run_get_results(const struct vw_run *run, struct vw_run_results *results) {
    *results = (struct vw_run_results){
        .out = run->out,
        .ledger_path = run->ledger_path,
        .scores_path = run->scores_path,
        .field_path = run->field_path,
        .report_path = run->report_path,
        .device = vw_gpu_get_info(run->gpu),
        .scene = run->scene,
        .config = &run->config,
        .effects = run->effects,
        .effect_count = run->effect_count,
        .statistics = &run->statistics,
        .plan = run->plan.record ? &run->plan : NULL,
        .until_stable = run->until_stable,
        .stability = &run->stability,
        .profile = run->profile.row_count ? &run->profile : NULL,
        .noise_floor = &run->scoring.noise_floor,
        .probe_costs = &run->probe_costs,
        .attribution = &run->attribution,
        .validation = &run->validation,
        .lasting = run->summary.sweep.step_count ? &run->summary : NULL,
    };
    struct vw_ledger_run row;
    if (!run->ledger) return;
    vw_ledger_chain_head(run->ledger, results->head);
    if (!vw_ledger_get_run(run->ledger, &row)) snprintf(results->run_id, sizeof results->run_id, "%s", row.run_id);
}

static bool is_of_method(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0;
}

enum vw_status vw_run_scores(const struct vw_run *run, const char *method, const struct vw_ledger_score **scores,
                             uint32_t *count) {
    if (!run || !run->finished)
        return vw_fail(VW_ERROR_USAGE, "vw_run_scores: the run has no scores yet; call vw_run_finish first");
    const char *wanted = method ? method : vw_value_default_method;
    uint32_t first = 0, end;
    while (first < run->scoring.score_count && !is_of_method(&run->ranked[first], wanted)) first++;
    for (end = first; end < run->scoring.score_count && is_of_method(&run->ranked[end], wanted);) end++;
    *scores = &run->ranked[first];
    *count = end - first;
    return VW_OK;
}
