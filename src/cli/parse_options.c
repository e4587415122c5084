// Parses a command line by the option table.
#include "cli/program.h"

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "cli/help.h"

enum {
    OPTIONS_MAX = VW_PROGRAM_OPTIONS_MAX,
    FIRST_CODE = 256 // getopt's code of row i of the table is FIRST_CODE + i
};

static enum vw_status refuse_number(const struct vw_option *option, const char *text, const char *noun) {
    char range[VW_CONFIG_RANGE_BYTES];
    vw_option_range(option, range);
    return vw_fail(VW_ERROR_USAGE, "--%s takes %s, %s, not \"%s\"", option->name, noun, range, text);
}

// Parses a whole number that fits the field. The config's ranges are checked later, when all options are known.
static enum vw_status parse_whole(const struct vw_option *option, const char *text, uint64_t *number) {
    uint64_t most = option->most ? option->most : option->kind == VW_OPTION_SEED ? UINT64_MAX : UINT32_MAX;
    char *end = NULL;
    errno = 0;
    unsigned long long parsed = isdigit((unsigned char)text[0]) ? strtoull(text, &end, 10) : 0;
    bool all = option->all && !strcmp(text, "all"), zero = option->zero && !strcmp(text, option->zero);
    if (!all && !zero && (!end || *end || errno || parsed < option->least || parsed > most))
        return refuse_number(option, text, option->all ? "\"all\" or a whole number" : "a whole number");
    *number = all ? most : zero ? 0 : parsed;
    return VW_OK;
}

static enum vw_status parse_real(const struct vw_option *option, const char *text, double *number) {
    char *end = NULL;
    double parsed = isspace((unsigned char)text[0]) ? NAN : strtod(text, &end);
    if (!end || end == text || *end || !isfinite(parsed)) return refuse_number(option, text, "a number");
    *number = parsed;
    return VW_OK;
}

static enum vw_status parse_choice(const struct vw_option *option, const char *text, uint32_t *choice) {
    for (uint32_t i = 0; i < option->choice_count; i++) {
        if (strcmp(text, option->choice_name(i)) != 0) continue;
        *choice = i;
        return VW_OK;
    }
    char list[VW_OPTION_CHOICES_BYTES];
    vw_option_choices(option, '|', list);
    return vw_fail(VW_ERROR_USAGE, "--%s: \"%s\" is not one of %s", option->name, text, list);
}

static enum vw_status add_text(const struct vw_option *option, const char *text, struct vw_texts *texts) {
    if (texts->count == VW_TEXTS_MOST)
        return vw_fail(VW_ERROR_USAGE, "--%s: at most %d are possible; leave some out", option->name, VW_TEXTS_MOST);
    texts->texts[texts->count++] = text;
    return VW_OK;
}

static enum vw_status store(const struct vw_option *option, const char *text, struct vw_options *options) {
    void *field = (char *)options + option->offset;
    uint64_t number = 0;
    enum vw_status status = VW_OK;
    switch (option->kind) {
    case VW_OPTION_FLAG: *(bool *)field = true; break;
    case VW_OPTION_TEXT: *(const char **)field = text; break;
    case VW_OPTION_TEXTS: status = add_text(option, text, field); break;
    case VW_OPTION_COUNT:
        status = parse_whole(option, text, &number);
        if (!status) *(uint32_t *)field = (uint32_t)number;
        break;
    case VW_OPTION_SEED:
        status = parse_whole(option, text, &number);
        if (!status) *(uint64_t *)field = number;
        break;
    case VW_OPTION_REAL: status = parse_real(option, text, field); break;
    case VW_OPTION_CHOICE: status = parse_choice(option, text, field); break;
    case VW_OPTION_EFFECTS:
        if (strlen(text) >= sizeof options->config.effects)
            return vw_fail(VW_ERROR_USAGE, "--%s: the list is longer than %zu characters; name fewer effects",
                           option->name, sizeof options->config.effects - 1);
        strcpy(field, text);
        break;
    }
    return status;
}

// Lists the command's options for getopt, by name, and by letter (a colon follows those that need a value).
static void list_for_getopt(const struct vw_program *program, const struct vw_program_command *command,
                            struct option list[OPTIONS_MAX + 1], char letters[2 * OPTIONS_MAX + 2]) {
    int count = 0;
    *letters++ = ':'; // a missing value has a code of its own
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        if (!vw_option_fits(option, command)) continue;
        int argument = option->kind == VW_OPTION_FLAG ? no_argument : required_argument;
        list[count++] = (struct option){option->name, argument, NULL, FIRST_CODE + (int)i};
        if (option->letter) *letters++ = option->letter;
        if (option->letter && argument == required_argument) *letters++ = ':';
    }
    *letters = 0;
    list[count] = (struct option){0};
}

// Returns the row of getopt's code, which of a short option is its letter.
static uint32_t row_of(const struct vw_program *program, int code) {
    uint32_t row = 0;
    if (code >= FIRST_CODE) return (uint32_t)(code - FIRST_CODE);
    while (vw_program_option(program, row)->letter != code) row++;
    return row;
}

// Returns the command's option that a slip makes of `name`, or NULL.
static const char *nearest_option(const struct vw_program *program, const struct vw_program_command *command,
                                  const char *name) {
    const char *nearest = NULL;
    uint32_t least = UINT32_MAX;
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        if (vw_option_fits(option, command)) vw_take_nearer(name, option->name, &least, &nearest);
    }
    return nearest;
}

// Names what getopt refused: `word`, or the short option whose letter is in optopt.
static enum vw_status refuse(const struct vw_program *program, const struct vw_program_command *command,
                             bool value_missing, const char *word) {
    if (value_missing)
        return vw_fail(VW_ERROR_USAGE, "%s: %s needs a value; see %s %s --help", command->name, word, program->name,
                       command->name);
    if (optopt >= FIRST_CODE)
        return vw_fail(VW_ERROR_USAGE, "%s: --%s takes no value", command->name,
                       vw_program_option(program, (uint32_t)(optopt - FIRST_CODE))->name);
    char letter[3] = {'-', (char)optopt, 0};
    const char *meant = optopt || strncmp(word, "--", 2) != 0 ? NULL : nearest_option(program, command, word + 2);
    if (meant) return vw_fail(VW_ERROR_USAGE, "%s: unknown option \"%s\"; is --%s meant?", command->name, word, meant);
    return vw_fail(VW_ERROR_USAGE, "%s: unknown option \"%s\"; see %s %s --help", command->name, optopt ? letter : word,
                   program->name, command->name);
}

// Refuses an option that is not written out. getopt accepts any beginning that fits only one name: a slip would set
// another option, and a new option could change the meaning of an old command.
static enum vw_status refuse_beginning(const struct vw_program_command *command, char **argv, const char *name) {
    const char *word = argv[optind - 1] == optarg ? argv[optind - 2] : argv[optind - 1];
    size_t length = strcspn(word, "=");
    if (length == strlen("--") + strlen(name)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "%s: unknown option \"%.*s\"; is --%s meant?", command->name, (int)length, word,
                   name);
}

static enum vw_status parse_operands(const struct vw_program_command *command, int count, char **operands,
                                     struct vw_options *options) {
    int wanted = command->operand ? 1 : 0;
    bool several = command->operand && strstr(command->operand, "...");
    if (count < wanted)
        return vw_fail(VW_ERROR_USAGE, "%s: %s is missing; see %s %s --help", command->name, command->operand,
                       options->program->name, command->name);
    if (count > wanted && !several)
        return vw_fail(VW_ERROR_USAGE, "%s: unexpected argument \"%s\"; see %s %s --help", command->name,
                       operands[wanted], options->program->name, command->name);
    if (wanted) options->operand = options->scene.path = operands[0];
    options->operands = (const char *const *)operands;
    options->operand_count = (uint32_t)count;
    if (vw_command_needs_out(command) && (!options->out || !*options->out))
        return vw_fail(VW_ERROR_USAGE, "%s: --out is missing; name the folder for the results", command->name);
    return VW_OK;
}

// Applies a preset. Its options count as given on the command line, unless the command line has them.
static enum vw_status apply_preset(struct vw_options *options) {
    const char *rest = vw_option_preset_options(options->preset);
    char name[32], value[sizeof options->config.effects];
    enum vw_status status = VW_OK;
    for (int length; !status && sscanf(rest, " %31[^=]=%255s%n", name, value, &length) == 2; rest += length) {
        uint32_t row = 0;
        if (vw_options_have(options, name)) continue;
        while (strcmp(vw_program_option(options->program, row)->name, name) != 0) row++;
        options->given[row / 64] |= UINT64_C(1) << row % 64;
        status = store(vw_program_option(options->program, row), value, options);
    }
    return status;
}

static bool command_has(const struct vw_program *program, const struct vw_program_command *command, const char *name) {
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        if (!strcmp(option->name, name) && vw_option_fits(option, command)) return true;
    }
    return false;
}

static enum vw_status check_needs(const struct vw_program *program, const struct vw_program_command *command,
                                  const struct vw_options *options) {
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        if (!(options->given[i / 64] >> i % 64 & 1) || !option->needs || vw_options_have(options, option->needs))
            continue;
        if (command_has(program, command, option->needs))
            return vw_fail(VW_ERROR_USAGE, "--%s needs --%s", option->name, option->needs);
    }
    return VW_OK;
}

// Refuses what could not be shown as it is: names are printed, and written to tables, JSON and pages.
static enum vw_status check_texts(int argc, char **argv) {
    for (int i = 1; i < argc; i++)
        if (!vw_text_is_clean(argv[i]))
            return vw_fail(VW_ERROR_USAGE, "argument %d (%s) is not UTF-8 or has control characters; rename the file",
                           i, argv[i]);
    return VW_OK;
}

static void take_field_defaults(struct vw_options *options) {
    const struct vw_config of_field = vw_config_of_field(options->config.field);
    uint32_t count;
    const struct vw_config_field *field = vw_config_fields(&count);
    for (uint32_t i = 0; i < count; i++)
        if (!vw_options_have(options, field[i].option)) vw_config_copy(&of_field, &field[i], &options->config);
}

static enum vw_status take_initial(struct vw_options *options) {
    struct vw_config *config = &options->config;
    if (!*options->initial || strlen(options->initial) >= sizeof config->initial)
        return vw_fail(VW_ERROR_USAGE, "--initial takes the path of a .ply file, of at most %zu characters",
                       sizeof config->initial - 1);
    strcpy(config->initial, options->initial);
    return VW_OK;
}

enum vw_status vw_options_parse(const struct vw_program *program, const struct vw_program_command *command, int argc,
                                char **argv, struct vw_options *options) {
    memcpy((void *)options, program->defaults, program->options_bytes);
    options->program = program;
    options->config = vw_config_default;
    struct option list[OPTIONS_MAX + 1];
    char letters[2 * OPTIONS_MAX + 2];
    enum vw_status status = check_texts(argc, argv);
    if (status) return status;
    list_for_getopt(program, command, list, letters);
    optind = 0; // getopt keeps its state between calls: reset it
    opterr = 0; // getopt prints nothing: messages come from refuse()
    int code;
    while ((code = getopt_long(argc, argv, letters, list, NULL)) != -1) {
        if (code == ':' || code == '?') return refuse(program, command, code == ':', argv[optind - 1]);
        uint32_t row = row_of(program, code);
        const struct vw_option *option = vw_program_option(program, row);
        if (code >= FIRST_CODE) status = refuse_beginning(command, argv, option->name);
        if (status) return status;
        options->given[row / 64] |= UINT64_C(1) << row % 64;
        status = store(option, optarg, options);
        if (status) return status;
    }
    status = apply_preset(options);
    if (status) return status;
    take_field_defaults(options);
    if (options->help) return VW_OK;
    status = check_needs(program, command, options);
    if (!status) status = parse_operands(command, argc - optind, argv + optind, options);
    if (!status && options->initial) status = take_initial(options);
    if (!status && (command->options & VW_OPTIONS_TRAINING)) status = vw_config_check(&options->config);
    return status;
}

bool vw_options_have(const struct vw_options *options, const char *name) {
    for (uint32_t i = 0; i < vw_program_option_count(options->program); i++)
        if ((options->given[i / 64] >> i % 64 & 1) && strcmp(vw_program_option(options->program, i)->name, name) == 0)
            return true;
    return false;
}
