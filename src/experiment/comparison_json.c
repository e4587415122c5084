// A comparison as JSON. Where memory is short everything becomes NULL (base/json.h).
#include <stdio.h>

#include "base/json.h"
#include "experiment/comparison_files.h"

static json_t *result_to_json(const struct vw_retrain_result *result, uint64_t seed, uint32_t photo_count) {
    json_t *object = json_pack("{s:I, s:I}", "seed", (json_int_t)seed, "photo_count", (json_int_t)photo_count);
    for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++)
        vw_json_set(&object, vw_quality_name(quality), vw_json_real(vw_quality_of(result, quality)));
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
    const struct vw_retrain_result *results = vw_comparison_results(comparison, place);
    json_t *made = json_array(), *means = json_object(), *errors = json_object();
    for (uint32_t s = 0; s < comparison->training_count; s++)
        vw_json_append(&made, result_to_json(&results[s], comparison->params->common.config->seed + s,
                                             vw_comparison_list(comparison, place, s)->count));
    for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++) {
        struct vw_quality_mean mean = vw_comparison_mean(comparison, place, quality);
        vw_json_set(&means, vw_quality_name(quality), vw_json_real(mean.mean));
        vw_json_set(&errors, vw_quality_name(quality), vw_json_real(mean.standard_error));
    }
    return json_pack("{s:s, s:b, s:I, s:I, s:o, s:o, s:o, s:o}", "name", list->name, "random", list->random,
                     "photo_count", (json_int_t)list->count, "epochs", (json_int_t)list->epochs, "photos",
                     photos_to_json(comparison, place), "outcomes", made, "mean", means, "stderr", errors);
}

static json_t *pair_to_json(const struct vw_comparison *comparison, const struct vw_set_pair *pair,
                            enum vw_quality quality) {
    struct vw_paired_difference paired = vw_comparison_difference(comparison, pair, quality);
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:b}", "list", comparison->sets.lists[pair->list].name,
                     "against", comparison->sets.lists[pair->against].name, "measure", vw_quality_name(quality),
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
        for (enum vw_quality quality = 0; quality < VW_QUALITY_COUNT; quality++)
            vw_json_append(&pairs, pair_to_json(comparison, &comparison->pairs[p], quality));
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
