// The findings of a comparison: statistics over its trainings, and the files of OUT. Where memory is short JSON becomes
// NULL (base/json.h).
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/json.h"
#include "experiment/comparison.h"

// Returns the results of a list, by training.
static const struct vw_retrain_result *results_of(const struct vw_comparison *comparison, uint32_t list) {
    return comparison->results + (size_t)list * comparison->training_count;
}

const struct vw_photo_set *vw_comparison_list(const struct vw_comparison *comparison, uint32_t list,
                                              uint32_t training) {
    uint32_t valuation = training / comparison->params->common.seeds;
    return valuation ? &comparison->other_sets[valuation - 1].lists[list] : &comparison->sets.lists[list];
}

bool vw_comparison_varies(const struct vw_comparison *comparison, uint32_t list) {
    const struct vw_photo_set *first = &comparison->sets.lists[list];
    return first->random || (first->by_scores && comparison->params->valuation_seeds);
}

// Fills in the means of the trainings of every valuation, or the trainings if the lists do not depend on valuations.
// Returns how many there are.
static uint32_t take_samples(const struct vw_comparison *comparison, uint32_t list, enum vw_outcome outcome,
                             double samples[]) {
    const struct vw_retrain_result *results = results_of(comparison, list);
    uint32_t seeds = comparison->params->valuation_seeds ? comparison->params->common.seeds : 1,
             count = comparison->training_count / seeds;
    for (uint32_t i = 0; i < count; i++)
        samples[i] = vw_outcome_average(&results[(size_t)i * seeds], seeds, outcome).mean;
    return count;
}

struct vw_outcome_mean vw_comparison_mean(const struct vw_comparison *comparison, uint32_t list,
                                          enum vw_outcome outcome) {
    double samples[VW_COMPARISON_SAMPLES_MAX];
    return vw_samples_average(samples, take_samples(comparison, list, outcome, samples));
}

struct vw_paired_difference vw_comparison_difference(const struct vw_comparison *comparison,
                                                     const struct vw_set_pair *pair, enum vw_outcome outcome) {
    double samples[VW_COMPARISON_SAMPLES_MAX], against[VW_COMPARISON_SAMPLES_MAX];
    uint32_t count = take_samples(comparison, pair->list, outcome, samples);
    take_samples(comparison, pair->against, outcome, against);
    return vw_samples_compare(samples, against, count);
}

// ---- CSV ----

static void print_measures(FILE *stream) {
    for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
        fprintf(stream, ",%s", vw_outcome_name(outcome));
    fputc('\n', stream);
}

static void print_outcomes(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    fputs("list,seed,photo_count,epochs", stream);
    print_measures(stream);
    for (uint32_t l = 0; l < comparison->sets.count; l++)
        for (uint32_t s = 0; s < comparison->training_count; s++) {
            const struct vw_photo_set *list = vw_comparison_list(comparison, l, s);
            vw_csv_print(stream, "t,", list->name);
            fprintf(stream, "%" PRIu64 ",%u,%u", comparison->params->common.config->seed + s, list->count,
                    list->epochs);
            for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
                vw_csv_print(stream, ",r", vw_outcome_of(&results_of(comparison, l)[s], outcome));
            fputc('\n', stream);
        }
}

static void print_pair(FILE *stream, const struct vw_comparison *comparison, const struct vw_set_pair *pair,
                       enum vw_outcome outcome) {
    struct vw_paired_difference paired = vw_comparison_difference(comparison, pair, outcome);
    vw_csv_print(stream, "t,t,t,r,r,r,r,t\n", comparison->sets.lists[pair->list].name,
                 comparison->sets.lists[pair->against].name, vw_outcome_name(outcome), paired.difference,
                 paired.standard_error, paired.ci_low, paired.ci_high, paired.beyond_noise ? "true" : "false");
}

static void print_pairs(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    fputs("list,against,measure,difference,stderr,ci_low,ci_high,beyond_noise\n", stream);
    for (uint32_t p = 0; p < comparison->pair_count; p++)
        for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
            print_pair(stream, comparison, &comparison->pairs[p], outcome);
}

static void print_one_sided(FILE *stream, const struct vw_comparison *comparison, const struct vw_photo_set *has,
                            const struct vw_photo_set *has_not) {
    for (uint32_t i = 0; i < has->count; i++)
        if (!vw_photo_set_has(has_not, has->views[i]))
            vw_csv_print(stream, "t,t,t\n", comparison->session.scene->views[has->views[i]].name, has->name,
                         has_not->name);
}

static void print_disagreements(FILE *stream, const void *context) {
    const struct vw_comparison *comparison = context;
    const struct vw_photo_sets *sets = &comparison->sets;
    fputs("photo,in,not_in\n", stream);
    for (uint32_t a = 0; a < sets->count; a++)
        for (uint32_t b = 0; b < sets->count; b++)
            if (!vw_comparison_varies(comparison, a) && !vw_comparison_varies(comparison, b))
                print_one_sided(stream, comparison, &sets->lists[a], &sets->lists[b]);
}

static enum vw_status write_table(const struct vw_comparison *comparison, const char *name, vw_csv_printer *print) {
    char *path = vw_path_join(comparison->params->common.out, name);
    enum vw_status status = path ? vw_csv_write_file(path, print, comparison) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_comparison_write_csv(const struct vw_comparison *comparison) {
    enum vw_status status = write_table(comparison, "compare.csv", print_outcomes);
    if (!status) status = write_table(comparison, "pairs.csv", print_pairs);
    if (!status) status = write_table(comparison, "disagreements.csv", print_disagreements);
    return status;
}

// ---- JSON ----

static json_t *result_to_json(const struct vw_retrain_result *result, uint64_t seed, uint32_t photo_count) {
    json_t *object = json_pack("{s:I, s:I}", "seed", (json_int_t)seed, "photo_count", (json_int_t)photo_count);
    for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
        vw_json_set(&object, vw_outcome_name(outcome), vw_json_real(vw_outcome_of(result, outcome)));
    return object;
}

// Returns a list's photos; none for a list that differs by seed or valuation.
static json_t *photos_to_json(const struct vw_comparison *comparison, uint32_t place) {
    const struct vw_photo_set *list = &comparison->sets.lists[place];
    json_t *photos = json_array();
    for (uint32_t i = 0; !vw_comparison_varies(comparison, place) && i < list->count; i++)
        vw_json_append(&photos, json_string(comparison->session.scene->views[list->views[i]].name));
    return photos;
}

static json_t *list_to_json(const struct vw_comparison *comparison, uint32_t place) {
    const struct vw_photo_set *list = &comparison->sets.lists[place];
    const struct vw_retrain_result *results = results_of(comparison, place);
    json_t *made = json_array(), *means = json_object(), *errors = json_object();
    for (uint32_t s = 0; s < comparison->training_count; s++)
        vw_json_append(&made, result_to_json(&results[s], comparison->params->common.config->seed + s,
                                             vw_comparison_list(comparison, place, s)->count));
    for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++) {
        struct vw_outcome_mean mean = vw_comparison_mean(comparison, place, outcome);
        vw_json_set(&means, vw_outcome_name(outcome), vw_json_real(mean.mean));
        vw_json_set(&errors, vw_outcome_name(outcome), vw_json_real(mean.standard_error));
    }
    return json_pack("{s:s, s:b, s:I, s:I, s:o, s:o, s:o, s:o}", "name", list->name, "random", list->random,
                     "photo_count", (json_int_t)list->count, "epochs", (json_int_t)list->epochs, "photos",
                     photos_to_json(comparison, place), "outcomes", made, "mean", means, "stderr", errors);
}

static json_t *pair_to_json(const struct vw_comparison *comparison, const struct vw_set_pair *pair,
                            enum vw_outcome outcome) {
    struct vw_paired_difference paired = vw_comparison_difference(comparison, pair, outcome);
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:b}", "list", comparison->sets.lists[pair->list].name,
                     "against", comparison->sets.lists[pair->against].name, "measure", vw_outcome_name(outcome),
                     "difference", vw_json_real(paired.difference), "stderr", vw_json_real(paired.standard_error),
                     "ci_low", vw_json_real(paired.ci_low), "ci_high", vw_json_real(paired.ci_high), "beyond_noise",
                     paired.beyond_noise);
}

// Adds an entry for a photo that some list has and another lacks.
static void add_disagreement(const struct vw_comparison *comparison, uint32_t view, json_t **disagreements) {
    json_t *in = json_array(), *not_in = json_array();
    for (uint32_t l = 0; l < comparison->sets.count; l++) {
        const struct vw_photo_set *list = &comparison->sets.lists[l];
        if (!vw_comparison_varies(comparison, l))
            vw_json_append(vw_photo_set_has(list, view) ? &in : &not_in, json_string(list->name));
    }
    json_t *disagreement =
        json_pack("{s:s, s:O, s:O}", "photo", comparison->session.scene->views[view].name, "in", in, "not_in", not_in);
    if (!disagreement || (json_array_size(in) && json_array_size(not_in)))
        vw_json_append(disagreements, json_incref(disagreement));
    json_decref(disagreement);
    json_decref(in);
    json_decref(not_in);
}

static json_t *render_to_json(const struct vw_comparison *comparison, uint32_t place) {
    const struct vw_view *view = &comparison->session.scene->views[comparison->rendered_views[place]];
    json_t *columns = json_pack("[s]", "photo");
    char file[32];
    snprintf(file, sizeof file, "renders/%u.png", place);
    for (uint32_t l = 0; l < comparison->sets.count; l++)
        vw_json_append(&columns, json_string(comparison->sets.lists[l].name));
    return json_pack("{s:s, s:s, s:s, s:o}", "view", view->name, "split", vw_split_name(view->split), "file", file,
                     "columns", columns);
}

json_t *vw_comparison_to_json(const struct vw_comparison *comparison) {
    const struct vw_experiment_params *common = &comparison->params->common;
    json_t *seeds = json_array(), *lists = json_array(), *pairs = json_array(), *disagreements = json_array(),
           *renders = json_array();
    for (uint32_t s = 0; s < comparison->training_count; s++)
        vw_json_append(&seeds, json_integer((json_int_t)(common->config->seed + s)));
    for (uint32_t l = 0; l < comparison->sets.count; l++) vw_json_append(&lists, list_to_json(comparison, l));
    for (uint32_t p = 0; p < comparison->pair_count; p++)
        for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
            vw_json_append(&pairs, pair_to_json(comparison, &comparison->pairs[p], outcome));
    for (uint32_t i = 0; i < comparison->sets.train_count; i++)
        add_disagreement(comparison, comparison->sets.train_views[i], &disagreements);
    for (uint32_t i = 0; i < comparison->rendered_count; i++) vw_json_append(&renders, render_to_json(comparison, i));
    json_t *valuations = comparison->params->valuation_seeds ? json_integer(comparison->params->valuation_seeds) : NULL;
    return json_pack("{s:s, s:s, s:o, s:o*, s:I, s:I, s:s, s:b, s:o, s:o, s:o, s:o}", "scene", common->scene.path,
                     "scene_hash", comparison->scene_hash, "seeds", seeds, "valuations", valuations, "downscale",
                     (json_int_t)(common->scene.downscale ? common->scene.downscale : 1), "epochs",
                     (json_int_t)common->config->epochs, "equal", vw_equal_name(comparison->params->sets.equal),
                     "half_views", comparison->half_views, "lists", lists, "pairs", pairs, "disagreements",
                     disagreements, "renders", renders);
}
