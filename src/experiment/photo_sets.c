#include "experiment/photo_sets.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run/imported.h"
#include "run/scored_run.h"
#include "ledger/find_image.h"
#include "scene/builder.h"
#include "scene/formats/train_list.h"
#include "base/file.h"
#include "base/hash.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

static const uint64_t DRAW_SEED = (uint64_t)1 << 63; // seeds of trainings lie below

// ---- What a list is
// -----------------------------------------------------------------------------------------------------

enum form { FORM_ALL, FORM_RANDOM, FORM_SELECTION, FORM_FILE, FORM_SCORES, FORM_UNKNOWN };

struct wish {
    enum form form;
    struct vw_selection_params selection;
    char *path;   // owned; of a file
    double least; // of imported scores
};

static bool read_rule(const char *word, struct vw_selection_params *selection) {
    bool top = strncmp(word, "top:", 4) == 0, drop = strncmp(word, "drop:", 5) == 0;
    if (!strcmp(word, "positive")) selection->rule = VW_SELECT_POSITIVE;
    else if (!strcmp(word, "significant")) selection->rule = VW_SELECT_SIGNIFICANT;
    else if (!strcmp(word, "not-harmful")) selection->rule = VW_SELECT_NOT_HARMFUL;
    else if (top || drop) selection->rule = top ? VW_SELECT_TOP : VW_SELECT_DROP;
    else return false;
    return !(top || drop) || vw_selection_read_amount(strchr(word, ':') + 1, selection);
}

// FILE.csv@LEAST; an @ may be part of the file's name as well.
static bool read_scores_wish(const char *word, struct wish *wish) {
    const char *at = strrchr(word, '@');
    char *end = NULL;
    if (!at) return false;
    wish->least = strtod(at + 1, &end);
    if (end == at + 1 || *end || !isfinite(wish->least)) return false;
    wish->path = vw_format_text("%.*s", (int)(at - word), word);
    return wish->path && vw_file_exists(wish->path);
}

// Words come before files: a file of such a name is ./all. A file may be gone by the time that the lists are made.
// `*wish` is to be freed (path) in any case.
static enum vw_status read_wish(const struct vw_options *options, const char *word, struct wish *wish) {
    *wish = (struct wish){.form = FORM_UNKNOWN, .selection = {.method = options->method}};
    if (!strcmp(word, "all")) wish->form = FORM_ALL;
    else if (!strcmp(word, "random")) wish->form = FORM_RANDOM;
    else if (read_rule(word, &wish->selection)) wish->form = FORM_SELECTION;
    else if (vw_file_exists(word)) wish->form = FORM_FILE;
    else if (read_scores_wish(word, wish)) wish->form = FORM_SCORES;
    if (wish->form == FORM_FILE) wish->path = vw_copy_text(word);
    if (wish->form == FORM_UNKNOWN)
        return vw_fail(VW_ERROR_USAGE,
                       "neither a file nor SCORES.csv@LEAST nor one of all, positive, significant, not-harmful, top:K, "
                       "top:P%%, drop:P%%, random");
    return wish->form == FORM_FILE && !wish->path ? VW_ERROR_MEMORY : VW_OK;
}

static enum vw_status check(const struct vw_options *options, uint32_t place) {
    const char *word = options->lists.texts[place];
    struct wish wish;
    enum vw_status status = read_wish(options, word, &wish);
    free(wish.path);
    if (status) return vw_fail_context(status, "--list %s", word);
    if (!vw_name_is_clean(word))
        return vw_fail(VW_ERROR_USAGE, "--list: a name is no UTF-8 or holds baseline characters; rename the file");
    if (wish.form == FORM_SELECTION && !options->scores)
        return vw_fail(VW_ERROR_USAGE, "--list %s: chooses by scores; name the valued run by --scores OUT", word);
    if (wish.form == FORM_RANDOM && !place)
        return vw_fail(VW_ERROR_USAGE, "--list random: has as many photos as the list before it; put it behind one");
    return VW_OK;
}

enum vw_status vw_photo_sets_check(const struct vw_options *options) {
    if (!options->lists.count)
        return vw_fail(
            VW_ERROR_USAGE,
            "compare: --list is missing; name the sets of photos to compare, for instance --list all --list FILE");
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < options->lists.count; i++) status = check(options, i);
    return status;
}

// ---- Names
// --------------------------------------------------------------------------------------------------------------

static bool is_taken(const struct vw_photo_sets *lists, const char *name) {
    for (uint32_t i = 0; i < lists->count; i++)
        if (!strcmp(lists->lists[i].name, name)) return true;
    return false;
}

// Of a file what stands between its folder and its extension, with the threshold of scores behind it.
static char *stem_of(const struct wish *wish, const char *word) {
    if (!wish->path) return vw_copy_text(word);
    const char *slash = strrchr(wish->path, '/'), *base = slash ? slash + 1 : wish->path, *dot = strrchr(base, '.');
    int length = (int)(dot && dot > base ? (size_t)(dot - base) : strlen(base));
    return vw_format_text("%.*s%s", length, base, wish->form == FORM_SCORES ? strrchr(word, '@') : "");
}

static char *name_list(const struct vw_photo_sets *lists, const struct wish *wish, const char *word) {
    char *stem = stem_of(wish, word), *name = stem ? vw_copy_text(stem) : NULL;
    for (uint32_t number = 2; name && is_taken(lists, name); number++) {
        free(name);
        name = vw_format_text("%s_%u", stem, number);
    }
    free(stem);
    return name;
}

// ---- By scores
// ----------------------------------------------------------------------------------------------------------

static const struct vw_view *find_train_view(const struct vw_scene *scene, const char *name) {
    const struct vw_view *view = vw_scene_find_view(scene, name);
    return view && view->split == VW_SPLIT_TRAIN ? view : NULL;
}

static bool trains(const struct vw_ledger_image *image) { return !strcmp(image->split, vw_split_name(VW_SPLIT_TRAIN)); }

// Scores tell the photos that were valued apart; of others they say nothing. Names must be the same, sizes need not.
static enum vw_status check_photos(const struct vw_scored_run *run, const struct vw_scene *scene) {
    const char *out = run->recorded.out;
    uint32_t valued = 0;
    for (uint32_t i = 0; i < run->image_count; i++) {
        if (!trains(&run->images[i])) continue;
        valued++;
        if (!find_train_view(scene, run->images[i].name))
            return vw_fail(
                VW_ERROR_INPUT,
                "--scores %s: values %s, which is no photo to train on in %s; value this scene, with its splits", out,
                run->images[i].name, scene->path);
    }
    if (valued == scene->split_count[VW_SPLIT_TRAIN]) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "--scores %s: values %u photos, and %u are to train on in %s; value this scene, with its splits",
                   out, valued, scene->split_count[VW_SPLIT_TRAIN], scene->path);
}

static enum vw_status select_photos(const struct vw_scored_run *run, const struct wish *wish,
                                    const struct vw_scene *scene, bool *chosen) {
    struct vw_selection selection = {0};
    enum vw_status status = vw_scored_run_select(run, &wish->selection, &selection);
    for (uint32_t i = 0; i < selection.count; i++) {
        const struct vw_ledger_image *image =
            vw_ledger_find_image(run->images, run->image_count, selection.image_ids[i]);
        const struct vw_view *view = image ? find_train_view(scene, image->name) : NULL;
        if (view) chosen[view - scene->views] = true; // all are, as long as the photos are those that were checked
    }
    vw_selection_free(&selection);
    return status;
}

// Bytes of files are the same at any size; those of recipes and of corrupted photos, of which a truth is known, are
// made at this one.
static uint32_t count_changed(const struct vw_scored_run *run, const struct vw_options *options,
                              const struct vw_scene *scene) {
    const json_t *downscale = json_object_get(run->scene_options, "downscale");
    bool same_size = (downscale ? json_integer_value(downscale) : 1) == options->downscale;
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

// What makes a comparison of lists chosen by the run doubtful.
static void warn(const struct vw_scored_run *run, const struct vw_options *options, const struct vw_scene *scene) {
    const struct vw_ledger_run *row = &run->recorded.row;
    uint64_t first = options->config.seed;
    vw_scored_run_warn(run, options->corrupt);
    if (vw_is_imported(row)) return; // from other seeds, and of names alone
    uint32_t changed = count_changed(run, options, scene);
    if (changed)
        vw_log_warning("--scores %s: %u photos have changed since they were valued", run->recorded.out, changed);
    if (row->seed >= 0 && (uint64_t)row->seed >= first && (uint64_t)row->seed - first < options->seeds)
        vw_log_warning("--scores %s: was valued with seed %" PRId64
                       ", which is compared with as well: what was luck there is counted again "
                       "for its lists; give another --seed",
                       run->recorded.out, row->seed);
}

// ---- Making lists
// -------------------------------------------------------------------------------------------------------

// Marks the photos of a list that is not random.
static enum vw_status choose(const struct vw_scored_run *run, const struct wish *wish, const struct vw_photo_set *list,
                             const struct vw_scene *scene, bool *chosen) {
    uint32_t passed_over = 0;
    enum vw_status status = VW_OK;
    if (wish->form == FORM_ALL)
        for (uint32_t v = 0; v < scene->view_count; v++) chosen[v] = scene->views[v].split == VW_SPLIT_TRAIN;
    else if (wish->form == FORM_SELECTION) status = select_photos(run, wish, scene, chosen);
    else
        status = vw_train_list_read(scene, wish->path, wish->form == FORM_SCORES ? &wish->least : NULL, chosen,
                                    &passed_over);
    if (!status && passed_over)
        vw_log_info("list     %s: %u photos that it names are passed over", list->name, passed_over);
    return status;
}

static enum vw_status take_chosen(const struct vw_photo_sets *lists, const bool *chosen, struct vw_photo_set *list) {
    for (uint32_t i = 0; i < lists->train_count; i++)
        if (chosen[lists->train_views[i]]) list->views[list->count++] = lists->train_views[i];
    if (list->count > 1) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "has a single photo; a list takes at least 2 to train on");
}

// As many as the list before it.
static enum vw_status plan_random(const struct vw_photo_sets *lists, struct vw_photo_set *list) {
    list->random = true;
    list->count = lists->lists[lists->count - 1].count;
    if (list->count < lists->train_count) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "the list before it, %s, has all photos; put it behind a shorter one",
                   lists->lists[lists->count - 1].name);
}

// With equal steps, as many epochs as give about the steps of all photos, so that all lists cost the same.
static uint32_t epochs_of(const struct vw_options *options, uint32_t train_count, uint32_t photos) {
    double epochs = options->config.epochs;
    if (options->equal == VW_EQUAL_STEPS) epochs = fmin(fmax(round(epochs * train_count / photos), 1), UINT32_MAX);
    return (uint32_t)epochs;
}

static enum vw_status make_list(const struct vw_options *options, const struct vw_scene *scene,
                                const struct vw_scored_run *run, const char *word, struct vw_photo_sets *lists) {
    struct vw_photo_set *list = &lists->lists[lists->count];
    struct wish wish;
    bool *chosen = vw_allocate(scene->view_count, sizeof *chosen);
    enum vw_status status = read_wish(options, word, &wish);
    if (!status) list->name = name_list(lists, &wish, word);
    list->views = vw_allocate(lists->train_count, sizeof *list->views);
    if (!status && (!chosen || !list->name || !list->views)) status = VW_ERROR_MEMORY;
    if (!status && wish.form == FORM_RANDOM) status = plan_random(lists, list);
    else if (!status) {
        status = choose(run, &wish, list, scene, chosen);
        if (!status) status = take_chosen(lists, chosen, list);
    }
    if (!status) list->epochs = epochs_of(options, lists->train_count, list->count);
    lists->by_scores |= wish.form == FORM_SELECTION;
    lists->count++; // what there is of it is freed in any case
    free(chosen);
    free(wish.path);
    return status;
}

enum vw_status vw_photo_sets_make(const struct vw_options *options, const struct vw_scene *scene,
                                  struct vw_photo_sets *lists) {
    struct vw_scored_run run = {0};
    *lists = (struct vw_photo_sets){0};
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &lists->train_views, &lists->train_count);
    if (!status && options->scores) status = vw_scored_run_open(options->scores, &run);
    if (!status && options->scores) status = check_photos(&run, scene);
    for (uint32_t i = 0; !status && i < options->lists.count; i++) {
        status = make_list(options, scene, &run, options->lists.texts[i], lists);
        if (status) vw_fail_context(status, "--list %s", options->lists.texts[i]);
    }
    if (!status && lists->by_scores) warn(&run, options, scene);
    vw_scored_run_close(&run);
    return status;
}

void vw_photo_sets_free(struct vw_photo_sets *lists) {
    for (uint32_t i = 0; i < lists->count; i++) {
        free(lists->lists[i].name);
        free(lists->lists[i].views);
    }
    free(lists->train_views);
}

// ---- Using them
// ---------------------------------------------------------------------------------------------------------

const uint32_t *vw_photo_sets_draw(struct vw_photo_sets *lists, uint32_t place, uint64_t seed) {
    struct vw_photo_set *list = &lists->lists[place];
    if (!list->random) return list->views;
    vw_random_order(DRAW_SEED | seed, place, lists->train_count, list->views);
    vw_sort_places(list->views, list->count);
    for (uint32_t i = 0; i < list->count; i++) list->views[i] = lists->train_views[list->views[i]];
    return list->views;
}

bool vw_photo_set_has(const struct vw_photo_set *list, uint32_t view) {
    for (uint32_t i = 0; i < list->count; i++)
        if (list->views[i] == view) return true;
    return false;
}
