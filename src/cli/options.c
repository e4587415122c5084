#include "cli/options.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/sweep/configurations.h"
#include "base/memory.h"

enum kind {
    KIND_FLAG,   // bool
    KIND_TEXT,   // const char *
    KIND_TEXTS,  // struct vw_texts
    KIND_COUNT,  // uint32_t
    KIND_SEED,   // uint64_t
    KIND_REAL,   // double
    KIND_CHOICE, // an enum, by its names
    KIND_EFFECTS // the config's own copy
};

struct option_row {
    const char *name, *argument, *help;
    unsigned group;
    enum kind kind;
    size_t offset;        // of its field in struct vw_options
    uint32_t least, most; // of a count that is no part of the config, which knows its own ranges
    const char *(*choice_name)(uint32_t choice);
    uint32_t choice_count;
};

const char *vw_equal_name(enum vw_equal equal) { return equal == VW_EQUAL_STEPS ? "steps" : "epochs"; }

static const char *loss_choice(uint32_t choice) { return vw_loss_name((enum vw_loss)choice); }
static const char *background_choice(uint32_t choice) { return vw_background_name((enum vw_background_form)choice); }
static const char *vary_choice(uint32_t choice) { return vw_vary_name((enum vw_vary)choice); }
static const char *table_precision_choice(uint32_t choice) {
    return vw_table_precision_name((enum vw_table_precision)choice);
}
static const char *equal_choice(uint32_t choice) { return vw_equal_name((enum vw_equal)choice); }
static const char *optimizer_choice(uint32_t choice) { return vw_optimizer_name((enum vw_optimizer)choice); }

_Static_assert(sizeof(enum vw_loss) == sizeof(uint32_t) && sizeof(enum vw_optimizer) == sizeof(uint32_t) &&
                   sizeof(enum vw_background_form) == sizeof(uint32_t) && sizeof(enum vw_vary) == sizeof(uint32_t) &&
                   sizeof(enum vw_table_precision) == sizeof(uint32_t) && sizeof(enum vw_equal) == sizeof(uint32_t),
               "KIND_CHOICE stores 32 bits");

#define FIELD(field) .offset = offsetof(struct vw_options, field)
#define FLAG .kind = KIND_FLAG
#define TEXT .kind = KIND_TEXT
#define COUNT .kind = KIND_COUNT
#define REAL .kind = KIND_REAL

static const struct option_row rows[] = {
    {"device", "N|NAME", "Vulkan device: index or part of the name, as in viewworth devices", VW_OPTIONS_DEVICE, TEXT,
     FIELD(device)},
    {"format", "NAME",
     "read the scene as recipe, transforms, phototourism or colmap, not as the first of these that fits",
     VW_OPTIONS_SCENE, TEXT, FIELD(format)},
    {"pool", "all|list", "PhotoTourism: all registered photos, or those that the TSV lists", VW_OPTIONS_SCENE, TEXT,
     FIELD(pool)},
    {"train", "FILE", "names of the photos to train on, one a line, or a NeRF-W TSV", VW_OPTIONS_SCENE, TEXT,
     FIELD(train_list)},
    {"val", "FILE", "names of the photos to validate on", VW_OPTIONS_SCENE, TEXT, FIELD(val_list)},
    {"test", "FILE", "names of the photos to keep for tests", VW_OPTIONS_SCENE, TEXT, FIELD(test_list)},
    {"providers", "FILE.csv", "who supplied which photo: header name,provider", VW_OPTIONS_SCENE, TEXT,
     FIELD(providers)},
    {"downscale", "N", "divide the size of the photos by N", VW_OPTIONS_SCENE, COUNT, FIELD(downscale), .least = 1,
     .most = 64},
    {"corrupt", "N", "corrupt N of the photos to train on, each by one of five defects, so that truth is known",
     VW_OPTIONS_SCENE, COUNT, FIELD(corrupt), .least = 0, .most = 1000000},
    {"seed", "N", "of order, pixels, jitter and initialisation", VW_OPTIONS_TRAINING, FIELD(config.seed),
     .kind = KIND_SEED},
    {"epochs", "N", "times every photo is trained on", VW_OPTIONS_TRAINING, COUNT, FIELD(config.epochs)},
    {"burn-in", "N", "first epochs that do not count into scores", VW_OPTIONS_TRAINING | VW_OPTIONS_IMPORT, COUNT,
     FIELD(config.burn_in_epochs)},
    {"rays", "N", "training rays per step", VW_OPTIONS_TRAINING, COUNT, FIELD(config.rays)},
    {"samples", "N", "samples per ray", VW_OPTIONS_TRAINING, COUNT, FIELD(config.samples)},
    {"val-rays", "N", "validation rays in total, at least 32 per validation photo", VW_OPTIONS_TRAINING, COUNT,
     FIELD(config.val_rays)},
    {"loss", "NAME", "training loss", VW_OPTIONS_TRAINING, FIELD(config.loss), .kind = KIND_CHOICE,
     .choice_name = loss_choice, .choice_count = VW_LOSS_HUBER + 1},
    {"optimizer", "NAME", "how gradients become steps", VW_OPTIONS_TRAINING, FIELD(config.optimizer),
     .kind = KIND_CHOICE, .choice_name = optimizer_choice, .choice_count = VW_OPTIMIZER_SGD + 1},
    {"lr", "X", "learning rate", VW_OPTIONS_TRAINING, REAL, FIELD(config.learning_rate)},
    {"beta1", "X", "momentum of Adam (at 0 a step credits its photo alone)", VW_OPTIONS_TRAINING | VW_OPTIONS_IMPORT,
     REAL, FIELD(config.beta1)},
    {"effects", "auto|none|LIST|+a,-b", "optional parts of image formation; a bare list means exactly these",
     VW_OPTIONS_TRAINING, FIELD(config.effects), .kind = KIND_EFFECTS},
    {"background", "NAME",
     "what transparent training pixels stand on: the scene's colour, or one drawn per ray and step",
     VW_OPTIONS_TRAINING, FIELD(config.background), .kind = KIND_CHOICE, .choice_name = background_choice,
     .choice_count = VW_BACKGROUND_RANDOM + 1},
    {"levels", "N", "levels of the hash grid", VW_OPTIONS_TRAINING, COUNT, FIELD(config.levels)},
    {"features", "N", "features of a grid entry", VW_OPTIONS_TRAINING, COUNT, FIELD(config.features)},
    {"log2-table", "N", "binary logarithm of the entries of a level", VW_OPTIONS_TRAINING, COUNT,
     FIELD(config.log2_table)},
    {"table-precision", "NAME", "in which features of the hash grid are stored and read", VW_OPTIONS_TRAINING,
     FIELD(config.table_precision), .kind = KIND_CHOICE, .choice_name = table_precision_choice,
     .choice_count = VW_TABLE_FLOAT16 + 1},
    {"base-resolution", "N", "cells along an axis of the coarsest level", VW_OPTIONS_TRAINING, COUNT,
     FIELD(config.base_resolution)},
    {"growth", "X", "ratio of resolutions from level to level", VW_OPTIONS_TRAINING, REAL, FIELD(config.growth)},
    {"width", "N", "neurons of the hidden layers", VW_OPTIONS_TRAINING, COUNT, FIELD(config.width)},
    {"profile", NULL, "also time every pass, and say what it does with the device", VW_OPTIONS_ONE_RUN, FLAG,
     FIELD(profile)},
    {"noise-floor", NULL, "also probe the measurement: repeated validation, steps of learning rate 0, redrawn pixels",
     VW_OPTIONS_VALUE, FLAG, FIELD(config.noise_floor)},
    {"same-state", "N", "also score every photo by steps from the same N states, each restored after every step",
     VW_OPTIONS_VALUE, COUNT, FIELD(config.same_state), .least = 1, .most = 1000000},
    {"first-order", NULL, "also score every photo by the slope of validation along its steps", VW_OPTIONS_VALUE, FLAG,
     FIELD(config.first_order)},
    {"until-stable", "R",
     "stop at an epoch's end once scores rank as half the epochs ranked them: Spearman's correlation, below 1; 0: "
     "never",
     VW_OPTIONS_ONE_VALUE, REAL, FIELD(until_stable)},
    {"accuracy", "NAME",
     "rays, samples, val-rays, log2-table, width and epochs at once: draft, quick, standard or reference; those given "
     "themselves win",
     VW_OPTIONS_ONE_VALUE, TEXT, FIELD(accuracy)},
    {"budget", "TIME",
     "choose these so that the whole command ends within 90s, 10min or 1.5h, and stop at an epoch's end; --epochs is "
     "then the most",
     VW_OPTIONS_ONE_VALUE, TEXT, FIELD(budget)},
    {"payout", "AMOUNT", "also divide an amount among the providers, in proportion to what their photos are worth",
     VW_OPTIONS_ONE_VALUE, TEXT, FIELD(payout)},
    {"out", "FOLDER", "where results go (needed); must not hold a run yet, unless with --resume", VW_OPTIONS_OUT, TEXT,
     FIELD(out)},
    {"out", "FOLDER", "where results go (needed); must not hold a run yet", VW_OPTIONS_IMPORT, TEXT, FIELD(out)},
    {"out", "FOLDER", "where results go (needed); what it holds of the same runs is gone on with", VW_OPTIONS_RUNS,
     TEXT, FIELD(out)},
    {"resume", NULL, "go on with the run that --out holds, or extend it by more --epochs; start when there is none",
     VW_OPTIONS_OUT, FLAG, FIELD(resume)},
    {"resume", NULL, "taken for granted", VW_OPTIONS_RUNS, FLAG, FIELD(resume)},
    {"seeds", "K", "runs to compare, of the seeds from --seed on", VW_OPTIONS_REPRODUCE, COUNT, FIELD(seeds),
     .least = 2, .most = 50},
    {"vary", "NAME", "what differs between the runs; the rest stays as --seed has it", VW_OPTIONS_REPRODUCE,
     FIELD(config.vary), .kind = KIND_CHOICE, .choice_name = vary_choice, .choice_count = VW_VARY_INIT + 1},
    {"expect", "HEAD", "the head that an earlier command printed", VW_OPTIONS_VERIFY, TEXT, FIELD(expect)},
    {"replay", "N", "take the first N steps again and compare every bit", VW_OPTIONS_VERIFY, COUNT, FIELD(replay_steps),
     .least = 1, .most = UINT32_MAX},
    {"view", "NAME|N", "photo to render: its name, or its place among the validation photos (default: the first)",
     VW_OPTIONS_VIEW, TEXT, FIELD(view)},
    {"to", "FILE", "image to write, .png or .exr (default: OUT/render_<view>.png)", VW_OPTIONS_VIEW, TEXT, FIELD(to)},
    {"to", "PATH", "the list to write (needed): a new file, or for transforms.json also a folder", VW_OPTIONS_SELECT,
     TEXT, FIELD(to)},
    {"positive", NULL, "keep the photos whose score is above zero", VW_OPTIONS_SELECT, FLAG, FIELD(positive)},
    {"significant", NULL, "keep the photos whose 95 % interval lies above zero", VW_OPTIONS_SELECT, FLAG,
     FIELD(significant)},
    {"not-harmful", NULL, "keep all but the photos whose 95 % interval lies below zero", VW_OPTIONS_SELECT, FLAG,
     FIELD(not_harmful)},
    {"top", "K|P%", "keep the K best photos, or the best P % of them", VW_OPTIONS_SELECT, TEXT, FIELD(top)},
    {"drop", "K|P%", "keep all but the K worst photos, or the worst P % of them", VW_OPTIONS_SELECT, TEXT, FIELD(drop)},
    {"method", "NAME", "whose scores decide (default: dv_psnr)", VW_OPTIONS_SELECT | VW_OPTIONS_COMPARE, TEXT,
     FIELD(method)},
    {"to", "FILE", "where to write the report (default: report.html in the first OUT)", VW_OPTIONS_REPORT, TEXT,
     FIELD(to)},
    {"no-thumbnails", NULL, "leave the photos out of the report, where they may not be passed on",
     VW_OPTIONS_THUMBNAILS, FLAG, FIELD(no_thumbnails)},
    {"measure", NULL,
     "also train briefly with and without each effect called for: milliseconds, params, bytes and PSNR",
     VW_OPTIONS_INFO, FLAG, FIELD(measure)},
    {"subsets", "N", "random halves of the photos to train on, each twice", VW_OPTIONS_BENCHMARK, COUNT, FIELD(subsets),
     .least = 8, .most = 10000},
    {"leave-one-out", NULL, "also train without each photo: twice as many trainings as there are photos",
     VW_OPTIONS_BENCHMARK, FLAG, FIELD(leave_one_out)},
    {"curves", "LIST|all|none", "methods by whose scores photos are removed and added (default: dv_psnr,ground_truth)",
     VW_OPTIONS_BENCHMARK, TEXT, FIELD(curves)},
    {"list", "WHAT",
     "photos to train on (needed, may be repeated): all, positive, significant, not-harmful, top:K, top:P%, drop:P%, "
     "random, a file of "
     "names, a NeRF-W TSV, a transforms file, or SCORES.csv@LEAST (a CSV with the header name,score)",
     VW_OPTIONS_COMPARE, FIELD(lists), .kind = KIND_TEXTS},
    {"scores", "OUT", "the valued run that positive, significant, not-harmful, top and drop choose by",
     VW_OPTIONS_COMPARE, TEXT, FIELD(scores)},
    {"seeds", "K", "trainings of each list, of the seeds from --seed on", VW_OPTIONS_COMPARE, COUNT, FIELD(seeds),
     .least = 1, .most = 50},
    {"equal", "NAME",
     "what lists of different lengths train equally long: steps (epochs in proportion), or epochs, as the paper",
     VW_OPTIONS_COMPARE, FIELD(equal), .kind = KIND_CHOICE, .choice_name = equal_choice,
     .choice_count = VW_EQUAL_EPOCHS + 1},
    {"views", "N", "test photos (validation photos where there are none) to render side by side", VW_OPTIONS_COMPARE,
     COUNT, FIELD(views), .least = 0, .most = 1000},
    {"seeds", "K", "runs of every point, of the seeds from --seed on", VW_OPTIONS_TRADEOFF, COUNT, FIELD(seeds),
     .least = 2, .most = 50},
    {"parameters", "LIST", "what is turned (default: all): " VW_SWEEP_PARAMETERS, VW_OPTIONS_TRADEOFF, TEXT,
     FIELD(parameters)},
    {"halves", "N",
     "random halves of the photos that scores are evaluated by, each trained on twice; 0: none; LDS takes 3",
     VW_OPTIONS_TRADEOFF, COUNT, FIELD(halves), .least = 0, .most = 10000},
    {"json", NULL, "results as one JSON object on stdout", VW_OPTIONS_JSON, FLAG, FIELD(json)},
    {"quiet", NULL, "say nothing but results, warnings and errors", VW_OPTIONS_ALWAYS, FLAG, FIELD(quiet)},
    {"help", NULL, "show this help", VW_OPTIONS_ALWAYS, FLAG, FIELD(help)},
};

enum { ROW_COUNT = VW_ARRAY_COUNT(rows), FIRST_CODE = 256 }; // getopt's code of row i is FIRST_CODE + i

_Static_assert(ROW_COUNT <= 128, "struct vw_options has a bit for each");

static const struct vw_options defaults = {.downscale = 1, .seeds = 3, .subsets = 200, .halves = 24, .views = 2};

// What a number may be, "" for what is none.
static void describe_range(const struct option_row *row, char text[VW_CONFIG_RANGE_BYTES]) {
    text[0] = 0;
    if (row->most) snprintf(text, VW_CONFIG_RANGE_BYTES, "%" PRIu32 " to %" PRIu32, row->least, row->most);
    else vw_config_range(row->name, text);
}

static enum vw_status refuse_number(const struct option_row *row, const char *text, const char *noun) {
    char range[VW_CONFIG_RANGE_BYTES];
    describe_range(row, range);
    return vw_fail(VW_ERROR_USAGE, "--%s takes %s, %s, not \"%s\"", row->name, noun, range, text);
}

// The config's ranges are checked when all options are known: here a number only has to fit its field.
static enum vw_status parse_whole(const struct option_row *row, const char *text, uint64_t *number) {
    uint64_t most = row->most ? row->most : row->kind == KIND_SEED ? UINT64_MAX : UINT32_MAX;
    char *end = NULL;
    errno = 0;
    unsigned long long parsed = isdigit((unsigned char)text[0]) ? strtoull(text, &end, 10) : 0;
    if (!end || *end || errno || parsed < row->least || parsed > most)
        return refuse_number(row, text, "a whole number");
    *number = parsed;
    return VW_OK;
}

static enum vw_status parse_real(const struct option_row *row, const char *text, double *number) {
    char *end = NULL;
    double parsed = isspace((unsigned char)text[0]) ? NAN : strtod(text, &end);
    if (!end || end == text || *end || !isfinite(parsed)) return refuse_number(row, text, "a number");
    *number = parsed;
    return VW_OK;
}

static void list_choices(const struct option_row *row, char *list, size_t list_bytes) {
    size_t used = 0;
    list[0] = 0;
    for (uint32_t i = 0; i < row->choice_count && used < list_bytes; i++)
        used += (size_t)snprintf(list + used, list_bytes - used, "%s%s", i ? "|" : "", row->choice_name(i));
}

static enum vw_status parse_choice(const struct option_row *row, const char *text, uint32_t *choice) {
    for (uint32_t i = 0; i < row->choice_count; i++) {
        if (strcmp(text, row->choice_name(i)) != 0) continue;
        *choice = i;
        return VW_OK;
    }
    char list[128];
    list_choices(row, list, sizeof list);
    return vw_fail(VW_ERROR_USAGE, "--%s: \"%s\" is not one of %s", row->name, text, list);
}

static enum vw_status add_text(const struct option_row *row, const char *text, struct vw_texts *texts) {
    if (texts->count == VW_TEXTS_MOST)
        return vw_fail(VW_ERROR_USAGE, "--%s: may be given %d times at most; leave some out", row->name, VW_TEXTS_MOST);
    texts->texts[texts->count++] = text;
    return VW_OK;
}

static enum vw_status store(const struct option_row *row, const char *text, struct vw_options *options) {
    void *field = (char *)options + row->offset;
    uint64_t number = 0;
    enum vw_status status = VW_OK;
    switch (row->kind) {
    case KIND_FLAG: *(bool *)field = true; break;
    case KIND_TEXT: *(const char **)field = text; break;
    case KIND_TEXTS: status = add_text(row, text, field); break;
    case KIND_COUNT:
        status = parse_whole(row, text, &number);
        if (!status) *(uint32_t *)field = (uint32_t)number;
        break;
    case KIND_SEED:
        status = parse_whole(row, text, &number);
        if (!status) *(uint64_t *)field = number;
        break;
    case KIND_REAL: status = parse_real(row, text, field); break;
    case KIND_CHOICE: status = parse_choice(row, text, field); break;
    case KIND_EFFECTS:
        if (strlen(text) >= sizeof options->config.effects)
            return vw_fail(VW_ERROR_USAGE, "--%s: the list is longer than %zu characters", row->name,
                           sizeof options->config.effects - 1);
        strcpy(field, text);
        break;
    }
    return status;
}

static bool takes(const struct vw_command *command, const struct option_row *row) {
    return row->group == VW_OPTIONS_ALWAYS || (row->group & command->options);
}

static void list_for_getopt(const struct vw_command *command, struct option list[ROW_COUNT + 1]) {
    int count = 0;
    for (int i = 0; i < ROW_COUNT; i++) {
        if (!takes(command, &rows[i])) continue;
        list[count++] =
            (struct option){rows[i].name, rows[i].argument ? required_argument : no_argument, NULL, FIRST_CODE + i};
    }
    list[count] = (struct option){0};
}

// What getopt stumbled over: `word`, unless optopt has the letter of a short option.
static enum vw_status refuse(const struct vw_command *command, bool value_missing, const char *word) {
    if (value_missing)
        return vw_fail(VW_ERROR_USAGE, "%s: %s needs a value; see viewworth %s --help", command->name, word,
                       command->name);
    if (optopt >= FIRST_CODE)
        return vw_fail(VW_ERROR_USAGE, "%s: --%s takes no value", command->name, rows[optopt - FIRST_CODE].name);
    char letter[3] = {'-', (char)optopt, 0};
    return vw_fail(VW_ERROR_USAGE, "%s: unknown option \"%s\"; see viewworth %s --help", command->name,
                   optopt ? letter : word, command->name);
}

static bool needs_out(const struct vw_command *command) {
    return command->options & (VW_OPTIONS_OUT | VW_OPTIONS_RUNS | VW_OPTIONS_IMPORT);
}

static enum vw_status parse_operands(const struct vw_command *command, int count, char **operands,
                                     struct vw_options *options) {
    int wanted = command->operand ? 1 : 0;
    bool several = command->operand && strstr(command->operand, "...");
    if (count < wanted)
        return vw_fail(VW_ERROR_USAGE, "%s: %s is missing; see viewworth %s --help", command->name, command->operand,
                       command->name);
    if (count > wanted && !several)
        return vw_fail(VW_ERROR_USAGE, "%s: \"%s\" is one argument too many; see viewworth %s --help", command->name,
                       operands[wanted], command->name);
    if (wanted) options->operand = operands[0];
    options->operands = (const char *const *)operands;
    options->operand_count = (uint32_t)count;
    if (needs_out(command) && (!options->out || !*options->out))
        return vw_fail(VW_ERROR_USAGE, "%s: --out is missing; name the folder for the results", command->name);
    return VW_OK;
}

enum vw_status vw_options_parse(const struct vw_command *command, int argc, char **argv, struct vw_options *options) {
    *options = defaults;
    options->config = vw_config_default;
    struct option list[ROW_COUNT + 1];
    list_for_getopt(command, list);
    optind = 0; // start anew
    opterr = 0; // messages are ours
    int code;
    while ((code = getopt_long(argc, argv, ":", list, NULL)) != -1) {
        if (code == ':' || code == '?') return refuse(command, code == ':', argv[optind - 1]);
        int row = code - FIRST_CODE;
        options->given[row / 64] |= UINT64_C(1) << row % 64;
        enum vw_status status = store(&rows[row], optarg, options);
        if (status) return status;
    }
    if (options->help) return VW_OK;
    enum vw_status status = parse_operands(command, argc - optind, argv + optind, options);
    if (!status && (command->options & VW_OPTIONS_TRAINING)) status = vw_config_check(&options->config);
    return status;
}

bool vw_options_have(const struct vw_options *options, const char *name) {
    for (int i = 0; i < ROW_COUNT; i++)
        if ((options->given[i / 64] >> i % 64 & 1) && strcmp(rows[i].name, name) == 0) return true;
    return false;
}

static void format_default(const struct option_row *row, const struct vw_options *options, char *text,
                           size_t text_bytes) {
    const void *field = (const char *)options + row->offset;
    text[0] = 0;
    switch (row->kind) {
    case KIND_FLAG:
    case KIND_TEXT:
    case KIND_TEXTS: break;
    case KIND_COUNT: snprintf(text, text_bytes, " (%" PRIu32 ")", *(const uint32_t *)field); break;
    case KIND_SEED: snprintf(text, text_bytes, " (%" PRIu64 ")", *(const uint64_t *)field); break;
    case KIND_REAL: snprintf(text, text_bytes, " (%g)", *(const double *)field); break;
    case KIND_CHOICE: snprintf(text, text_bytes, " (%s)", row->choice_name(*(const uint32_t *)field)); break;
    case KIND_EFFECTS: snprintf(text, text_bytes, " (%s)", (const char *)field); break;
    }
}

static void print_option(const struct option_row *row, const struct vw_options *options) {
    char choices[128] = "", left[160], range[VW_CONFIG_RANGE_BYTES], value[300];
    if (row->kind == KIND_CHOICE) list_choices(row, choices, sizeof choices);
    const char *argument = choices[0] ? choices : row->argument;
    snprintf(left, sizeof left, "--%s%s%s", row->name, argument ? " " : "", argument ? argument : "");
    describe_range(row, range);
    format_default(row, options, value, sizeof value);
    printf("  %-38s %s%s%s%s\n", left, row->help, range[0] ? ", " : "", range, value);
}

void vw_options_print_help(const struct vw_command *command) {
    struct vw_options options = defaults;
    options.config = vw_config_default;
    const char *operand = command->operand ? command->operand : "", *out = needs_out(command) ? " --out FOLDER" : "";
    printf("usage: viewworth %s%s%s%s [options]\n\n%s.\n", command->name, *operand ? " " : "", operand, out,
           command->summary);
    if (command->details) printf("%s\n", command->details);
    printf("\noptions, with defaults in parentheses:\n");
    for (int i = 0; i < ROW_COUNT; i++)
        if (takes(command, &rows[i])) print_option(&rows[i], &options);
}
