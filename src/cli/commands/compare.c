// Which set of photos makes the better reconstruction: every list is trained with the same seeds and evaluated on whole
// photos.
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/commands/commands.h"
#include "experiment/set_comparison.h"
#include "cli/interrupt.h"
#include "cli/params.h"
#include "experiment/retrain.h"
#include "run/outputs/report_folder.h"
#include "run/out_folder.h"
#include "experiment/side_by_side.h"
#include "base/file.h"
#include "base/memory.h"

struct comparison {
    const struct vw_options *options;
    struct vw_retrainer retrainer;
    struct vw_photo_sets lists;
    struct vw_set_comparison compared;
    char *renders_folder, *pictures_folder; // owned; OUT/renders, and within it what single retrainings leave
};

// ---- Planning
// -----------------------------------------------------------------------------------------------------------

static enum vw_status check(const struct vw_options *options) {
    enum vw_status status = vw_photo_sets_check(options);
    if (status) return status;
    if (!vw_name_is_clean(options->operand))
        return vw_fail(VW_ERROR_USAGE, "compare: the scene's path is no UTF-8 or holds control characters; rename it");
    if (options->config.seed > (uint64_t)INT64_MAX - (options->seeds - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the seeds counted from it pass %" PRId64
                       ", the largest; begin with a lower one",
                       options->config.seed, INT64_MAX);
    if (vw_file_exists(options->out))
        return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", options->out);
    return vw_out_check(options->out);
}

// Spread evenly over the test photos, or over those that validate where none tests.
static enum vw_status choose_shown_views(struct comparison *comparison) {
    const struct vw_scene *scene = comparison->retrainer.session.scene;
    struct vw_set_comparison *compared = &comparison->compared;
    enum vw_split split = scene->split_count[VW_SPLIT_TEST] ? VW_SPLIT_TEST : VW_SPLIT_VAL;
    uint32_t of_split = scene->split_count[split], place = 0;
    uint32_t wanted = comparison->options->views < of_split ? comparison->options->views : of_split;
    compared->shown_views = vw_allocate(wanted, sizeof *compared->shown_views);
    if (!compared->shown_views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && compared->shown_count < wanted; v++) {
        if (scene->views[v].split != split) continue;
        if (place++ == (uint32_t)((2ull * compared->shown_count + 1) * of_split / (2ull * wanted)))
            compared->shown_views[compared->shown_count++] = v;
    }
    return VW_OK;
}

// Every list against the first one, then the others against each random one.
static enum vw_status list_pairs(struct comparison *comparison) {
    const struct vw_photo_sets *lists = &comparison->lists;
    struct vw_set_comparison *compared = &comparison->compared;
    compared->pairs = vw_allocate((size_t)lists->count * lists->count, sizeof *compared->pairs);
    if (!compared->pairs) return VW_ERROR_MEMORY;
    for (uint32_t against = 0; against < lists->count; against++)
        for (uint32_t l = 1; l < lists->count; l++)
            if (!against || (lists->lists[against].random && !lists->lists[l].random))
                compared->pairs[compared->pair_count++] = (struct vw_set_pair){l, against};
    return VW_OK;
}

static enum vw_status plan(struct comparison *comparison) {
    const struct vw_options *options = comparison->options;
    struct vw_set_comparison *compared = &comparison->compared;
    *compared = (struct vw_set_comparison){.options = options,
                                           .scene = comparison->retrainer.session.scene,
                                           .lists = &comparison->lists,
                                           .scene_hash = comparison->retrainer.scene_hash};
    if (!compared->scene->split_count[VW_SPLIT_VAL] && !compared->scene->split_count[VW_SPLIT_TEST])
        return vw_fail(VW_ERROR_INPUT, "%s: no photo validates or tests; give some by --val or --test",
                       options->operand);
    enum vw_status status = vw_photo_sets_make(options, compared->scene, &comparison->lists);
    if (status) return status;
    compared->outcomes = vw_allocate((size_t)comparison->lists.count * options->seeds, sizeof *compared->outcomes);
    comparison->renders_folder = vw_path_join(options->out, "renders");
    comparison->pictures_folder = vw_path_join(options->out, "renders/retrainings");
    if (!compared->outcomes || !comparison->renders_folder || !comparison->pictures_folder) return VW_ERROR_MEMORY;
    status = choose_shown_views(comparison);
    return status ? status : list_pairs(comparison);
}

// ---- Training
// -----------------------------------------------------------------------------------------------------------

static struct vw_retrain_params retraining_of(struct comparison *comparison, uint32_t list, uint64_t seed) {
    return (struct vw_retrain_params){.views = vw_photo_sets_draw(&comparison->lists, list, seed),
                                      .view_count = comparison->lists.lists[list].count,
                                      .seed = seed,
                                      .epochs = comparison->lists.lists[list].epochs};
}

// Seed by seed, so that what is stopped early has whole pairs. Retrainings of the first seed leave the pictures for the
// renders.
static enum vw_status train(struct comparison *comparison) {
    const struct vw_options *options = comparison->options;
    struct vw_retrainer *retrainer = &comparison->retrainer;
    enum vw_status status = VW_OK;
    retrainer->planned = (uint64_t)comparison->lists.count * options->seeds;
    retrainer->kept =
        (struct vw_saved_views){.views = comparison->compared.shown_views, .folder = comparison->pictures_folder};
    for (uint32_t s = 0; s < options->seeds; s++)
        for (uint32_t l = 0; !status && l < comparison->lists.count; l++) {
            const struct vw_retrain_params retraining = retraining_of(comparison, l, options->config.seed + s);
            retrainer->kept.count = s ? 0 : comparison->compared.shown_count;
            status = vw_retrain(retrainer, &retraining, &comparison->compared.outcomes[(size_t)l * options->seeds + s]);
        }
    return status;
}

// ---- Renders
// ------------------------------------------------------------------------------------------------------------

static enum vw_status write_render(struct comparison *comparison, uint32_t place) {
    char *pictures[VW_TEXTS_MOST] = {0}, *to = vw_format_text("%s/%u.png", comparison->renders_folder, place);
    enum vw_status status = to ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t l = 0; !status && l < comparison->lists.count; l++) {
        char id[VW_HASH_HEX_BYTES];
        const struct vw_retrain_params retraining = retraining_of(comparison, l, comparison->options->config.seed);
        vw_retrainer_name(&comparison->retrainer, &retraining, id);
        pictures[l] = vw_saved_view_path(&comparison->retrainer.kept, id, comparison->compared.shown_views[place]);
        if (!pictures[l]) status = VW_ERROR_MEMORY;
    }
    if (!status) status = vw_side_by_side_write(to, pictures, comparison->lists.count);
    for (uint32_t l = 0; l < comparison->lists.count; l++) free(pictures[l]);
    free(to);
    return status;
}

static enum vw_status finish(struct comparison *comparison) {
    const struct vw_set_comparison *compared = &comparison->compared;
    bool json = comparison->options->json;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < compared->shown_count; i++) status = write_render(comparison, i);
    if (!status) status = vw_set_comparison_write_csv(compared);
    if (!status) status = vw_set_comparison_write_json(compared, json);
    if (status) return status;
    const struct vw_report_params report = {compared->scene, comparison->options->device,
                                            comparison->options->no_thumbnails};
    char *report_path = vw_report_folder_finish(comparison->options->out, &report, NULL);
    if (!json) vw_set_comparison_print(compared);
    if (!json && report_path) printf("report      %s\n", report_path);
    free(report_path);
    return VW_OK;
}

// -------------------------------------------------------------------------------------------------------------------------

// Nothing is written before the lists are known to be sound.
static enum vw_status run(struct comparison *comparison) {
    vw_interrupt_watch();
    const struct vw_session_params params = vw_params_of_session(comparison->options);
    enum vw_status status = vw_session_open(&params, &comparison->retrainer.session);
    if (!status) status = plan(comparison);
    if (!status) status = vw_folder_create(comparison->pictures_folder);
    comparison->retrainer.whole_views = true;
    if (!status) status = vw_retrainer_open(comparison->options, &comparison->retrainer);
    const struct vw_session *session = &comparison->retrainer.session;
    comparison->compared.half_views = vw_effects_fit_views(session->effects, session->effect_count);
    if (!status) status = train(comparison);
    return status ? status : finish(comparison);
}

enum vw_status vw_command_compare(const struct vw_options *options) {
    struct comparison comparison = {.options = options};
    enum vw_status status = check(options);
    if (!status) status = run(&comparison);
    free(comparison.compared.outcomes);
    free(comparison.compared.pairs);
    free(comparison.compared.shown_views);
    free(comparison.renders_folder);
    free(comparison.pictures_folder);
    vw_photo_sets_free(&comparison.lists);
    vw_retrainer_close(&comparison.retrainer);
    return status;
}
