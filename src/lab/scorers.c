#include "lab/scorers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "experiment/experiment.h"
#include "lab/baselines.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/sweep_evaluation.h"
#include "lab/methods/consistent_residual.h"
#include "lab/methods/gradient_list.h"
#include "lab/methods/registry.h"
#include "run/scoring.h"
#include "value/evaluation/score_tables.h"
#include "value/evaluation/worth_regression.h"
#include "value/methods.h"
#include "value/worth.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

const char vw_leave_one_out_scorer[] = "leave_one_out";

bool vw_scorer_exists(const char *name) {
    if (vw_value_method_find(name)) return true;
    for (uint32_t i = 0; i < vw_baseline_count; i++)
        if (!strcmp(vw_baselines[i].name, name)) return true;
    if (!strcmp(name, vw_consistent_residual_name)) return true;
    if (!strncmp(name, "worth_", 6) && name[6] && strspn(name + 6, "0123456789") == strlen(name + 6)) return true;
    if (vw_is_method_and_budget(name)) return true;
    for (uint32_t i = 0; i < VW_GRADIENT_METHODS; i++)
        if (!strcmp(vw_gradient_methods[i].name, name)) return true;
    return !strcmp(name, vw_leave_one_out_scorer) || !strcmp(name, vw_subset_worth_name);
}

double *vw_scorers_add(struct vw_scorers *scorers, struct vw_scorer scorer, struct vw_scorer_cost cost) {
    struct vw_evaluation *evaluation = &scorers->evaluation;
    size_t count = (size_t)evaluation->seed_count * evaluation->photo_count;
    uint32_t place = evaluation->scorer_count;
    if (place == VW_SCORERS_MAX) {
        vw_fail(VW_ERROR_MEMORY, "a benchmark evaluates at most %d scorers", VW_SCORERS_MAX);
        return NULL;
    }
    double *scores = scorers->scores[place] = vw_allocate(count, sizeof *scores);
    if (!scores) return NULL;
    for (size_t i = 0; i < count; i++) scores[i] = NAN;
    scorer.scores = scores;
    scorers->list[place] = scorer;
    scorers->costs[place] = cost;
    evaluation->scorer_count++;
    return scores;
}

static double *find_or_add(struct vw_scorers *scorers, struct vw_scorer scorer, uint32_t trainings) {
    for (uint32_t i = 0; i < scorers->evaluation.scorer_count; i++)
        if (!strcmp(scorers->list[i].name, scorer.name)) return scorers->scores[i];
    return vw_scorers_add(scorers, scorer, (struct vw_scorer_cost){.trainings = trainings});
}

// Returns the cost in trainings: the run, and that of its backward pass (scripts/lab/benchmark_lasting).
static uint32_t trainings_of(const char *method) {
    static const char *const swept[] = {"lasting_psnr", "lasting_loss"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(swept); i++)
        if (!strcmp(method, swept[i])) return 5;
    return 1;
}

static enum vw_status take_scores(const struct vw_scoring *scoring, uint32_t seed, struct vw_scorers *scorers) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    for (uint32_t i = 0; i < scoring->score_count; i++) {
        const char *method = scoring->scores[i].method;
        const struct vw_value_method *about = vw_value_method_find(method);
        const struct vw_scorer scorer = {.name = method, .has_sign = about && about->has_zero};
        double *scores = find_or_add(scorers, scorer, trainings_of(method));
        if (!scores) return VW_ERROR_MEMORY;
        if (!scoring->scores[i].visits) continue; // without a visit the score is unknown, not 0
        for (uint32_t photo = 0; photo < evaluation->photo_count; photo++)
            if (evaluation->photos[photo] == scoring->scores[i].image_id)
                scores[(size_t)seed * evaluation->photo_count + photo] = scoring->scores[i].value;
    }
    return VW_OK;
}

static enum vw_status take_baselines(const struct vw_scene *scene, const struct vw_scoring *scoring, uint64_t run_seed,
                                     uint32_t seed, struct vw_scorers *scorers) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    const struct vw_baseline_input input = {
        .scene = scene, .photos = evaluation->photos, .features = &scorers->features, .valued = seed, .seed = run_seed};
    enum vw_status status = vw_photo_features_add_run(&scorers->features, seed, evaluation->photos,
                                                      scoring->input.records, scoring->input.record_count);
    for (uint32_t i = 0; !status && i < vw_baseline_count; i++) {
        double *scores =
            find_or_add(scorers, (struct vw_scorer){.name = vw_baselines[i].name}, vw_baselines[i].trainings);
        if (!scores) return VW_ERROR_MEMORY;
        vw_baseline_score(&vw_baselines[i], &input, scores + (size_t)seed * evaluation->photo_count);
    }
    return status;
}

// Scores the residuals of a run. `longer`: the run has continued after the epochs that are evaluated, so that its field
// is the wrong one.
static enum vw_status take_residuals(const struct vw_experiment_params *params, const struct vw_session *session,
                                     uint32_t seed, bool longer, struct vw_scorers *scorers) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    struct vw_config config = *params->config;
    config.seed += seed;
    char *path = vw_seed_run_path(params->out, config.seed, "field.vwf");
    double *scores = find_or_add(scorers, (struct vw_scorer){.name = vw_consistent_residual_name}, 1);
    const struct vw_finished_field finished = {session, &config, longer ? NULL : path};
    enum vw_status status = path && scores ? VW_OK : VW_ERROR_MEMORY;
    if (!status)
        status = vw_consistent_residual_find(&finished, evaluation->photos, evaluation->photo_count,
                                             scores + (size_t)seed * evaluation->photo_count);
    free(path);
    return status;
}

enum pass { METHODS, BASELINES, PASS_COUNT };

static enum vw_status take_seed(const struct vw_experiment_params *params, const struct vw_session *session,
                                uint32_t seed, enum pass pass, struct vw_scorers *scorers) {
    const struct vw_config *config = params->config;
    struct vw_ledger *ledger = NULL;
    struct vw_scoring scoring = {0};
    enum vw_status status = vw_seed_run_open(params->out, config->seed + seed, &ledger);
    if (!status) status = vw_scoring_load(ledger, config, &scoring.input);
    uint64_t recorded = scoring.input.record_count;
    if (!status)
        scoring.input = vw_value_input_truncate(&scoring.input, config->epochs); // the run may be longer by now
    bool longer = scoring.input.record_count < recorded;
    if (!status && pass == METHODS) status = vw_value_score(&scoring.input, &scoring.scores, &scoring.score_count);
    if (!status && pass == METHODS) status = take_scores(&scoring, seed, scorers);
    if (!status && pass == BASELINES)
        status = take_baselines(session->scene, &scoring, config->seed + seed, seed, scorers);
    vw_scoring_free(&scoring);
    vw_ledger_close(&ledger);
    if (!status && pass == BASELINES) status = take_residuals(params, session, seed, longer, scorers);
    return status;
}

// Drops methods without a score for some photo, since it cannot be summed over subsets. A method with equal scores for
// all photos stays: its empty metrics show that it tells nothing here.
void vw_scorers_drop_incomplete(struct vw_scorers *scorers) {
    struct vw_evaluation *evaluation = &scorers->evaluation;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++) {
        bool complete = true;
        for (size_t j = 0; j < (size_t)evaluation->seed_count * evaluation->photo_count; j++)
            complete &= isfinite(scorers->scores[i][j]);
        if (!complete) {
            vw_log_info("method   %s is left out: it has no score for some photo", scorers->list[i].name);
            free(scorers->scores[i]);
            continue;
        }
        scorers->list[kept] = scorers->list[i];
        scorers->costs[kept] = scorers->costs[i];
        scorers->scores[kept++] = scorers->scores[i];
    }
    evaluation->scorer_count = kept;
}

static enum vw_status list_ground_truths(const struct vw_retrainer *retrainer, struct vw_scorers *scorers) {
    bool known = false;
    scorers->ground_truths = vw_retrainer_list_labels(retrainer, &known);
    if (!scorers->ground_truths) return VW_ERROR_MEMORY;
    if (!known)
        vw_log_info("labels   the scene has no ground-truth labels, so there is no AUC; --corrupt N corrupts N photos");
    return VW_OK;
}

enum vw_status vw_scorers_open_retrainer(const struct vw_experiment_params *params, struct vw_session *session,
                                         enum vw_equal equal, struct vw_retrainer *retrainer) {
    const struct vw_config *config = params->config;
    const struct vw_retrainer_params opened = {.session = session,
                                               .config = config,
                                               .out = params->out,
                                               .together = params->together,
                                               .equal = equal,
                                               .averaged_epochs =
                                                   config->epochs < VW_TRUTH_EPOCHS ? config->epochs : VW_TRUTH_EPOCHS,
                                               .interrupt = params->interrupt};
    return vw_retrainer_open(&opened, retrainer);
}

enum vw_status vw_scorers_make(const struct vw_experiment_params *params, const struct vw_retrainer *retrainer,
                               uint32_t seed_count, struct vw_scorers *scorers) {
    *scorers = (struct vw_scorers){.evaluation = {.photos = retrainer->train_views,
                                                  .photo_count = retrainer->train_count,
                                                  .scorers = scorers->list,
                                                  .seed_count = seed_count}};
    const struct vw_session *session = retrainer->params.session;
    enum vw_status status = list_ground_truths(retrainer, scorers);
    scorers->evaluation.ground_truths = scorers->ground_truths;
    if (!status)
        status = vw_photo_features_make(session->scene, retrainer->train_views, retrainer->train_count, seed_count,
                                        &scorers->features);
    for (enum pass pass = METHODS; pass < PASS_COUNT; pass++) // the methods of all seeds come before the baselines
        for (uint32_t seed = 0; !status && seed < seed_count; seed++)
            status = take_seed(params, session, seed, pass, scorers);
    if (!status) vw_scorers_drop_incomplete(scorers);
    return status;
}

enum vw_status vw_scorers_find_worth(const struct vw_scorers *scorers, uint32_t valued,
                                     const struct vw_ledger_retraining *retrainings, uint32_t count, double *scores) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    uint32_t photos = evaluation->photo_count, score_count = 0, made = 0;
    struct vw_ledger_image *images = vw_allocate(photos, sizeof *images);
    struct vw_ledger_score *prior = vw_allocate((size_t)photos * (evaluation->scorer_count + 1), sizeof *prior);
    enum vw_status status = images && prior ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < photos; i++)
        images[i] = (struct vw_ledger_image){.image_id = evaluation->photos[i], .split = "train"};
    for (size_t i = 0; !status && i < (size_t)evaluation->scorer_count * photos; i++) {
        const struct vw_scorer *scorer = &evaluation->scorers[i / photos];
        prior[score_count++] = (struct vw_ledger_score){.image_id = evaluation->photos[i % photos],
                                                        .method = scorer->name,
                                                        .value = scorer->scores[(size_t)valued * photos + i % photos],
                                                        .visits = 1};
    }
    const struct vw_worth_input input = {retrainings, count, images, photos, prior, score_count};
    for (uint32_t i = 0; i < photos; i++) scores[i] = NAN;
    if (!status) status = vw_worth_append(&input, prior + score_count, &made);
    for (uint32_t i = 0; !status && i < made; i++) scores[i] = prior[score_count + i].value;
    free(images);
    free(prior);
    return status;
}

void vw_scorers_free(struct vw_scorers *scorers) {
    for (uint32_t i = 0; i < scorers->evaluation.scorer_count; i++) free(scorers->scores[i]);
    free(scorers->ground_truths);
    vw_photo_features_free(&scorers->features);
}
