// A comparison as JSON. A value that could not be made for want of memory is NULL, which jansson refuses wherever it is
// put, so that what holds it becomes NULL in turn: only the whole has to be looked at.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/set_comparison.h"
#include "cli/output/json_output.h"
#include "value/evaluation/paired_comparison.h"
#include "base/file.h"
#include "base/memory.h"

// Puts a value into an object; drops the object where that fails.
static void put(json_t **object, const char *key, json_t *value) {
    if (!*object) {
        json_decref(value);
        return;
    }
    if (!json_object_set_new(*object, key, value)) return;
    json_decref(*object);
    *object = NULL;
}

static void append(json_t **array, json_t *value) {
    if (!*array) {
        json_decref(value);
        return;
    }
    if (!json_array_append_new(*array, value)) return;
    json_decref(*array);
    *array = NULL;
}

static json_t *outcome_to_json(const struct vw_retrain_result *outcome, uint64_t seed, uint32_t photo_count) {
    json_t *object = json_pack("{s:I, s:I}", "seed", (json_int_t)seed, "photo_count", (json_int_t)photo_count);
    for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
        put(&object, vw_outcome_measure_name(measure), vw_json_real(vw_outcome_of(outcome, measure)));
    return object;
}

// A random list has other photos for each seed: none are named.
static json_t *photos_to_json(const struct vw_set_comparison *compared, const struct vw_photo_set *list) {
    json_t *photos = json_array();
    for (uint32_t i = 0; !list->random && i < list->count; i++)
        append(&photos, json_string(compared->scene->views[list->views[i]].name));
    return photos;
}

static json_t *list_to_json(const struct vw_set_comparison *compared, uint32_t place) {
    const struct vw_photo_set *list = &compared->lists->lists[place];
    const struct vw_retrain_result *outcomes = vw_set_comparison_outcomes(compared, place);
    uint32_t seeds = compared->options->seeds;
    json_t *made = json_array(), *means = json_object(), *errors = json_object();
    for (uint32_t s = 0; s < seeds; s++)
        append(&made, outcome_to_json(&outcomes[s], compared->options->config.seed + s, list->count));
    for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++) {
        struct vw_outcome_mean mean = vw_outcomes_mean(outcomes, seeds, measure);
        put(&means, vw_outcome_measure_name(measure), vw_json_real(mean.mean));
        put(&errors, vw_outcome_measure_name(measure), vw_json_real(mean.standard_error));
    }
    return json_pack("{s:s, s:b, s:I, s:I, s:o, s:o, s:o, s:o}", "name", list->name, "random", list->random,
                     "photo_count", (json_int_t)list->count, "epochs", (json_int_t)list->epochs, "photos",
                     photos_to_json(compared, list), "outcomes", made, "mean", means, "stderr", errors);
}

static json_t *pair_to_json(const struct vw_set_comparison *compared, const struct vw_set_pair *pair,
                            enum vw_outcome_measure measure) {
    struct vw_paired_difference paired =
        vw_outcomes_compare(vw_set_comparison_outcomes(compared, pair->list),
                            vw_set_comparison_outcomes(compared, pair->against), compared->options->seeds, measure);
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:b}", "list", compared->lists->lists[pair->list].name,
                     "against", compared->lists->lists[pair->against].name, "measure", vw_outcome_measure_name(measure),
                     "difference", vw_json_real(paired.difference), "stderr", vw_json_real(paired.standard_error),
                     "ci_low", vw_json_real(paired.ci_low), "ci_high", vw_json_real(paired.ci_high), "beyond_noise",
                     paired.beyond_noise);
}

// One entry per photo that some list has and another one has not.
static void add_disagreement(const struct vw_set_comparison *compared, uint32_t view, json_t **disagreements) {
    json_t *in = json_array(), *not_in = json_array();
    for (uint32_t l = 0; l < compared->lists->count; l++) {
        const struct vw_photo_set *list = &compared->lists->lists[l];
        if (!list->random) append(vw_photo_set_has(list, view) ? &in : &not_in, json_string(list->name));
    }
    json_t *disagreement =
        json_pack("{s:s, s:O, s:O}", "photo", compared->scene->views[view].name, "in", in, "not_in", not_in);
    if (!disagreement || (json_array_size(in) && json_array_size(not_in)))
        append(disagreements, json_incref(disagreement));
    json_decref(disagreement);
    json_decref(in);
    json_decref(not_in);
}

static json_t *render_to_json(const struct vw_set_comparison *compared, uint32_t place) {
    const struct vw_view *view = &compared->scene->views[compared->shown_views[place]];
    json_t *columns = json_pack("[s]", "photo");
    char file[32];
    snprintf(file, sizeof file, "renders/%u.png", place);
    for (uint32_t l = 0; l < compared->lists->count; l++) append(&columns, json_string(compared->lists->lists[l].name));
    return json_pack("{s:s, s:s, s:s, s:o}", "view", view->name, "split", vw_split_name(view->split), "file", file,
                     "columns", columns);
}

static json_t *compared_to_json(const struct vw_set_comparison *compared) {
    const struct vw_options *options = compared->options;
    json_t *seeds = json_array(), *lists = json_array(), *pairs = json_array(), *disagreements = json_array(),
           *renders = json_array();
    for (uint32_t s = 0; s < options->seeds; s++) append(&seeds, json_integer((json_int_t)(options->config.seed + s)));
    for (uint32_t l = 0; l < compared->lists->count; l++) append(&lists, list_to_json(compared, l));
    for (uint32_t p = 0; p < compared->pair_count; p++)
        for (enum vw_outcome_measure measure = 0; measure < VW_AGGREGATE_MEASURES; measure++)
            append(&pairs, pair_to_json(compared, &compared->pairs[p], measure));
    for (uint32_t i = 0; i < compared->lists->train_count; i++)
        add_disagreement(compared, compared->lists->train_views[i], &disagreements);
    for (uint32_t i = 0; i < compared->shown_count; i++) append(&renders, render_to_json(compared, i));
    return json_pack("{s:s, s:s, s:o, s:I, s:I, s:s, s:b, s:o, s:o, s:o, s:o}", "scene", options->operand, "scene_hash",
                     compared->scene_hash, "seeds", seeds, "downscale", (json_int_t)options->downscale, "epochs",
                     (json_int_t)options->config.epochs, "equal", vw_equal_name(options->equal), "half_views",
                     compared->half_views, "lists", lists, "pairs", pairs, "disagreements", disagreements, "renders",
                     renders);
}

enum vw_status vw_set_comparison_write_json(const struct vw_set_comparison *compared, bool print) {
    char *path = vw_path_join(compared->options->out, "compare.json");
    json_t *root = compared_to_json(compared);
    char *bare = root ? json_dumps(root, JSON_INDENT(2)) : NULL, *text = bare ? vw_format_text("%s\n", bare) : NULL;
    json_decref(root);
    free(bare);
    enum vw_status status = VW_OK;
    if (!path || !text) status = vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the comparison");
    if (!status) status = vw_file_write(path, text, strlen(text));
    if (!status && print && fputs(text, stdout) == EOF)
        status = vw_fail(VW_ERROR_IO, "stdout: cannot write the JSON output; check where it goes");
    free(path);
    free(text);
    return status;
}
