#include "cli/contestants.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/controls.h"
#include "cli/scoring.h"
#include "cli/seed_runs.h"
#include "value/score_tables.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"

double *vw_contestants_add(struct vw_contestants *contestants, const char *name, uint32_t trainings) {
    struct vw_contest *contest = &contestants->contest;
    size_t count = (size_t)contest->seed_count * contest->photo_count;
    uint32_t place = contest->contestant_count;
    if (place == VW_CONTESTANTS_MAX) {
        vw_fail(VW_ERROR_MEMORY, "a benchmark judges %d methods at most; leave some out", VW_CONTESTANTS_MAX);
        return NULL;
    }
    double *scores = contestants->scores[place] = vw_allocate(count, sizeof *scores);
    if (!scores) return NULL;
    for (size_t i = 0; i < count; i++) scores[i] = NAN;
    contestants->list[place] = (struct vw_contestant){.name = name, .scores = scores};
    contestants->trainings[place] = trainings;
    contest->contestant_count++;
    return scores;
}

static double *find_or_add(struct vw_contestants *contestants, const char *name, uint32_t trainings) {
    for (uint32_t i = 0; i < contestants->contest.contestant_count; i++)
        if (!strcmp(contestants->list[i].name, name)) return contestants->scores[i];
    return vw_contestants_add(contestants, name, trainings);
}

static enum vw_status take_scores(const struct vw_scoring *scoring, uint32_t seed, struct vw_contestants *contestants) {
    const struct vw_contest *contest = &contestants->contest;
    for (uint32_t i = 0; i < scoring->score_count; i++) {
        double *scores = find_or_add(contestants, scoring->scores[i].method, 1);
        if (!scores) return VW_ERROR_MEMORY;
        if (!scoring->scores[i].visits) continue; // a 0 that nobody measured: stays NaN
        for (uint32_t photo = 0; photo < contest->photo_count; photo++)
            if (contest->photos[photo] == scoring->scores[i].image_id)
                scores[(size_t)seed * contest->photo_count + photo] = scoring->scores[i].value;
    }
    return VW_OK;
}

static enum vw_status take_controls(const struct vw_laboratory *laboratory, const struct vw_scoring *scoring, uint32_t seed,
                                    struct vw_contestants *contestants) {
    const struct vw_contest *contest = &contestants->contest;
    const struct vw_control_input input = {.scene = laboratory->stage.scene,
                                           .photos = contest->photos,
                                           .photo_count = contest->photo_count,
                                           .records = scoring->input.records,
                                           .record_count = scoring->input.record_count,
                                           .seed = laboratory->options->config.seed + seed};
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < vw_control_count; i++) {
        double *scores = find_or_add(contestants, vw_controls[i].name, vw_controls[i].trainings);
        status = scores ? vw_controls[i].score(&input, scores + (size_t)seed * contest->photo_count) : VW_ERROR_MEMORY;
    }
    return status;
}

static enum vw_status take_seed(const struct vw_laboratory *laboratory, uint32_t seed, bool controls, struct vw_contestants *contestants) {
    const struct vw_options *options = laboratory->options;
    struct vw_ledger *ledger = NULL;
    struct vw_scoring scoring = {0};
    enum vw_status status = vw_seed_run_open(options->out, options->config.seed + seed, &ledger);
    if (!status) status = vw_scoring_load(ledger, &options->config, &scoring.input);
    if (!status) scoring.input = vw_value_input_truncate(&scoring.input, options->config.epochs); // the run may have been extended since
    if (!status && !controls) status = vw_value_score(&scoring.input, &scoring.scores, &scoring.score_count);
    if (!status && !controls) status = take_scores(&scoring, seed, contestants);
    if (!status && controls) status = take_controls(laboratory, &scoring, seed, contestants);
    vw_scoring_free(&scoring);
    vw_ledger_close(&ledger);
    return status;
}

// A method that lacks a score for some photo cannot be summed over halves. One that says the same of all photos stays: its empty figures
// say that it tells nothing here.
static void drop_incomplete(struct vw_contestants *contestants) {
    struct vw_contest *contest = &contestants->contest;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < contest->contestant_count; i++) {
        bool complete = true;
        for (size_t j = 0; j < (size_t)contest->seed_count * contest->photo_count; j++) complete &= isfinite(contestants->scores[i][j]);
        if (!complete) {
            vw_log_info("method   %s has no score for some photo: left out", contestants->list[i].name);
            free(contestants->scores[i]);
            continue;
        }
        contestants->list[kept] = contestants->list[i];
        contestants->trainings[kept] = contestants->trainings[i];
        contestants->scores[kept++] = contestants->scores[i];
    }
    contest->contestant_count = kept;
}

static enum vw_status list_truths(const struct vw_laboratory *laboratory, struct vw_contestants *contestants) {
    bool known = false;
    contestants->truths = vw_laboratory_list_truths(laboratory, &known);
    if (!contestants->truths) return VW_ERROR_MEMORY;
    if (!known) vw_log_info("truth    no photo is known to be spoiled: AUC is left out; --plant N would spoil some");
    return VW_OK;
}

enum vw_status vw_contestants_make(const struct vw_laboratory *laboratory, uint32_t seed_count, struct vw_contestants *contestants) {
    *contestants = (struct vw_contestants){.contest = {.photos = laboratory->train_views,
                                                       .photo_count = laboratory->train_count,
                                                       .contestants = contestants->list,
                                                       .seed_count = seed_count}};
    enum vw_status status = list_truths(laboratory, contestants);
    contestants->contest.truths = contestants->truths;
    for (uint32_t i = 0; !status && i < 2 * seed_count; i++) status = take_seed(laboratory, i % seed_count, i >= seed_count, contestants);
    if (!status) drop_incomplete(contestants);
    return status;
}

void vw_contestants_free(struct vw_contestants *contestants) {
    for (uint32_t i = 0; i < contestants->contest.contestant_count; i++) free(contestants->scores[i]);
    free(contestants->truths);
}
