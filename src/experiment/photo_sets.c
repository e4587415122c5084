#include "experiment/photo_sets.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "base/text.h"
#include "experiment/experiment.h"
#include "ledger/find_image.h"
#include "run/imported/imported_run.h"
#include "run/recorded/scored_run.h"
#include "scene/builder.h"
#include "scene/formats/photo_list.h"
#include "viewworth/log.h"

static const uint64_t DRAW_SEED = (uint64_t)1 << 63; // seeds of trainings are smaller

// ---- What a list is ----

enum form { FORM_ALL, FORM_RANDOM, FORM_SELECTION, FORM_FILE, FORM_SCORES, FORM_UNKNOWN };

struct list_rule {
    enum form form;
    struct vw_selection_params selection;
    char *path;   // owned; of a file
    double least; // least imported score
};

// Reads FILE.csv@LEAST; an @ may also be part of the file's name.
static bool read_scores_rule(const char *word, struct list_rule *rule) {
    const char *at = strrchr(word, '@');
    char *end = NULL;
    if (!at) return false;
    rule->least = strtod(at + 1, &end);
    if (end == at + 1 || *end || !isfinite(rule->least)) return false;
    rule->path = vw_format_text("%.*s", (int)(at - word), word);
    return rule->path && vw_file_exists(rule->path);
}

// Words come before files: a file named "all" is ./all. A file may be removed before the lists are made.
// Free the path of `*rule` in any case.
static enum vw_status read_list_rule(const struct vw_photo_sets_params *params, const char *word,
                                     struct list_rule *rule) {
    *rule = (struct list_rule){.form = FORM_UNKNOWN, .selection = {.method = params->method}};
    if (!strcmp(word, "all")) rule->form = FORM_ALL;
    else if (!strcmp(word, "random")) rule->form = FORM_RANDOM;
    else if (vw_selection_read_rule(word, &rule->selection)) rule->form = FORM_SELECTION;
    else if (vw_file_exists(word)) rule->form = FORM_FILE;
    else if (read_scores_rule(word, rule)) rule->form = FORM_SCORES;
    if (rule->form == FORM_FILE) rule->path = vw_copy_text(word);
    if (rule->form == FORM_UNKNOWN)
        return vw_fail(VW_ERROR_USAGE, "neither a file nor SCORES.csv@LEAST nor one of all, random, %s",
                       VW_SELECTION_RULES);
    return rule->form == FORM_FILE && !rule->path ? VW_ERROR_MEMORY : VW_OK;
}

static enum vw_status check(const struct vw_photo_sets_params *params, uint32_t place) {
    const char *word = params->lists[place];
    struct list_rule rule;
    enum vw_status status = read_list_rule(params, word, &rule);
    free(rule.path);
    if (status) return vw_fail_context(status, "--list %s", word);
    if (!vw_text_is_clean(word))
        return vw_fail(VW_ERROR_USAGE, "--list: a name is not UTF-8 or holds control characters; rename the file");
    if (rule.form == FORM_SELECTION && !params->scores)
        return vw_fail(VW_ERROR_USAGE, "--list %s: selects by scores; name the valued run by --scores OUT", word);
    if (rule.form == FORM_RANDOM && !place)
        return vw_fail(VW_ERROR_USAGE,
                       "--list random: takes as many photos as the list before it; put another list before it");
    return VW_OK;
}

enum vw_status vw_photo_sets_check(const struct vw_photo_sets_params *params) {
    if (!params->list_count)
        return vw_fail(VW_ERROR_USAGE,
                       "--list is missing; name the lists to compare, for instance --list all --list FILE");
    if (params->list_count > VW_PHOTO_SETS_MAX)
        return vw_fail(VW_ERROR_USAGE, "--list: at most %d lists can be compared", VW_PHOTO_SETS_MAX);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < params->list_count; i++) status = check(params, i);
    return status;
}

// ---- Names ----

static bool is_taken(const struct vw_photo_sets *sets, const char *name) {
    for (uint32_t i = 0; i < sets->count; i++)
        if (!strcmp(sets->lists[i].name, name)) return true;
    return false;
}

// Returns a file's name without folder and extension; the threshold of scores follows it.
static char *stem_of(const struct list_rule *rule, const char *word) {
    if (!rule->path) return vw_copy_text(word);
    const char *slash = strrchr(rule->path, '/'), *base = slash ? slash + 1 : rule->path, *dot = strrchr(base, '.');
    int length = (int)(dot && dot > base ? (size_t)(dot - base) : strlen(base));
    return vw_format_text("%.*s%s", length, base, rule->form == FORM_SCORES ? strrchr(word, '@') : "");
}

static char *name_list(const struct vw_photo_sets *sets, const struct list_rule *rule, const char *word) {
    char *stem = stem_of(rule, word), *name = stem ? vw_copy_text(stem) : NULL;
    for (uint32_t number = 2; name && is_taken(sets, name); number++) {
        free(name);
        name = vw_format_text("%s_%u", stem, number);
    }
    free(stem);
    return name;
}

// ---- By scores ----

static const struct vw_view *find_train_view(const struct vw_scene *scene, const char *name) {
    const struct vw_view *view = vw_scene_find_view(scene, name);
    return view && view->split == VW_SPLIT_TRAIN ? view : NULL;
}

static bool trains(const struct vw_ledger_image *image) { return !strcmp(image->split, vw_split_name(VW_SPLIT_TRAIN)); }

// Checks that the run has valued exactly the photos that may be trained on. Names must be equal, sizes need not.
static enum vw_status check_photos(const struct vw_scored_run *run, const struct vw_scene *scene) {
    const char *out = run->recorded.out;
    uint32_t valued = 0;
    for (uint32_t i = 0; i < run->image_count; i++) {
        if (!trains(&run->images[i])) continue;
        valued++;
        if (!find_train_view(scene, run->images[i].name))
            return vw_fail(VW_ERROR_INPUT,
                           "--scores %s: has a score for %s, which is not a photo to train on in %s; value this scene "
                           "with these splits",
                           out, run->images[i].name, scene->path);
    }
    if (valued == scene->split_count[VW_SPLIT_TRAIN]) return VW_OK;
    return vw_fail(
        VW_ERROR_INPUT,
        "--scores %s: has scores for %u photos, but %u are to train on in %s; value this scene with these splits", out,
        valued, scene->split_count[VW_SPLIT_TRAIN], scene->path);
}

static enum vw_status select_photos(const struct vw_scored_run *run, const struct list_rule *rule,
                                    const struct vw_scene *scene, bool *chosen) {
    struct vw_selection selection = {0};
    enum vw_status status = vw_scored_run_select(run, &rule->selection, &selection);
    for (uint32_t i = 0; i < selection.count; i++) {
        const struct vw_ledger_image *image =
            vw_ledger_find_image(run->images, run->image_count, selection.image_ids[i]);
        const struct vw_view *view = image ? find_train_view(scene, image->name) : NULL;
        if (view) chosen[view - scene->views] = true; // check_photos() has found them all
    }
    vw_selection_free(&selection);
    return status;
}

// Counts the changed photos. The bytes of photo files do not depend on --downscale; recipes and corrupted photos, which
// have ground-truth labels, are made at that size.
static uint32_t count_changed(const struct vw_scored_run *run, uint32_t our_downscale, const struct vw_scene *scene) {
    const json_t *downscale = json_object_get(run->scene_options, "downscale");
    bool same_size = (downscale ? json_integer_value(downscale) : 1) == (our_downscale ? our_downscale : 1);
    uint32_t changed = 0;
    for (uint32_t i = 0; i < run->image_count; i++) {
        const struct vw_view *view = trains(&run->images[i]) ? find_train_view(scene, run->images[i].name) : NULL;
        char hash[VW_HASH_HEX_BYTES];
        if (!view || !run->images[i].sha256 || (view->ground_truth && !same_size)) continue;
        vw_hash_to_hex(view->sha256, hash);
        changed += strcmp(hash, run->images[i].sha256) != 0;
    }
    return changed;
}

static void warn(const struct vw_scored_run *run, const struct vw_experiment_params *common,
                 const struct vw_scene *scene) {
    const struct vw_ledger_run *row = &run->recorded.row;
    uint64_t first = common->config->seed;
    vw_scored_run_warn(run, common->scene.corrupt);
    if (vw_is_imported(row)) return; // it has neither our seeds nor hashes of the photos
    uint32_t changed = count_changed(run, common->scene.downscale, scene);
    if (changed)
        vw_log_warning("--scores %s: %u photos have changed since they were valued", run->recorded.out, changed);
    if (row->seed >= 0 && (uint64_t)row->seed >= first && (uint64_t)row->seed - first < common->seeds)
        vw_log_warning("--scores %s: was valued with seed %" PRId64
                       ", which the comparison uses, too: chance in that seed favours the lists selected by these "
                       "scores; take another --seed",
                       run->recorded.out, row->seed);
}

// ---- Making lists ----

// Marks the photos of a list that is not random.
static enum vw_status choose(const struct vw_scored_run *run, const struct list_rule *rule,
                             const struct vw_photo_set *list, const struct vw_scene *scene, bool *chosen) {
    uint32_t passed_over = 0;
    enum vw_status status = VW_OK;
    if (rule->form == FORM_ALL)
        for (uint32_t v = 0; v < scene->view_count; v++) chosen[v] = scene->views[v].split == VW_SPLIT_TRAIN;
    else if (rule->form == FORM_SELECTION) status = select_photos(run, rule, scene, chosen);
    else
        status = vw_train_list_read(scene, rule->path, rule->form == FORM_SCORES ? &rule->least : NULL, chosen,
                                    &passed_over);
    if (!status && passed_over)
        vw_log_info("list     %s: %u of its photos are not to train on and are skipped", list->name, passed_over);
    return status;
}

static enum vw_status take_chosen(const struct vw_photo_sets *sets, const bool *chosen, struct vw_photo_set *list) {
    for (uint32_t i = 0; i < sets->train_count; i++)
        if (chosen[sets->train_views[i]]) list->views[list->count++] = sets->train_views[i];
    if (list->count > 1) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "has a single photo; a list needs at least 2 to train on");
}

// Plans as many photos as the list before it.
static enum vw_status plan_random(const struct vw_photo_sets *sets, struct vw_photo_set *list) {
    list->random = true;
    list->count = sets->lists[sets->count - 1].count;
    if (list->count < sets->train_count) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "the list before it, %s, has all photos; put a shorter one before it",
                   sets->lists[sets->count - 1].name);
}

// Returns the epochs of a list. With equal steps it takes about as many steps as all photos, so that all lists cost the
// same.
static uint32_t epochs_of(uint32_t config_epochs, enum vw_equal equal, uint32_t train_count, uint32_t photos) {
    double epochs = config_epochs;
    if (equal == VW_EQUAL_STEPS) epochs = fmin(fmax(round(epochs * train_count / photos), 1), UINT32_MAX);
    return (uint32_t)epochs;
}

static enum vw_status make_list(const struct vw_photo_sets_params *params, uint32_t config_epochs,
                                const struct vw_scene *scene, const struct vw_scored_run *run, const char *word,
                                struct vw_photo_sets *sets) {
    struct vw_photo_set *list = &sets->lists[sets->count];
    struct list_rule rule;
    bool *chosen = vw_allocate(scene->view_count, sizeof *chosen);
    enum vw_status status = read_list_rule(params, word, &rule);
    if (!status) list->name = name_list(sets, &rule, word);
    list->views = vw_allocate(sets->train_count, sizeof *list->views);
    if (!status && (!chosen || !list->name || !list->views)) status = VW_ERROR_MEMORY;
    if (!status && rule.form == FORM_RANDOM) status = plan_random(sets, list);
    else if (!status) {
        status = choose(run, &rule, list, scene, chosen);
        if (!status) status = take_chosen(sets, chosen, list);
    }
    if (!status) list->epochs = epochs_of(config_epochs, params->equal, sets->train_count, list->count);
    sets->by_scores |= rule.form == FORM_SELECTION;
    sets->count++; // also after a failure: vw_photo_sets_free() frees what was made
    free(chosen);
    free(rule.path);
    return status;
}

enum vw_status vw_photo_sets_make(const struct vw_photo_sets_params *params, const struct vw_experiment_params *common,
                                  const struct vw_scene *scene, struct vw_photo_sets *sets) {
    struct vw_scored_run run = {0};
    *sets = (struct vw_photo_sets){0};
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &sets->train_views, &sets->train_count);
    if (!status && params->scores) status = vw_scored_run_open(params->scores, &run);
    if (!status && params->scores) status = check_photos(&run, scene);
    for (uint32_t i = 0; !status && i < params->list_count; i++) {
        status = make_list(params, common->config->epochs, scene, &run, params->lists[i], sets);
        if (status) vw_fail_context(status, "--list %s", params->lists[i]);
    }
    if (!status && sets->by_scores) warn(&run, common, scene);
    vw_scored_run_close(&run);
    return status;
}

void vw_photo_sets_free(struct vw_photo_sets *sets) {
    for (uint32_t i = 0; i < sets->count; i++) {
        free(sets->lists[i].name);
        free(sets->lists[i].views);
    }
    free(sets->train_views);
}

// ---- Using them ----

const uint32_t *vw_photo_sets_draw(struct vw_photo_sets *sets, uint32_t place, uint64_t seed) {
    struct vw_photo_set *list = &sets->lists[place];
    if (!list->random) return list->views;
    vw_random_order(DRAW_SEED | seed, place, sets->train_count, list->views);
    vw_sort_places(list->views, list->count);
    for (uint32_t i = 0; i < list->count; i++) list->views[i] = sets->train_views[list->views[i]];
    return list->views;
}

bool vw_photo_set_has(const struct vw_photo_set *list, uint32_t view) {
    for (uint32_t i = 0; i < list->count; i++)
        if (list->views[i] == view) return true;
    return false;
}
