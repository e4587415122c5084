#include "lab/evaluation/sweep_evaluation.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/subset_trainings.h"

enum { RETRAINING_SEEDS = 2 }; // trainings of each half

static enum vw_status train(void *context, struct vw_retrainer *retrainer, uint64_t first_seed) {
    struct vw_sweep_evaluation *of = context;
    if (!of->halves) return VW_OK;
    const struct vw_subsets_params params = {
        .photo_count = retrainer->train_count, .halves = of->halves, .seed_count = RETRAINING_SEEDS};
    enum vw_status status = vw_subsets_draw(&params, &of->subsets);
    if (status) return status;
    retrainer->planned = (uint64_t)of->subsets.count * RETRAINING_SEEDS;
    return vw_subsets_retrain(&of->subsets, retrainer->train_views, first_seed, vw_retrain, retrainer);
}

// Lists the methods that have a score for every photo; others cannot be summed over halves. The caller owns the list.
static struct vw_scorer *list_scorers(const struct vw_score_tables *tables, uint32_t *count) {
    struct vw_scorer *scorers = vw_allocate(tables->count, sizeof *scorers);
    *count = 0;
    for (uint32_t i = 0; i < tables->count && scorers; i++) {
        bool complete = true;
        for (size_t j = 0; j < (size_t)tables->run_count * tables->photo_count; j++)
            complete &= isfinite(tables->tables[i].values[j]) != 0;
        if (complete)
            scorers[(*count)++] =
                (struct vw_scorer){.name = tables->tables[i].method, .scores = tables->tables[i].values};
    }
    return scorers;
}

static void take_metrics(const struct vw_metrics *evaluated, struct vw_sweep_metrics *metric) {
    const struct vw_metric *auc = vw_metrics_find(evaluated, "auc", "corrupted", metric->method);
    const struct vw_metric *lds = vw_metrics_find(evaluated, "lds", "val_psnr", metric->method);
    if (auc) metric->auc = auc->value;
    if (lds) metric->lds = lds->value, metric->lds_ci_low = lds->ci_low, metric->lds_ci_high = lds->ci_high;
}

const char **vw_retrainer_list_labels(const struct vw_retrainer *retrainer, bool *known) {
    const char **labels = vw_allocate(retrainer->train_count, sizeof *labels);
    *known = false;
    for (uint32_t i = 0; labels && i < retrainer->train_count; i++) {
        const char *ground_truth = retrainer->params.session->scene->views[retrainer->train_views[i]].ground_truth;
        labels[i] = ground_truth ? ground_truth : "clean";
        *known |= ground_truth != NULL;
    }
    return labels;
}

static enum vw_status evaluate(void *context, const struct vw_retrainer *retrainer,
                               const struct vw_score_tables *tables, struct vw_sweep_metrics *metrics) {
    const struct vw_sweep_evaluation *of = context;
    uint32_t count = 0;
    bool known = false; // tables->clean tells as well
    struct vw_metrics evaluated = {0};
    const char **ground_truths = vw_retrainer_list_labels(retrainer, &known);
    struct vw_scorer *scorers = list_scorers(tables, &count);
    const struct vw_evaluation evaluation = {.photos = retrainer->train_views,
                                             .ground_truths = ground_truths,
                                             .photo_count = tables->photo_count,
                                             .scorers = scorers,
                                             .scorer_count = count,
                                             .seed_count = tables->run_count};
    enum vw_status status = scorers && ground_truths ? VW_OK : VW_ERROR_MEMORY;
    if (!status && tables->clean) status = vw_evaluate_detection(&evaluation, &evaluated);
    if (!status && of->subsets.count) status = vw_evaluate_subsets(&evaluation, &of->subsets, NULL, &evaluated);
    for (uint32_t i = 0; i < tables->count && !status; i++) take_metrics(&evaluated, &metrics[i]);
    free(evaluated.rows);
    free(scorers);
    free(ground_truths);
    return status;
}

struct vw_sweep_evaluator vw_sweep_evaluator_of(struct vw_sweep_evaluation *evaluation) {
    return (struct vw_sweep_evaluator){.seeds = RETRAINING_SEEDS,
                                       .trainings = evaluation->halves * RETRAINING_SEEDS,
                                       .train = train,
                                       .evaluate = evaluate,
                                       .context = evaluation};
}

void vw_sweep_evaluation_free(struct vw_sweep_evaluation *evaluation) { vw_subsets_free(&evaluation->subsets); }
