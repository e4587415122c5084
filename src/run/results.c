#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/run_outputs.h"
#include "run/run_private.h"
#include "value/methods.h"
#include "viewworth/value.h"

const struct vw_run_results *vw_run_get_results(const struct vw_run *run) { return &run->results; }

// Ranks the scores of each method, which are neighbours.
enum vw_status vw_run_rank(struct vw_run *run) {
    const struct vw_scoring *scoring = &run->results.scoring;
    free(run->ranked);
    run->ranked = vw_allocate(scoring->score_count, sizeof *run->ranked);
    if (!run->ranked) return VW_ERROR_MEMORY;
    if (scoring->score_count) memcpy(run->ranked, scoring->scores, scoring->score_count * sizeof *run->ranked);
    for (uint32_t first = 0, last; first < scoring->score_count; first = last) {
        for (last = first + 1; last < scoring->score_count;)
            if (strcmp(run->ranked[last].method, run->ranked[first].method) != 0) break;
            else last++;
        qsort(&run->ranked[first], last - first, sizeof *run->ranked, vw_score_compare);
    }
    return VW_OK;
}

enum vw_status vw_run_load_field(struct vw_run *run) {
    struct vw_ledger_run row;
    enum vw_status status = vw_ledger_get_run(run->ledger, &row);
    if (!status) status = vw_checksums_check_field(run->out, row.field_sha256);
    return status ? status : vw_trainer_load_field(run->trainer, run->results.field_path);
}

enum vw_status vw_run_write_scores(struct vw_run *run) {
    bool pays = run->payout_cents > 0;
    enum vw_status status = run->validate ? vw_run_scores_write(run->out, &run->results.scoring, pays)
                                          : vw_run_remove_derived(run->out, pays);
    run->written = !status;
    return status;
}

static bool is_of_method(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0;
}

enum vw_status vw_run_scores(const struct vw_run *run, const char *method, const struct vw_ledger_score **scores,
                             uint32_t *count) {
    if (!run || !run->finished)
        return vw_fail(VW_ERROR_USAGE, "vw_run_scores: the run has no scores yet; call vw_run_finish first");
    const char *wanted = method ? method : vw_value_main_method(run->ranked, run->results.scoring.score_count);
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
