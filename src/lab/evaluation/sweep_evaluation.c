#include "lab/evaluation/sweep_evaluation.h"

#include <math.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/subset_trainings.h"
#include "viewworth/log.h"

// The evaluation while it is made.
struct work {
    struct vw_sweep *sweep;
    const struct vw_score_tables *tables; // by configuration
    uint32_t halves;
    struct vw_retrainer retrainer;
    struct vw_subsets subsets;
    const char **ground_truths;   // owned; by photo
    struct vw_metrics *evaluated; // owned; by configuration
};

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

// ---- Trainings ----

static enum vw_status train(struct work *work) {
    const struct vw_experiment_params *common = &work->sweep->params->common;
    const struct vw_retrainer_params params = {.session = &work->sweep->session,
                                               .config = common->config,
                                               .out = common->out,
                                               .together = common->together,
                                               .averaged_epochs = VW_TRUTH_EPOCHS,
                                               .interrupt = common->interrupt};
    enum vw_status status = vw_retrainer_open(&params, &work->retrainer);
    if (status || !work->halves) return status;
    const struct vw_subsets_params subsets = {
        .photo_count = work->retrainer.train_count, .halves = work->halves, .seed_count = VW_HALF_SEEDS};
    status = vw_subsets_draw(&subsets, &work->subsets);
    if (status) return status;
    work->retrainer.planned = (uint64_t)work->subsets.count * VW_HALF_SEEDS;
    return vw_subsets_retrain(&work->subsets, work->retrainer.train_views, common->config->seed + common->seeds,
                              vw_retrain, &work->retrainer);
}

// ---- Metrics ----

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

static enum vw_status evaluate(const struct work *work, uint32_t configuration) {
    const struct vw_score_tables *tables = &work->tables[configuration];
    struct vw_metrics *evaluated = &work->evaluated[configuration];
    uint32_t count = 0;
    struct vw_scorer *scorers = list_scorers(tables, &count);
    const struct vw_evaluation evaluation = {.photos = work->retrainer.train_views,
                                             .ground_truths = work->ground_truths,
                                             .photo_count = tables->photo_count,
                                             .scorers = scorers,
                                             .scorer_count = count,
                                             .seed_count = tables->run_count};
    enum vw_status status = scorers ? VW_OK : VW_ERROR_MEMORY;
    if (!status && tables->clean) status = vw_evaluate_detection(&evaluation, evaluated);
    if (!status && work->subsets.count) status = vw_evaluate_subsets(&evaluation, &work->subsets, NULL, evaluated);
    free(scorers);
    return status;
}

static void print_rows(FILE *stream, const void *context) {
    const struct work *work = context;
    const struct vw_metric none = {.value = NAN, .ci_low = NAN, .ci_high = NAN};
    fputs("configuration,method,auc,lds,lds_ci_low,lds_ci_high\n", stream);
    for (uint32_t c = 0; c < work->sweep->configurations->count; c++)
        for (uint32_t t = 0; t < work->tables[c].count; t++) {
            const char *method = work->tables[c].tables[t].method;
            const struct vw_metric *auc = vw_metrics_find(&work->evaluated[c], "auc", "corrupted", method);
            const struct vw_metric *lds = vw_metrics_find(&work->evaluated[c], "lds", "val_psnr", method);
            if (!auc) auc = &none;
            if (!lds) lds = &none;
            vw_csv_print(stream, "t,t,r,r,r,r\n", work->sweep->configurations->configurations[c].name, method,
                         auc->value, lds->value, lds->ci_low, lds->ci_high);
        }
}

static enum vw_status make(struct work *work) {
    uint32_t count = work->sweep->configurations->count;
    bool known = false; // the tables tell as well
    enum vw_status status = train(work);
    if (status) return status;
    work->ground_truths = vw_retrainer_list_labels(&work->retrainer, &known);
    work->evaluated = vw_allocate(count, sizeof *work->evaluated);
    char *path = vw_path_join(work->sweep->params->common.out, "evaluation.csv");
    if (!work->ground_truths || !work->evaluated || !path) status = VW_ERROR_MEMORY;
    for (uint32_t c = 0; !status && c < count; c++) status = evaluate(work, c);
    if (!status) status = vw_csv_write_file(path, print_rows, work);
    if (!status) vw_log_info("evaluation %s", path);
    free(path);
    return status;
}

enum vw_status vw_sweep_evaluate(void *context, struct vw_sweep *sweep, const struct vw_score_tables *tables) {
    const struct vw_sweep_evaluation *evaluation = context;
    struct work work = {.sweep = sweep, .tables = tables, .halves = evaluation->halves};
    enum vw_status status = make(&work);
    for (uint32_t c = 0; work.evaluated && c < sweep->configurations->count; c++) free(work.evaluated[c].rows);
    free(work.evaluated);
    free(work.ground_truths);
    vw_subsets_free(&work.subsets);
    vw_retrainer_close(&work.retrainer);
    return status;
}
