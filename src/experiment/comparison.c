#include "experiment/comparison.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/rows.h"
#include "experiment/measured_views.h"
#include "experiment/retrain.h"
#include "run/out_folder.h"
#include "run/outputs/report_folder.h"

struct work {
    const struct vw_comparison_params *params;
    struct vw_comparison *comparison;
    struct vw_out_lock *lock; // lock of OUT
    struct vw_retrainer retrainer;
    struct vw_retrain_params *retrainings; // owned; [training][list]
    uint32_t *views;                       // owned; their photos
    char *renders_folder,
        *pictures_folder; // owned: OUT/renders, and in it the folder for pictures of single retrainings
};

// ---- Planning ----

static enum vw_status check(const struct vw_comparison_params *params) {
    const struct vw_experiment_params *common = &params->common;
    if (common->seeds > VW_COMPARISON_SEEDS_MAX)
        return vw_fail(VW_ERROR_USAGE, "--seeds: at most %d can be compared", VW_COMPARISON_SEEDS_MAX);
    enum vw_status status = vw_photo_sets_check(&params->sets);
    return status ? status : vw_experiment_check(common, common->seeds, false);
}

enum { RENDERED_VIEWS = 2 };

// Chooses views spread evenly over the test photos, or over the validation photos if there are no test photos.
static enum vw_status choose_rendered_views(const struct vw_scene *scene, struct vw_comparison *comparison) {
    enum vw_split split = scene->split_count[VW_SPLIT_TEST] ? VW_SPLIT_TEST : VW_SPLIT_VAL;
    uint32_t of_split = scene->split_count[split], wanted = RENDERED_VIEWS, place = 0;
    if (wanted > of_split) wanted = of_split;
    comparison->rendered_views = vw_allocate(wanted, sizeof *comparison->rendered_views);
    if (!comparison->rendered_views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && comparison->rendered_count < wanted; v++) {
        if (scene->views[v].split != split) continue;
        if (place++ == (uint32_t)((2ull * comparison->rendered_count + 1) * of_split / (2ull * wanted)))
            comparison->rendered_views[comparison->rendered_count++] = v;
    }
    return VW_OK;
}

static enum vw_status plan(struct work *work) {
    const struct vw_experiment_params *common = &work->params->common;
    struct vw_comparison *comparison = work->comparison;
    const struct vw_scene *scene = comparison->session.scene;
    if (!scene->split_count[VW_SPLIT_VAL] && !scene->split_count[VW_SPLIT_TEST])
        return vw_fail(VW_ERROR_INPUT, "%s: has neither validation nor test photos; name some by --val or --test",
                       common->scene.path);
    enum vw_status status = vw_photo_sets_make(&work->params->sets, common, scene, &comparison->sets);
    if (status) return status;
    comparison->outcomes = vw_allocate((size_t)comparison->sets.count * common->seeds, sizeof *comparison->outcomes);
    work->renders_folder = vw_path_join(common->out, "renders");
    work->pictures_folder = vw_path_join(common->out, "renders/retrainings");
    if (!comparison->outcomes || !work->renders_folder || !work->pictures_folder) return VW_ERROR_MEMORY;
    return choose_rendered_views(scene, comparison);
}

// ---- Statistics ----

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

static enum vw_status list_pairs(struct vw_comparison *comparison) {
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

// ---- Training ----

static enum vw_status open_retrainer(struct work *work) {
    const struct vw_experiment_params *common = &work->params->common;
    struct vw_session *session = &work->comparison->session;
    const struct vw_retrainer_params params = {.session = session,
                                               .config = common->config,
                                               .out = common->out,
                                               .together = common->together,
                                               .equal = VW_EQUAL_EPOCHS, // a list brings its epochs, as for `train`
                                               .whole_views = true,
                                               .interrupt = common->interrupt};
    enum vw_status status = vw_retrainer_open(&params, &work->retrainer);
    if (status) return status;
    work->comparison->half_views = vw_effects_halve_views(session->effects, session->effect_count);
    memcpy(work->comparison->scene_hash, work->retrainer.scene_hash, sizeof work->comparison->scene_hash);
    return VW_OK;
}

// Lists the retrainings of all lists, seed by seed, so that an interrupted comparison has whole pairs. Copies their
// photos, because a random list has those drawn last.
static enum vw_status list_retrainings(struct work *work) {
    struct vw_comparison *comparison = work->comparison;
    uint32_t lists = comparison->sets.count, count = lists * comparison->params->common.seeds;
    size_t photos = work->retrainer.train_count;
    work->retrainings = vw_allocate(count, sizeof *work->retrainings);
    work->views = vw_allocate(count * photos, sizeof *work->views);
    if (!work->retrainings || !work->views) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t list = i % lists;
        uint64_t seed = comparison->params->common.config->seed + i / lists;
        const uint32_t *drawn = vw_photo_sets_draw(&comparison->sets, list, seed);
        uint32_t view_count = comparison->sets.lists[list].count;
        work->retrainings[i] =
            (struct vw_retrain_params){.views = memcpy(work->views + i * photos, drawn, view_count * sizeof *drawn),
                                       .view_count = view_count,
                                       .seed = seed,
                                       .epochs = comparison->sets.lists[list].epochs};
    }
    return VW_OK;
}

// Makes the retrainings. Those with the first seed save the pictures for the renders.
static enum vw_status train(struct work *work) {
    struct vw_comparison *comparison = work->comparison;
    uint32_t lists = comparison->sets.count, seeds = comparison->params->common.seeds, count = lists * seeds;
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status = results ? list_retrainings(work) : VW_ERROR_MEMORY;
    work->retrainer.saved_views = (struct vw_saved_views){.views = comparison->rendered_views,
                                                          .count = comparison->rendered_count,
                                                          .folder = work->pictures_folder,
                                                          .seed = comparison->params->common.config->seed};
    if (!status) status = vw_retrain_announced(&work->retrainer, work->retrainings, count, results);
    for (uint32_t i = 0; !status && i < count; i++) {
        const struct vw_photo_set *list = &comparison->sets.lists[i % lists];
        comparison->outcomes[(size_t)(i % lists) * seeds + i / lists] =
            (struct vw_comparison_outcome){.list = list->name,
                                           .seed = work->retrainings[i].seed,
                                           .photo_count = list->count,
                                           .epochs = list->epochs,
                                           .result = results[i]};
    }
    free(results);
    return status ? status : list_pairs(comparison);
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

static enum vw_status write_rows(const char *out, const char *name, struct vw_rows rows) {
    char *path = vw_path_join(out, name);
    enum vw_status status = path ? vw_rows_write_csv(path, &rows) : VW_ERROR_MEMORY;
    free(path);
    return status;
}

static enum vw_status write_csv(const struct vw_comparison *comparison) {
    const char *out = comparison->params->common.out;
    enum vw_status status = write_rows(out, "compare.csv", outcomes_of(comparison, 0, comparison->sets.count));
    if (status) return status;
    return write_rows(out, "pairs.csv", VW_ROWS(pair_columns, comparison->pairs, comparison->pair_count));
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

// ---- Results ----

static enum vw_status write_render(struct work *work, uint32_t place) {
    struct vw_comparison *comparison = work->comparison;
    char *pictures[VW_PHOTO_SETS_MAX] = {0}, *to = vw_format_text("%s/%u.png", work->renders_folder, place);
    enum vw_status status = to ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t l = 0; !status && l < comparison->sets.count; l++) {
        char id[VW_HASH_HEX_BYTES];
        vw_retrainer_name(&work->retrainer, &work->retrainings[l], id); // with the first seed
        pictures[l] = vw_saved_view_path(&work->retrainer.saved_views, id, comparison->rendered_views[place]);
        if (!pictures[l]) status = VW_ERROR_MEMORY;
    }
    if (!status) status = vw_side_by_side_write(to, pictures, comparison->sets.count);
    for (uint32_t l = 0; l < comparison->sets.count; l++) free(pictures[l]);
    free(to);
    return status;
}

static enum vw_status write_results(struct work *work) {
    const struct vw_experiment_params *common = &work->params->common;
    struct vw_comparison *comparison = work->comparison;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < comparison->rendered_count; i++) status = write_render(work, i);
    if (!status) status = write_csv(comparison);
    json_t *root = vw_comparison_to_json(comparison);
    char *path = vw_path_join(common->out, "compare.json");
    if (!status) status = vw_json_write_file(path, json_incref(root));
    free(path);
    if (status) {
        json_decref(root);
        return status;
    }
    const struct vw_report_params report = {comparison->session.scene, common->devices.first, common->report, NULL};
    comparison->report_path = vw_report_folder_finish(common->out, &report, "compare.json", root);
    return VW_OK;
}

// ---- All of it ----

// Makes the comparison. Checks the lists before anything is written.
static enum vw_status make(struct work *work) {
    const char *out = work->params->common.out;
    enum vw_status status = check(work->params);
    if (!status) status = vw_out_lock_take(out, &work->lock);
    if (!status) status = vw_experiment_open_session(&work->params->common, &work->comparison->session);
    if (!status) status = plan(work);
    if (!status) status = vw_folder_create_inside(out, "renders/retrainings");
    if (status) return status;
    vw_folder_remove_leftovers(work->renders_folder);
    vw_folder_remove_leftovers(work->pictures_folder);
    status = open_retrainer(work);
    if (!status) status = train(work);
    return status ? status : write_results(work);
}

enum vw_status vw_comparison_make(const struct vw_comparison_params *params, struct vw_comparison *comparison) {
    *comparison = (struct vw_comparison){.params = params};
    struct work work = {.params = params, .comparison = comparison};
    enum vw_status status = make(&work);
    free(work.retrainings);
    free(work.views);
    free(work.renders_folder);
    free(work.pictures_folder);
    vw_retrainer_close(&work.retrainer);
    vw_out_lock_release(&work.lock);
    return status;
}

void vw_comparison_free(struct vw_comparison *comparison) {
    free(comparison->outcomes);
    free(comparison->pairs);
    free(comparison->rendered_views);
    free(comparison->report_path);
    vw_photo_sets_free(&comparison->sets);
    vw_session_close(&comparison->session);
}
