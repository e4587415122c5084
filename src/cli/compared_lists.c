#include "cli/compared_lists.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/train_list.h"
#include "viewworth/file.h"
#include "viewworth/ledger.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/random.h"
#include "viewworth/selection.h"
#include "viewworth/statistics.h"

static const uint64_t DRAW_SEED = (uint64_t)1 << 63; // seeds of trainings lie below

// ---- What a list is -----------------------------------------------------------------------------------------------------

enum form { FORM_ALL, FORM_RANDOM, FORM_SELECTION, FORM_FILE, FORM_SCORES, FORM_UNKNOWN };

struct wish {
    enum form form;
    struct vw_selection_params selection;
    char *path;   // owned; of a file
    double least; // of imported scores
};

// The number that a text is, whole; `*percent` when a % follows.
static bool read_amount(const char *text, double *amount, bool *percent) {
    char *end = NULL;
    *amount = strtod(text, &end);
    *percent = *end == '%';
    return end != text && !end[*percent] && isfinite(*amount);
}

static bool read_rule(const char *word, struct vw_selection_params *selection) {
    bool top = strncmp(word, "top:", 4) == 0, drop = strncmp(word, "drop:", 5) == 0;
    if (!strcmp(word, "positive")) selection->rule = VW_SELECT_POSITIVE;
    else if (!strcmp(word, "significant")) selection->rule = VW_SELECT_SIGNIFICANT;
    else if (top || drop) selection->rule = top ? VW_SELECT_TOP : VW_SELECT_DROP;
    else return false;
    return !(top || drop) || read_amount(strchr(word, ':') + 1, &selection->amount, &selection->percent);
}

// FILE.csv@LEAST; an @ may be part of the file's name as well.
static bool read_scores_wish(const char *word, struct wish *wish) {
    const char *at = strrchr(word, '@');
    bool percent = false;
    if (!at || !read_amount(at + 1, &wish->least, &percent) || percent) return false;
    wish->path = vw_format_text("%.*s", (int)(at - word), word);
    return wish->path && vw_file_exists(wish->path);
}

// Words come before files: a file of such a name is ./all. `*wish` is to be freed (path) in any case.
static enum vw_status read_wish(const struct vw_options *options, const char *word, struct wish *wish) {
    *wish = (struct wish){.form = FORM_UNKNOWN, .selection = {.method = options->method}};
    if (!strcmp(word, "all")) wish->form = FORM_ALL;
    else if (!strcmp(word, "random")) wish->form = FORM_RANDOM;
    else if (read_rule(word, &wish->selection)) wish->form = FORM_SELECTION;
    else if (vw_file_exists(word)) wish->form = FORM_FILE;
    else if (read_scores_wish(word, wish)) wish->form = FORM_SCORES;
    if (wish->form == FORM_FILE) wish->path = vw_copy_text(word);
    return wish->form == FORM_FILE && !wish->path ? VW_ERROR_MEMORY : VW_OK;
}

static enum vw_status check(const struct vw_options *options, uint32_t place) {
    const char *word = options->lists.texts[place];
    struct wish wish;
    enum vw_status status = read_wish(options, word, &wish);
    free(wish.path);
    if (status) return status;
    if (wish.form == FORM_UNKNOWN)
        return vw_fail(
            VW_ERROR_USAGE,
            "--list %s: neither a file nor SCORES.csv@LEAST nor one of all, positive, significant, top:K, top:P%%, drop:P%%, random", word);
    if (!vw_name_is_clean(word)) return vw_fail(VW_ERROR_USAGE, "--list: a name is no UTF-8 or holds control characters; rename the file");
    if (wish.form == FORM_SELECTION && !options->scores)
        return vw_fail(VW_ERROR_USAGE, "--list %s: chooses by scores; name the valued run by --scores OUT", word);
    if (wish.form == FORM_RANDOM && !place)
        return vw_fail(VW_ERROR_USAGE, "--list random: has as many photos as the list before it; put it behind one");
    return VW_OK;
}

enum vw_status vw_compared_lists_check(const struct vw_options *options) {
    if (!options->lists.count)
        return vw_fail(VW_ERROR_USAGE,
                       "compare: --list is missing; name the sets of photos to compare, for instance --list all --list FILE");
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < options->lists.count; i++) status = check(options, i);
    return status;
}

// ---- Names --------------------------------------------------------------------------------------------------------------

static bool is_taken(const struct vw_compared_lists *lists, const char *name) {
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

static char *name_list(const struct vw_compared_lists *lists, const struct wish *wish, const char *word) {
    char *stem = stem_of(wish, word), *name = stem ? vw_copy_text(stem) : NULL;
    for (uint32_t number = 2; name && is_taken(lists, name); number++) {
        free(name);
        name = vw_format_text("%s_%u", stem, number);
    }
    free(stem);
    return name;
}

// ---- By scores ----------------------------------------------------------------------------------------------------------

static const struct vw_view *find_train_view(const struct vw_scene *scene, const char *name) {
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (!strcmp(scene->views[v].name, name)) return scene->views[v].split == VW_SPLIT_TRAIN ? &scene->views[v] : NULL;
    return NULL;
}

// Scores tell the photos that were valued apart; of others they say nothing. Names must be the same, sizes need not.
static enum vw_status check_photos(const char *run, const struct vw_ledger_image *images, uint32_t count, const struct vw_scene *scene) {
    uint32_t valued = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (strcmp(images[i].split, vw_split_name(VW_SPLIT_TRAIN)) != 0) continue;
        valued++;
        if (!find_train_view(scene, images[i].name))
            return vw_fail(VW_ERROR_INPUT, "--scores %s: values %s, which is no photo to train on in %s; value this scene, with its splits",
                           run, images[i].name, scene->path);
    }
    if (valued == scene->split_count[VW_SPLIT_TRAIN]) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "--scores %s: values %u photos, and %u are to train on in %s; value this scene, with its splits", run,
                   valued, scene->split_count[VW_SPLIT_TRAIN], scene->path);
}

static void mark_selected(const struct vw_selection *selection, const struct vw_ledger_image *images, uint32_t image_count,
                          const struct vw_scene *scene, bool *chosen) {
    for (uint32_t i = 0; i < selection->count; i++)
        for (uint32_t image = 0; image < image_count; image++)
            if (images[image].image_id == selection->image_ids[i]) chosen[find_train_view(scene, images[image].name) - scene->views] = true;
}

static enum vw_status select_photos(const char *run, const struct wish *wish, const struct vw_scene *scene, bool *chosen) {
    struct vw_ledger *ledger = NULL;
    const struct vw_ledger_image *images = NULL;
    struct vw_ledger_score *scores = NULL;
    struct vw_selection selection = {0};
    uint32_t image_count = 0, score_count = 0;
    char *path = vw_path_join(run, "ledger.db");
    enum vw_status status = path ? vw_ledger_open(path, &ledger) : VW_ERROR_MEMORY;
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status) status = vw_ledger_get_scores(ledger, &scores, &score_count);
    if (!status) status = check_photos(run, images, image_count, scene);
    if (!status) status = vw_selection_make(scores, score_count, images, image_count, &wish->selection, &selection);
    if (!status) mark_selected(&selection, images, image_count, scene, chosen);
    vw_selection_free(&selection);
    free(scores);
    vw_ledger_close(&ledger);
    free(path);
    return status;
}

// ---- Making lists -------------------------------------------------------------------------------------------------------

static enum vw_status list_train_views(const struct vw_scene *scene, struct vw_compared_lists *lists) {
    lists->train_views = vw_allocate(scene->view_count, sizeof *lists->train_views);
    if (!lists->train_views) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_TRAIN) lists->train_views[lists->train_count++] = v;
    return VW_OK;
}

// Marks the photos of a list that is not random.
static enum vw_status choose(const struct vw_options *options, const struct wish *wish, const struct vw_compared_list *list,
                             const struct vw_scene *scene, bool *chosen) {
    uint32_t passed_over = 0;
    enum vw_status status = VW_OK;
    if (wish->form == FORM_ALL)
        for (uint32_t v = 0; v < scene->view_count; v++) chosen[v] = scene->views[v].split == VW_SPLIT_TRAIN;
    else if (wish->form == FORM_SELECTION) status = select_photos(options->scores, wish, scene, chosen);
    else status = vw_train_list_read(scene, wish->path, wish->form == FORM_SCORES ? &wish->least : NULL, chosen, &passed_over);
    if (!status && passed_over) vw_log_info("list     %s: %u photos that it names are passed over", list->name, passed_over);
    return status;
}

static enum vw_status take_chosen(const struct vw_compared_lists *lists, const bool *chosen, struct vw_compared_list *list) {
    for (uint32_t i = 0; i < lists->train_count; i++)
        if (chosen[lists->train_views[i]]) list->views[list->count++] = lists->train_views[i];
    if (list->count > 1) return VW_OK;
    return vw_fail(VW_ERROR_INPUT, "has a single photo; a list takes at least 2 to train on");
}

// As many as the list before it.
static enum vw_status plan_random(const struct vw_compared_lists *lists, struct vw_compared_list *list) {
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

static enum vw_status make_list(const struct vw_options *options, const struct vw_scene *scene, const struct wish *wish, const char *word,
                                struct vw_compared_lists *lists) {
    struct vw_compared_list *list = &lists->lists[lists->count];
    bool *chosen = vw_allocate(scene->view_count, sizeof *chosen);
    list->name = name_list(lists, wish, word);
    list->views = vw_allocate(lists->train_count, sizeof *list->views);
    enum vw_status status = chosen && list->name && list->views ? VW_OK : VW_ERROR_MEMORY;
    if (!status && wish->form == FORM_RANDOM) status = plan_random(lists, list);
    else if (!status) {
        status = choose(options, wish, list, scene, chosen);
        if (!status) status = take_chosen(lists, chosen, list);
    }
    if (!status) list->epochs = epochs_of(options, lists->train_count, list->count);
    lists->count++; // what there is of it is freed in any case
    free(chosen);
    return status;
}

enum vw_status vw_compared_lists_make(const struct vw_options *options, const struct vw_scene *scene, struct vw_compared_lists *lists) {
    *lists = (struct vw_compared_lists){0};
    enum vw_status status = list_train_views(scene, lists);
    for (uint32_t i = 0; !status && i < options->lists.count; i++) {
        const char *word = options->lists.texts[i];
        struct wish wish;
        status = read_wish(options, word, &wish);
        if (!status) status = make_list(options, scene, &wish, word, lists);
        if (status) vw_fail_context(status, "--list %s", word);
        free(wish.path);
    }
    return status;
}

void vw_compared_lists_free(struct vw_compared_lists *lists) {
    for (uint32_t i = 0; i < lists->count; i++) {
        free(lists->lists[i].name);
        free(lists->lists[i].views);
    }
    free(lists->train_views);
}

// ---- Using them ---------------------------------------------------------------------------------------------------------

const uint32_t *vw_compared_lists_draw(struct vw_compared_lists *lists, uint32_t place, uint64_t seed) {
    struct vw_compared_list *list = &lists->lists[place];
    if (!list->random) return list->views;
    vw_random_order(DRAW_SEED | seed, place, lists->train_count, list->views);
    vw_sort_places(list->views, list->count);
    for (uint32_t i = 0; i < list->count; i++) list->views[i] = lists->train_views[list->views[i]];
    return list->views;
}

bool vw_compared_list_has(const struct vw_compared_list *list, uint32_t view) {
    for (uint32_t i = 0; i < list->count; i++)
        if (list->views[i] == view) return true;
    return false;
}
