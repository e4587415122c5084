// The findings of a comparison: statistics over its trainings, and the files of OUT. Where memory is short JSON becomes
// NULL (base/json.h).
#include <stdio.h>
#include <stdlib.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/rows.h"
#include "experiment/comparison.h"

struct vw_outcome_mean vw_comparison_mean(const struct vw_comparison *comparison, uint32_t list,
                                          enum vw_outcome outcome) {
    double samples[VW_COMPARISON_SEEDS_MAX];
    uint32_t seeds = comparison->params->common.seeds;
    for (uint32_t s = 0; s < seeds; s++)
        samples[s] = vw_outcome_of(&comparison->outcomes[(size_t)list * seeds + s].result, outcome);
    return vw_samples_average(samples, seeds);
}

static struct vw_comparison_pair compare(const struct vw_comparison *comparison, uint32_t list, uint32_t against,
                                         enum vw_outcome outcome) {
    double samples[VW_COMPARISON_SEEDS_MAX], others[VW_COMPARISON_SEEDS_MAX];
    uint32_t seeds = comparison->params->common.seeds;
    const struct vw_comparison_outcome *of_list = &comparison->outcomes[(size_t)list * seeds],
                                       *of_other = &comparison->outcomes[(size_t)against * seeds];
    for (uint32_t s = 0; s < seeds; s++) {
        samples[s] = vw_outcome_of(&of_list[s].result, outcome);
        others[s] = vw_outcome_of(&of_other[s].result, outcome);
    }
    return (struct vw_comparison_pair){.list = of_list->list,
                                       .against = of_other->list,
                                       .measure = vw_outcome_name(outcome),
                                       .outcome = outcome,
                                       .paired = vw_samples_compare(samples, others, seeds)};
}

enum vw_status vw_comparison_list_pairs(struct vw_comparison *comparison) {
    const struct vw_photo_sets *sets = &comparison->sets;
    comparison->pairs = vw_allocate((size_t)sets->count * sets->count * VW_OUTCOME_COUNT, sizeof *comparison->pairs);
    if (!comparison->pairs) return VW_ERROR_MEMORY;
    for (uint32_t against = 0; against < sets->count; against++)
        for (uint32_t l = 1; l < sets->count; l++)
            for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++)
                if (!against || (sets->lists[against].random && !sets->lists[l].random))
                    comparison->pairs[comparison->pair_count++] = compare(comparison, l, against, outcome);
    return VW_OK;
}

// ---- Tables ----

#define MEASURE(name) VW_COLUMN_AS(#name, struct vw_comparison_outcome, REAL_OR_NULL, result.name)
static const struct vw_column outcome_columns[] = {
    {VW_CELL("list", struct vw_comparison_outcome, TEXT, list), .left_out = VW_NOT_IN_JSON},
    VW_COLUMN(struct vw_comparison_outcome, COUNT64, seed),
    VW_COLUMN(struct vw_comparison_outcome, COUNT, photo_count),
    {VW_CELL("epochs", struct vw_comparison_outcome, COUNT, epochs), .left_out = VW_NOT_IN_JSON},
    MEASURE(val_psnr),
    MEASURE(val_ssim),
    MEASURE(val_l1),
    MEASURE(test_psnr),
    MEASURE(test_ssim),
    MEASURE(test_l1),
};

static const struct vw_column pair_columns[] = {
    VW_COLUMN(struct vw_comparison_pair, TEXT, list),
    VW_COLUMN(struct vw_comparison_pair, TEXT, against),
    VW_COLUMN(struct vw_comparison_pair, TEXT, measure),
    VW_COLUMN_AS("difference", struct vw_comparison_pair, REAL_OR_NULL, paired.difference),
    VW_COLUMN_AS("stderr", struct vw_comparison_pair, REAL_OR_NULL, paired.standard_error),
    VW_COLUMN_AS("ci_low", struct vw_comparison_pair, REAL_OR_NULL, paired.ci_low),
    VW_COLUMN_AS("ci_high", struct vw_comparison_pair, REAL_OR_NULL, paired.ci_high),
    VW_COLUMN_AS("beyond_noise", struct vw_comparison_pair, FLAG, paired.beyond_noise),
};

static struct vw_rows outcomes_of(const struct vw_comparison *comparison, uint32_t list, uint32_t lists) {
    uint32_t seeds = comparison->params->common.seeds;
    return VW_ROWS(outcome_columns, &comparison->outcomes[(size_t)list * seeds], lists * seeds);
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
            if (!sets->lists[a].random && !sets->lists[b].random)
                print_one_sided(stream, comparison, &sets->lists[a], &sets->lists[b]);
}

static enum vw_status write_rows(const char *out, const char *name, struct vw_rows rows) {
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_rows_write_csv(path, &rows) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

enum vw_status vw_comparison_write_csv(const struct vw_comparison *comparison) {
    const char *out = comparison->params->common.out;
    char *path = vw_path_join(out, "disagreements.csv");
    enum vw_status status = path ? vw_csv_write_file(path, print_disagreements, comparison) : VW_ERROR_MEMORY;
    free(path);
    if (!status) status = write_rows(out, "compare.csv", outcomes_of(comparison, 0, comparison->sets.count));
    if (!status)
        status = write_rows(out, "pairs.csv", VW_ROWS(pair_columns, comparison->pairs, comparison->pair_count));
    return status;
}

// ---- JSON ----

// Returns a list's photos; none for a list that differs by seed.
static json_t *photos_to_json(const struct vw_comparison *comparison, uint32_t place) {
    const struct vw_photo_set *list = &comparison->sets.lists[place];
    json_t *photos = json_array();
    for (uint32_t i = 0; !list->random && i < list->count; i++)
        vw_json_append(&photos, json_string(comparison->session.scene->views[list->views[i]].name));
    return photos;
}

static json_t *list_to_json(const struct vw_comparison *comparison, uint32_t place) {
    const struct vw_photo_set *list = &comparison->sets.lists[place];
    const struct vw_rows outcomes = outcomes_of(comparison, place, 1);
    json_t *means = json_object(), *errors = json_object();
    for (enum vw_outcome outcome = 0; outcome < VW_OUTCOME_COUNT; outcome++) {
        struct vw_outcome_mean mean = vw_comparison_mean(comparison, place, outcome);
        vw_json_set(&means, vw_outcome_name(outcome), vw_json_real(mean.mean));
        vw_json_set(&errors, vw_outcome_name(outcome), vw_json_real(mean.standard_error));
    }
    return json_pack("{s:s, s:b, s:I, s:I, s:o, s:o, s:o, s:o}", "name", list->name, "random", list->random,
                     "photo_count", (json_int_t)list->count, "epochs", (json_int_t)list->epochs, "photos",
                     photos_to_json(comparison, place), "outcomes", vw_rows_to_json(&outcomes), "mean", means, "stderr",
                     errors);
}

// Adds an entry for a photo that some list has and another lacks.
static void add_disagreement(const struct vw_comparison *comparison, uint32_t view, json_t **disagreements) {
    json_t *in = json_array(), *not_in = json_array();
    for (uint32_t l = 0; l < comparison->sets.count; l++) {
        const struct vw_photo_set *list = &comparison->sets.lists[l];
        if (!list->random) vw_json_append(vw_photo_set_has(list, view) ? &in : &not_in, json_string(list->name));
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
    json_t *seeds = json_array(), *lists = json_array(), *disagreements = json_array(), *renders = json_array();
    const struct vw_rows pairs = VW_ROWS(pair_columns, comparison->pairs, comparison->pair_count);
    for (uint32_t s = 0; s < common->seeds; s++)
        vw_json_append(&seeds, json_integer((json_int_t)(common->config->seed + s)));
    for (uint32_t l = 0; l < comparison->sets.count; l++) vw_json_append(&lists, list_to_json(comparison, l));
    for (uint32_t i = 0; i < comparison->sets.train_count; i++)
        add_disagreement(comparison, comparison->sets.train_views[i], &disagreements);
    for (uint32_t i = 0; i < comparison->rendered_count; i++) vw_json_append(&renders, render_to_json(comparison, i));
    return json_pack("{s:s, s:s, s:o, s:I, s:I, s:s, s:b, s:o, s:o, s:o, s:o}", "scene", common->scene.path,
                     "scene_hash", comparison->scene_hash, "seeds", seeds, "downscale",
                     (json_int_t)(common->scene.downscale ? common->scene.downscale : 1), "epochs",
                     (json_int_t)common->config->epochs, "equal", vw_equal_name(comparison->params->sets.equal),
                     "half_views", comparison->half_views, "lists", lists, "pairs", vw_rows_to_json(&pairs),
                     "disagreements", disagreements, "renders", renders);
}
