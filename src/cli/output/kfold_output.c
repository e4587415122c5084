#include "cli/output/kfold_output.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/output/json_output.h"
#include "cli/output/print.h"
#include "value/methods.h"
#include "viewworth/value.h"

enum { SHOWN_AT_EACH_END = 5 };

// The pooled scores of vw_value_default_method, best first.
struct ranking {
    struct vw_ledger_score *scores; // owned
    uint32_t count;
};

// ---- Text ----

static double quality_of(const struct vw_kfold *kfold, uint32_t image_id) {
    for (uint32_t i = 0; i < kfold->score_count; i++)
        if (kfold->scores[i].image_id == image_id && !strcmp(kfold->scores[i].method, "quality"))
            return kfold->scores[i].value;
    return NAN;
}

static void print_photo(const struct vw_kfold *kfold, const struct vw_ledger_score *score) {
    const struct vw_view *view = &kfold->session.scene->views[score->image_id];
    vw_print("  %+9" VW_SCORE_DIGITS "f ", score->value);
    if (isfinite(score->ci_low))
        vw_print("[%+9" VW_SCORE_DIGITS "f, %+9" VW_SCORE_DIGITS "f] ", score->ci_low, score->ci_high);
    vw_print("%s", score->unit);
    if (score->rank_ci_low) vw_print("  rank %u-%u", score->rank_ci_low, score->rank_ci_high);
    double quality = quality_of(kfold, score->image_id);
    if (isfinite(quality)) vw_print("  quality %.2f", quality);
    vw_print("  %s", view->name);
    if (view->ground_truth) vw_print(" (%s)", view->ground_truth);
    vw_print("\n");
}

static void print_folds(const struct vw_kfold *kfold) {
    vw_print("fold  train  validation  steps   validation PSNR, dB: before, after training\n");
    for (uint32_t k = 0; k < kfold->params->folds; k++) {
        const struct vw_kfold_fold *fold = &kfold->folds[k];
        vw_print("%4u  %5u  %10u  %-6" PRIu64 "  %.2f  %.2f\n", k + 1, fold->train_count, fold->validation_count,
                 fold->steps, fold->first_val_psnr_db, fold->last_val_psnr_db);
    }
    if (kfold->agreement.pairs)
        vw_print("two folds rank the photos that both train on alike: rho %.3f [%.3f %.3f]\n", kfold->agreement.mean,
                 kfold->agreement.lowest, kfold->agreement.highest);
}

static void print_text(const struct vw_kfold *kfold, const struct ranking *ranking) {
    uint32_t half = ranking->count / 2, shown = half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END;
    print_folds(kfold);
    vw_print("highest credit (mean %s over folds; 95 %% intervals of score and rank)\n", vw_value_default_method);
    for (uint32_t i = 0; i < shown; i++) print_photo(kfold, &ranking->scores[i]);
    vw_print("lowest credit\n");
    for (uint32_t i = 0; i < shown; i++) print_photo(kfold, &ranking->scores[ranking->count - 1 - i]);
    vw_print("scores   %s\nmatrix   %s\n", kfold->scores_path, kfold->matrix_path);
    if (kfold->report_path) vw_print("report   %s\n", kfold->report_path);
    vw_print("compare  viewworth compare");
    vw_print_shell_path(kfold->session.scene->path);
    vw_print(" --list all --list");
    vw_print_shell_path(kfold->list_path);
    vw_print("@0 --out ANOTHER\n");
}

// ---- JSON ----

static json_t *score_to_json(const struct vw_kfold *kfold, const struct vw_ledger_score *score) {
    const struct vw_view *view = &kfold->session.scene->views[score->image_id];
    return json_pack("{s:s, s:s?, s:s, s:o, s:s, s:o, s:o, s:o, s:I, s:I, s:I, s:o}", "name", view->name,
                     "ground_truth", view->ground_truth, "method", score->method, "value", vw_json_real(score->value),
                     "unit", score->unit, "stderr", vw_json_real(score->standard_error), "ci_low",
                     vw_json_real(score->ci_low), "ci_high", vw_json_real(score->ci_high), "rank_ci_low",
                     (json_int_t)score->rank_ci_low, "rank_ci_high", (json_int_t)score->rank_ci_high, "visits",
                     (json_int_t)score->visits, "quality", vw_json_real(quality_of(kfold, score->image_id)));
}

static json_t *folds_to_json(const struct vw_kfold *kfold) {
    json_t *array = json_array();
    for (uint32_t k = 0; k < kfold->params->folds; k++) {
        const struct vw_kfold_fold *fold = &kfold->folds[k];
        vw_json_append(&array,
                       json_pack("{s:I, s:I, s:I, s:o, s:o}", "train", (json_int_t)fold->train_count, "validation",
                                 (json_int_t)fold->validation_count, "steps", (json_int_t)fold->steps,
                                 "val_psnr_start_db", vw_json_real(fold->first_val_psnr_db), "val_psnr_end_db",
                                 vw_json_real(fold->last_val_psnr_db)));
    }
    return array;
}

static json_t *to_json(const struct vw_kfold *kfold, const struct ranking *ranking) {
    json_t *photos = json_array();
    for (uint32_t i = 0; i < ranking->count; i++) vw_json_append(&photos, score_to_json(kfold, &ranking->scores[i]));
    return json_pack("{s:o, s:o, s:o, s:s, s:s, s:s, s:s*}", "folds", folds_to_json(kfold), "spearman",
                     vw_json_real(kfold->agreement.mean), "photos", photos, "scores", kfold->scores_path, "matrix",
                     kfold->matrix_path, "list", kfold->list_path, "report", kfold->report_path);
}

enum vw_status vw_kfold_print(const struct vw_kfold *kfold, bool json) {
    struct ranking ranking;
    enum vw_status status =
        vw_scores_rank(kfold->scores, kfold->score_count, vw_value_default_method, &ranking.scores, &ranking.count);
    if (!status && json) status = vw_json_print(to_json(kfold, &ranking));
    else if (!status) print_text(kfold, &ranking);
    free(ranking.scores);
    return status;
}
