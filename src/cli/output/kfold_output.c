#include <stdlib.h>

#include "cli/output/print.h"
#include "cli/output/ranking.h"
#include "cli/output/results.h"
#include "value/methods.h"
#include "viewworth/value.h"

#define OF_FOLD(name, kind, member, heading)                                                                           \
    { VW_CELL(name, struct vw_kfold_fold, kind, member), .title = heading }
static const struct vw_column columns[] = {
    OF_FOLD("fold", COUNT, number, "fold"),
    OF_FOLD("train", COUNT, train_count, "train"),
    OF_FOLD("validation", COUNT, validation_count, "validation"),
    OF_FOLD("steps", COUNT64, steps, "steps"),
    {VW_CELL("val_psnr_start_db", struct vw_kfold_fold, REAL_OR_NULL, first_val_psnr_db),
     .title = "validation PSNR before, dB", .digits = 2},
    {VW_CELL("val_psnr_end_db", struct vw_kfold_fold, REAL_OR_NULL, last_val_psnr_db), .title = "after training",
     .digits = 2},
};

// ---- Text ----

static void print_folds(const struct vw_kfold *kfold) {
    const struct vw_rows folds = VW_ROWS(columns, kfold->folds, kfold->params->folds);
    vw_print_rows(&folds);
    if (kfold->agreement.pairs)
        vw_print("agreement of two folds on the photos that both train on: rho %.2f [%.2f %.2f]\n",
                 kfold->agreement.mean, kfold->agreement.lowest, kfold->agreement.highest);
}

static void print_text(const struct vw_kfold *kfold, const struct vw_ranking *ranking) {
    print_folds(kfold);
    vw_ranking_print(ranking, "highest credit (mean dv_psnr over folds; 95 % intervals of score and rank)",
                     "lowest credit");
    vw_print("scores   %s\nmatrix   %s\n", kfold->scores_path, kfold->matrix_path);
    if (kfold->report_path) vw_print("report   %s\n", kfold->report_path);
    vw_print("compare  viewworth compare");
    vw_print_shell_path(kfold->session.scene->path);
    vw_print(" --list all --list");
    vw_print_shell_path(kfold->list_path);
    vw_print("@0");
    if (kfold->params->common.config->field != VW_FIELD_HASH)
        vw_print(" --field %s", vw_field_name(kfold->params->common.config->field));
    vw_print(" --out ANOTHER\n");
}

// ---- JSON ----

static json_t *to_json(const struct vw_kfold *kfold, const struct vw_ranking *ranking) {
    const struct vw_rows folds = VW_ROWS(columns, kfold->folds, kfold->params->folds);
    return json_pack("{s:o, s:o, s:o, s:s, s:s, s:s, s:s*}", "folds", vw_rows_to_json(&folds), "spearman",
                     vw_json_real(kfold->agreement.mean), "photos", vw_ranking_to_json(ranking, VW_RANKING_ALL),
                     "scores", kfold->scores_path, "matrix", kfold->matrix_path, "list", kfold->list_path, "report",
                     kfold->report_path);
}

enum vw_status vw_kfold_print(const struct vw_kfold *kfold, bool json) {
    struct vw_ledger_score *scores = NULL;
    const struct vw_scene *scene = kfold->session.scene;
    struct vw_ranking ranking = {.scene = scene,
                                 .qualities = kfold->scores,
                                 .quality_count = kfold->score_count,
                                 .judge_count = scene->split_count[VW_SPLIT_TRAIN] + scene->split_count[VW_SPLIT_VAL]};
    enum vw_status status =
        vw_scores_rank(kfold->scores, kfold->score_count, vw_value_default_method, &scores, &ranking.count);
    ranking.scores = scores;
    if (!status && json) status = vw_json_print(to_json(kfold, &ranking));
    else if (!status) print_text(kfold, &ranking);
    free(scores);
    return status;
}
