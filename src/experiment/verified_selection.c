#include "experiment/verified_selection.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/text.h"
#include "experiment/retrain.h"
#include "ledger/find_image.h"
#include "run/lasting/lasting_summary.h"
#include "run/out_folder.h"
#include "run/scoring.h"
#include "viewworth/log.h"

// ---- Lists ----------------------------------------------------------------------------------------------------------

static const struct {
    const char *name, *method; // method NULL: several
    enum vw_selection_rule rule;
    double percent;
} rules[] = {
    {"without-outliers", NULL, VW_SELECT_OUTLIERS, 0},
    {"not-harmful", "dv_psnr", VW_SELECT_NOT_HARMFUL, 0},
    {"positive", "dv_psnr", VW_SELECT_POSITIVE, 0},
    {"top:90%:dv_psnr", "dv_psnr", VW_SELECT_TOP, 90},
    {"top:75%:dv_psnr", "dv_psnr", VW_SELECT_TOP, 75},
    {"top:75%:quality", "quality", VW_SELECT_TOP, 75},
    {"top:90%:lasting_psnr", "lasting_psnr", VW_SELECT_TOP, 90},
    {"top:75%:lasting_psnr", "lasting_psnr", VW_SELECT_TOP, 75},
};

// Lists without scores, the first of which is all photos: scores that choose no better than these are worth nothing.
static const struct {
    const char *name;
    uint32_t percent; // that are kept
    bool random;      // else every n-th by name is left out
} controls[] = {
    {"all", 100, false},      {"thinned:90%", 90, false}, {"thinned:75%", 75, false},
    {"random:90%", 90, true}, {"random:75%", 75, true},
};
_Static_assert(VW_ARRAY_COUNT(rules) + VW_ARRAY_COUNT(controls) < VW_VERIFIED_LISTS_MAX, "more rules than lists");
static const uint64_t DRAW_SEED = (uint64_t)1 << 63; // seeds of trainings are smaller

static bool has_method(const struct vw_scorings *scorings, const char *method) {
    bool everywhere = true;
    for (int s = 0; s < VW_SCORINGS; s++) {
        bool here = !method && scorings->score_counts[s] > 0;
        for (uint32_t i = 0; !here && method && i < scorings->score_counts[s]; i++)
            here = strcmp(scorings->scores[s][i].method, method) == 0;
        everywhere &= here;
    }
    return everywhere;
}

static void free_list(struct vw_verified_list *list) {
    free(list->same_as);
    for (int s = 0; s < VW_SCORINGS; s++) vw_selection_free(&list->selections[s]);
}

// ---- Rules ----

static bool contains(const struct vw_selection *selection, uint32_t image_id) {
    bool found = false;
    for (uint32_t i = 0; i < selection->count && !found; i++) found = selection->image_ids[i] == image_id;
    return found;
}

// Returns whether two lists, each without repetitions, have the same photos. The order differs by scoring.
static bool are_equal(const struct vw_selection *one, const struct vw_selection *other) {
    bool equal = one->count == other->count;
    for (uint32_t i = 0; equal && i < one->count; i++) equal = contains(other, one->image_ids[i]);
    return equal;
}

static enum vw_status note_same(struct vw_verified_list *first, const char *name) {
    char *longer = vw_format_text("%s%s%s", first->same_as ? first->same_as : "", first->same_as ? ", " : "", name);
    if (!longer) return VW_ERROR_MEMORY;
    free(first->same_as);
    first->same_as = longer;
    return VW_OK;
}

// Adds the list and takes what it owns. A list that chooses the same photos as an earlier one only adds its name there.
static enum vw_status add(struct vw_verified_lists *lists, struct vw_verified_list *made) {
    for (uint32_t l = 0; l < lists->count; l++) {
        bool equal = true;
        for (int s = 0; equal && s < VW_SCORINGS; s++)
            equal = are_equal(&lists->of[l].selections[s], &made->selections[s]);
        if (equal) return note_same(&lists->of[l], made->name);
    }
    lists->of[lists->count++] = *made;
    *made = (struct vw_verified_list){0};
    return VW_OK;
}

// Adds the lone views by the same scores: what no other photo sees is worth more than a score shows.
static enum vw_status keep_lone(const struct vw_scorings *scorings, int s, struct vw_selection *selection) {
    const struct vw_selection_params params = {.rule = VW_SELECT_OUTLIERS};
    struct vw_selection found = {0};
    enum vw_status status = vw_selection_make(scorings->scores[s], scorings->score_counts[s], scorings->images,
                                              scorings->image_count, &params, &found);
    if (status) return status;
    uint32_t *ids = vw_allocate((size_t)selection->count + found.outlier_count, sizeof *ids);
    if (ids) {
        memcpy(ids, selection->image_ids, selection->count * sizeof *ids);
        free(selection->image_ids);
        selection->image_ids = ids;
        for (uint32_t i = 0; i < found.outlier_count; i++)
            if (found.outliers[i].lone && !contains(selection, found.outliers[i].image_id))
                ids[selection->count++] = found.outliers[i].image_id;
    }
    vw_selection_free(&found);
    return ids ? VW_OK : VW_ERROR_MEMORY;
}

// Applies a rule; one that keeps too few photos by some scores does not fail.
static enum vw_status apply(const struct vw_scorings *scorings, const struct vw_selection_params *params,
                            struct vw_verified_list *made, bool *fits) {
    *fits = true;
    for (int s = 0; *fits && s < VW_SCORINGS; s++) {
        struct vw_selection *selection = &made->selections[s];
        enum vw_status status = vw_selection_make(scorings->scores[s], scorings->score_counts[s], scorings->images,
                                                  scorings->image_count, params, selection);
        if (status && status != VW_ERROR_INPUT) return status;
        *fits = !status && selection->count > 1;
        if (*fits) status = keep_lone(scorings, s, selection);
        if (*fits && status) return status;
    }
    return VW_OK;
}

static enum vw_status add_rule(const struct vw_scorings *scorings, const char *name,
                               const struct vw_selection_params *params, struct vw_verified_lists *lists) {
    struct vw_verified_list made = {.name = name,
                                    .method = params->method ? params->method : "train_fit, dv_psnr, dv_loss"};
    bool fits = false;
    enum vw_status status = apply(scorings, params, &made, &fits);
    if (!status && fits) status = add(lists, &made);
    else if (!status) vw_log_info("list     %s: keeps fewer than 2 photos and is left out", name);
    free_list(&made);
    return status;
}

// ---- Lists without scores ----

static int compare_names(const void *left, const void *right) {
    const struct vw_ledger_image *const *one = left, *const *other = right;
    return strcmp((*one)->name, (*other)->name);
}

// Leaves out as many photos as `percent` says, evenly spaced in the order.
static void thin(const struct vw_ledger_image *const *photos, const uint32_t *order, uint32_t count, uint32_t percent,
                 struct vw_selection *selection) {
    uint64_t dropped = count - (uint64_t)round(count * (percent / 100.0));
    for (uint64_t i = 0; i < count; i++)
        if ((2 * i * dropped + count) / (2 * count) == (2 * (i + 1) * dropped + count) / (2 * count))
            selection->image_ids[selection->count++] = photos[order[i]]->image_id;
    vw_sort_places(selection->image_ids, selection->count);
    selection->scored_count = count;
}

// Adds a list that is the same by all scorings.
static enum vw_status add_control(const struct vw_scorings *scorings, size_t place, struct vw_verified_lists *lists) {
    struct vw_verified_list made = {.name = controls[place].name, .method = "none"};
    const struct vw_ledger_image **photos = vw_allocate(scorings->image_count, sizeof *photos);
    uint32_t *order = vw_allocate(scorings->image_count, sizeof *order), count = 0;
    enum vw_status status = photos && order ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < scorings->image_count; i++)
        if (strcmp(scorings->images[i].split, "train") == 0) photos[count++] = &scorings->images[i];
    if (!status) {
        qsort(photos, count, sizeof *photos, compare_names);
        for (uint32_t i = 0; i < count; i++) order[i] = i;
        if (controls[place].random) vw_random_order(DRAW_SEED | scorings->seed, controls[place].percent, count, order);
    }
    for (int s = 0; !status && s < VW_SCORINGS; s++) {
        made.selections[s].image_ids = vw_allocate(count, sizeof *made.selections[s].image_ids);
        if (!made.selections[s].image_ids) status = VW_ERROR_MEMORY;
        else thin(photos, order, count, controls[place].percent, &made.selections[s]);
    }
    if (!status) status = add(lists, &made);
    free_list(&made);
    free(photos);
    free(order);
    return status;
}

enum vw_status vw_verified_lists_make(const struct vw_scorings *scorings, struct vw_verified_lists *lists) {
    *lists = (struct vw_verified_lists){0};
    for (int s = 0; s < VW_SCORINGS; s++)
        if (!scorings->score_counts[s])
            return vw_fail(VW_ERROR_INPUT,
                           "the ledger has no scores; value the photos first, with --epochs larger than --burn-in");
    enum vw_status status = add_control(scorings, 0, lists);
    for (size_t r = 0; !status && r < VW_ARRAY_COUNT(rules); r++) {
        const struct vw_selection_params params = {
            .method = rules[r].method, .rule = rules[r].rule, .amount = rules[r].percent, .percent = true};
        if (has_method(scorings, rules[r].method)) status = add_rule(scorings, rules[r].name, &params, lists);
    }
    for (size_t c = 1; !status && c < VW_ARRAY_COUNT(controls); c++) status = add_control(scorings, c, lists);
    return status;
}

void vw_verified_lists_free(struct vw_verified_lists *lists) {
    for (uint32_t c = 0; c < lists->count; c++) free_list(&lists->of[c]);
    lists->count = 0;
}

// ---- The selection --------------------------------------------------------------------------------------------------

struct work {
    const struct vw_verified_selection_params *params;
    struct vw_verified_selection *result;
    struct vw_config config; // the run's, with the epochs that it took
    struct vw_out_lock *lock;
    struct vw_value_input input; // the run's steps
    uint8_t *halves;             // owned; of every image
    struct vw_scorings scorings;
    struct vw_session session; // device and scene are the run's
    struct vw_retrainer retrainer;
    struct vw_retrain_view *judges; // owned; the validation photos
    uint32_t judge_count;
    double *psnr_db; // owned; [list][seed][judge]: of the list that the judge's scores did not select
};

// ---- Scores of halves ----

static enum vw_status score(struct work *work) {
    struct vw_ledger *ledger = work->params->run->recorded.ledger;
    struct vw_scorings *scorings = &work->scorings;
    enum vw_status status =
        vw_value_score(&work->input, &scorings->scores[VW_HALF_BOTH], &scorings->score_counts[VW_HALF_BOTH]);
    for (uint8_t half = 0; !status && half < VW_HALVES; half++)
        status = vw_halves_score(ledger, &work->input, work->halves, half, &scorings->scores[half],
                                 &scorings->score_counts[half]);
    return status;
}

static enum vw_status prepare(struct work *work) {
    const struct vw_scored_run *run = work->params->run;
    struct vw_verified_selection *result = work->result;
    work->config = run->recorded.config;
    work->scorings.images = run->images;
    work->scorings.image_count = run->image_count;
    work->scorings.seed = work->config.seed;
    work->halves = vw_allocate(run->image_count, sizeof *work->halves);
    if (!work->halves) return VW_ERROR_MEMORY;
    enum vw_status status = vw_scoring_load(run->recorded.ledger, &work->config, &work->input);
    if (!status)
        status = vw_halves_split(run->images, run->image_count, work->config.seed, work->halves, result->half_sizes);
    if (status) return status;
    if (vw_images_have_weights(run->images, run->image_count))
        return vw_fail(
            VW_ERROR_USAGE,
            "the run has --val-weights, but a verified selection judges by all validation photos alike; value "
            "the scene without weights, or select with --quick");
    if (result->half_sizes[VW_HALF_B] == 0)
        return vw_fail(
            VW_ERROR_INPUT,
            "the run has %u validation photo%s, but a verified selection needs at least 2: one half selects, the "
            "other judges; value the scene with more photos in --val, or select with --quick",
            result->half_sizes[VW_HALF_A], vw_plural(result->half_sizes[VW_HALF_A]));
    work->config = vw_config_of_retrainings(&run->recorded, &work->input);
    status = score(work);
    if (!status && !work->input.lasting.view_count && !vw_lasting_check_config(&run->recorded.config))
        vw_log_info("list     none by lasting credit, which needs it by validation photo: viewworth lasting %s "
                    "--lasting-matrix",
                    run->recorded.out);
    return status ? status : vw_verified_lists_make(&work->scorings, &result->lists);
}

// ---- Training ----

static enum vw_status open_retrainer(struct work *work) {
    const struct vw_retrainer_params params = {.session = &work->session,
                                               .config = &work->config,
                                               .out = work->params->run->recorded.out,
                                               .together = work->params->together,
                                               .equal = VW_EQUAL_STEPS,
                                               .averaged_epochs = VW_TRUTH_EPOCHS,
                                               .interrupt = work->params->interrupt};
    return vw_retrainer_open(&params, &work->retrainer);
}

// Sorts the lists that are trained on, every list by the scores of either half. Selections begin with the best
// photo; a retraining has its photos in order.
static void sort_lists(struct vw_verified_lists *lists) {
    for (uint32_t c = 0; c < lists->count; c++)
        for (int half = 0; half < VW_HALVES; half++)
            vw_sort_places(lists->of[c].selections[half].image_ids, lists->of[c].selections[half].count);
}

static struct vw_retrain_params retraining_of(const struct work *work, uint32_t list, uint8_t half, uint32_t seed) {
    const struct vw_selection *selection = &work->result->lists.of[list].selections[half];
    return (struct vw_retrain_params){
        .views = selection->image_ids, .view_count = selection->count, .seed = work->result->first_seed + seed};
}

// Makes the trainings, seed by seed, so that an interrupted verification has whole pairs. Equal ones are made once.
static enum vw_status train(struct work *work) {
    uint32_t lists = work->result->lists.count, count = 0;
    size_t most = (size_t)work->params->seeds * lists * VW_HALVES;
    struct vw_retrain_params *retrainings = vw_allocate(most, sizeof *retrainings);
    struct vw_retrain_result *results = vw_allocate(most, sizeof *results);
    enum vw_status status = retrainings && results ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t s = 0; !status && s < work->params->seeds; s++)
        for (uint32_t c = 0; c < lists; c++)
            for (uint8_t half = 0; half < VW_HALVES; half++) retrainings[count++] = retraining_of(work, c, half, s);
    if (!status) status = vw_retrain_announced(&work->retrainer, retrainings, count, results);
    free(retrainings);
    free(results);
    return status;
}

// ---- Judging ----

static enum vw_status list_judges(struct work *work) {
    const struct vw_scorings *scorings = &work->scorings;
    size_t trainings = (size_t)work->result->lists.count * work->params->seeds;
    work->judges = vw_allocate(scorings->image_count, sizeof *work->judges);
    if (!work->judges) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scorings->image_count; i++)
        if (work->halves[i] != VW_HALF_NONE) work->judges[work->judge_count++].image_id = scorings->images[i].image_id;
    work->psnr_db = vw_allocate(trainings, work->judge_count * sizeof *work->psnr_db);
    return work->psnr_db ? VW_OK : VW_ERROR_MEMORY;
}

// Judges the list that the scores of one half select by the photos of the other half.
static enum vw_status judge(struct work *work, uint32_t list, uint32_t seed, uint8_t half) {
    double *psnr_db = &work->psnr_db[((size_t)list * work->params->seeds + seed) * work->judge_count];
    const struct vw_retrain_params retraining = retraining_of(work, list, VW_HALF_B - half, seed);
    enum vw_status status = vw_retrainer_find_views(&work->retrainer, &retraining, work->judges, work->judge_count);
    for (uint32_t j = 0; !status && j < work->judge_count; j++)
        if (work->halves[work->judges[j].image_id] == half) psnr_db[j] = work->judges[j].psnr_db;
    return status;
}

static enum vw_status choose(struct work *work) {
    struct vw_verified_selection *result = work->result;
    enum vw_status status = list_judges(work);
    for (uint32_t c = 0; c < result->lists.count; c++)
        for (uint32_t s = 0; s < work->params->seeds; s++)
            for (uint8_t half = 0; !status && half < VW_HALVES; half++) status = judge(work, c, s, half);
    if (!status)
        status = vw_gains_estimate(work->psnr_db, result->lists.count, work->params->seeds, work->judge_count,
                                   result->gains);
    if (!status) result->chosen = vw_gains_choose(result->gains, result->lists.count);
    return status;
}

// ---- All of it ----

static enum vw_status make(struct work *work) {
    enum vw_status status = prepare(work);
    if (status || work->result->lists.count == 1) return status;
    sort_lists(&work->result->lists);
    work->result->first_seed = vw_first_seed_after(work->config.seed);
    status = vw_out_lock_take(work->params->run->recorded.out, &work->lock);
    if (!status) status = vw_ledger_verify(work->params->run->recorded.ledger);
    if (!status)
        status = vw_session_open_recorded(&work->params->run->recorded, &work->params->devices, &work->session);
    if (!status) status = open_retrainer(work);
    if (!status) status = train(work);
    return status ? status : choose(work);
}

enum vw_status vw_verified_selection_make(const struct vw_verified_selection_params *params,
                                          struct vw_verified_selection *result) {
    struct work work = {.params = params, .result = result};
    *result = (struct vw_verified_selection){0};
    enum vw_status status = make(&work);
    vw_retrainer_close(&work.retrainer);
    vw_session_close_recorded(&work.session);
    vw_out_lock_release(&work.lock);
    vw_scoring_unload(&work.input);
    for (int s = 0; s < VW_SCORINGS; s++) free(work.scorings.scores[s]);
    free(work.halves);
    free(work.judges);
    free(work.psnr_db);
    return status;
}
