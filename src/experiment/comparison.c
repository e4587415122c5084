#include "experiment/comparison.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/json.h"
#include "base/memory.h"
#include "experiment/measured_views.h"
#include "experiment/retrain.h"
#include "run/out_lock.h"
#include "run/outputs/report_folder.h"

// A comparison while it is made.
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
    return status ? status : vw_comparison_list_pairs(comparison);
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
    if (!status) status = vw_comparison_write_csv(comparison);
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
