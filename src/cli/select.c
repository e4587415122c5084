#include "viewworth/selection.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "cli/imported.h"
#include "cli/json_output.h"
#include "cli/recorded_run.h"
#include "ledger/find_image.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/photo_list.h"
#include "viewworth/value.h"

struct choice {
    const struct vw_options *options;
    struct vw_selection_params params;
    struct vw_recorded_run run;
    json_t *scene_options; // owned: what the run's scene was opened with
    const struct vw_ledger_image *images;
    uint32_t image_count, train_count;
    struct vw_selection selection;
    const char *format;
    bool opens; // the list is a scene
};

// ---- What is asked for --------------------------------------------------------------------------------------------------

// "K" or "P%"; the range is the selection's to check.
static enum vw_status parse_amount(const char *option, const char *text, struct vw_selection_params *params) {
    char *end = NULL;
    params->amount = isdigit((unsigned char)text[0]) ? strtod(text, &end) : NAN;
    params->percent = end && strcmp(end, "%") == 0;
    if (end && (params->percent || !*end)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s takes a number of photos or a percentage, such as 20 or 25%%, not \"%s\"", option, text);
}

static enum vw_status read_rule(const struct vw_options *options, struct vw_selection_params *params) {
    int count = options->positive + options->significant + (options->top != NULL) + (options->drop != NULL);
    if (count != 1)
        return vw_fail(VW_ERROR_USAGE, "select: give one of --positive, --significant, --top K|P%% and --drop K|P%%, not %s",
                       count ? "several" : "none");
    if (!options->to || !*options->to) return vw_fail(VW_ERROR_USAGE, "select: --to is missing; name the list to write");
    *params = (struct vw_selection_params){.method = options->method ? options->method : vw_value_default_method,
                                           .rule = options->positive      ? VW_SELECT_POSITIVE
                                                   : options->significant ? VW_SELECT_SIGNIFICANT
                                                   : options->top         ? VW_SELECT_TOP
                                                                          : VW_SELECT_DROP};
    if (options->top) return parse_amount("top", options->top, params);
    return options->drop ? parse_amount("drop", options->drop, params) : VW_OK;
}

// ---- The choice ---------------------------------------------------------------------------------------------------------

static enum vw_status open_run(struct choice *choice) {
    struct vw_recorded_run *run = &choice->run;
    json_error_t error;
    enum vw_status status = vw_recorded_open(choice->options->operand, run);
    if (!status) status = vw_ledger_get_images(run->ledger, &choice->images, &choice->image_count);
    if (status) return status;
    choice->scene_options = json_loads(run->row.scene_options_json, 0, &error);
    if (!json_is_object(choice->scene_options))
        return vw_fail(VW_ERROR_INPUT, "%s: run.scene_options_json: %s", run->ledger_path, run->row.scene_options_json);
    if (strcmp(run->row.status, "finished") != 0)
        vw_log_warning("%s: the run is not finished but %s: scores may change with the steps that it lacks", run->ledger_path,
                       run->row.status);
    if (json_object_get(choice->scene_options, "plant"))
        vw_log_warning("the run spoiled photos on purpose (--plant): its scores are of these, not of the files that the list names");
    return VW_OK;
}

static enum vw_status select_photos(struct choice *choice) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    enum vw_status status = vw_ledger_get_scores(choice->run.ledger, &scores, &score_count);
    if (!status) status = vw_selection_make(scores, score_count, choice->images, choice->image_count, &choice->params, &choice->selection);
    if (status) vw_fail_context(status, "%s", choice->run.ledger_path);
    free(scores);
    return status;
}

static enum vw_split split_of(const char *name) {
    enum vw_split split = VW_SPLIT_TRAIN;
    while (split < VW_SPLIT_EXCLUDED && strcmp(name, vw_split_name(split)) != 0) split++;
    return split;
}

static enum vw_status write_list(struct choice *choice) {
    struct vw_listed_photo *photos = vw_allocate(choice->image_count, sizeof *photos);
    if (!photos) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < choice->image_count; i++) {
        photos[i] = (struct vw_listed_photo){choice->images[i].name, split_of(choice->images[i].split), false};
        choice->train_count += photos[i].split == VW_SPLIT_TRAIN;
    }
    for (uint32_t i = 0; i < choice->selection.count; i++) {
        const struct vw_ledger_image *image = vw_ledger_find_image(choice->images, choice->image_count, choice->selection.image_ids[i]);
        photos[image - choice->images].chosen = true; // the selection is of these images
    }
    const struct vw_photo_list list = {
        .scene_path = vw_is_imported(&choice->run.row) ? NULL : choice->run.row.scene_path,
        .scene_format = json_string_value(json_object_get(choice->scene_options, "format")),
        .photos = photos,
        .photo_count = choice->image_count,
        .to = choice->options->to,
    };
    enum vw_status status = vw_photo_list_write(&list, &choice->format, &choice->opens);
    free(photos);
    return status;
}

// ---- What is said -------------------------------------------------------------------------------------------------------

static const char *name_of(const struct choice *choice, uint32_t place) {
    return vw_ledger_find_image(choice->images, choice->image_count, choice->selection.image_ids[place])->name;
}

static json_t *to_json(const struct choice *choice) {
    json_t *names = json_array();
    bool failed = !names;
    for (uint32_t i = 0; !failed && i < choice->selection.count; i++)
        failed = json_array_append_new(names, json_string(name_of(choice, i)));
    if (failed) json_decref(names);
    return failed ? NULL
                  : json_pack("{s:s, s:s, s:s, s:o}", "path", choice->options->to, "format", choice->format, "method",
                              choice->params.method, "selected", names);
}

// As a shell takes it.
static void print_word(const char *word) {
    if (*word && !word[strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+,:=@%")]) {
        printf(" %s", word);
        return;
    }
    printf(" '");
    for (; *word; word++)
        if (*word == '\'') printf("'\\''");
        else putchar(iscntrl((unsigned char)*word) ? '?' : *word);
    putchar('\'');
}

// Those options of the scene that the list does not say.
static void print_scene_options(const struct choice *choice) {
    static const char *const said[] = {"train", "plant", "format", "pool", "val", "test"}; // the first two by every list
    const char *key;
    json_t *value;
    json_object_foreach(choice->scene_options, key, value) {
        bool left_out = false;
        for (size_t i = 0; i < (choice->opens ? VW_ARRAY_COUNT(said) : 2); i++) left_out |= strcmp(key, said[i]) == 0;
        if (left_out) continue;
        printf(" --%s", key);
        if (json_is_integer(value)) printf(" %" JSON_INTEGER_FORMAT, json_integer_value(value));
        else print_word(json_string_value(value) ? json_string_value(value) : "");
    }
}

static void print_next(const struct choice *choice) {
    if (vw_is_imported(&choice->run.row)) return;
    if (!choice->opens && strcmp(choice->format, "transforms") == 0) {
        printf("train    with other trainers; viewworth opens it when --to is in the scene's folder or in one above\n");
        return;
    }
    printf("train    viewworth value");
    print_word(choice->opens ? choice->options->to : choice->run.row.scene_path);
    if (!choice->opens) {
        printf(" --train");
        print_word(choice->options->to);
    }
    print_scene_options(choice);
    printf(" --out ANOTHER\n");
}

static void print_rule(const struct vw_selection_params *params) {
    const char *unit = params->percent ? " %" : "";
    switch (params->rule) {
    case VW_SELECT_POSITIVE: printf("score above zero\n"); break;
    case VW_SELECT_SIGNIFICANT: printf("interval above zero\n"); break;
    case VW_SELECT_TOP: printf("the best %g%s\n", params->amount, unit); break;
    case VW_SELECT_DROP: printf("all but the worst %g%s\n", params->amount, unit); break;
    }
}

static void print_text(const struct choice *choice) {
    const struct vw_selection *selection = &choice->selection;
    printf("kept     %u of %u photos to train on, by %s: ", selection->count, choice->train_count, choice->params.method);
    print_rule(&choice->params);
    if (selection->scored_count < choice->train_count)
        printf("         %u photos have no such score and were left out\n", choice->train_count - selection->scored_count);
    printf("list    ");
    print_word(choice->options->to);
    printf(" (%s)\n", choice->format);
    print_next(choice);
}

enum vw_status vw_command_select(const struct vw_options *options) {
    struct choice choice = {.options = options};
    enum vw_status status = read_rule(options, &choice.params);
    if (status) return status;
    status = open_run(&choice);
    if (!status) status = select_photos(&choice);
    if (!status) status = write_list(&choice);
    if (!status && options->json) status = vw_json_print(to_json(&choice));
    else if (!status) print_text(&choice);
    vw_selection_free(&choice.selection);
    json_decref(choice.scene_options);
    vw_recorded_close(&choice.run);
    return status;
}
