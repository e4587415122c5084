#include "cli/help.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

// ---- Options --------------------------------------------------------------------------------------------------------

const char *vw_option_section_title(enum vw_option_section section) {
    static const char *const titles[VW_SECTION_COUNT] = {
        [VW_SECTION_MAIN] = "Main options",      [VW_SECTION_SCENE] = "Scene and photos",
        [VW_SECTION_TRAINING] = "Training",      [VW_SECTION_TIME] = "Accuracy and time",
        [VW_SECTION_SCORES] = "More scores",     [VW_SECTION_FIELD] = "Radiance field",
        [VW_SECTION_GENERAL] = "General options"};
    return titles[section];
}

bool vw_option_fits(const struct vw_option *option, const struct vw_program_command *command) {
    return option->groups == VW_OPTIONS_ALWAYS || (option->groups & command->options);
}

bool vw_command_needs_out(const struct vw_program_command *command) {
    return command->options &
           (VW_OPTIONS_OUT | VW_OPTIONS_RUNS | VW_OPTIONS_IMPORT | VW_OPTIONS_BATCH | VW_OPTIONS_MERGE);
}

void vw_option_range(const struct vw_option *option, char text[VW_CONFIG_RANGE_BYTES]) {
    text[0] = 0;
    if (option->most) snprintf(text, VW_CONFIG_RANGE_BYTES, "%" PRIu32 " to %" PRIu32, option->least, option->most);
    else if (vw_config_find(option->name)) vw_config_describe_range(vw_config_find(option->name), text);
}

void vw_option_choices(const struct vw_option *option, char separator, char text[VW_OPTION_CHOICES_BYTES]) {
    size_t used = 0;
    text[0] = 0;
    for (uint32_t i = 0; i < option->choice_count && used < VW_OPTION_CHOICES_BYTES; i++) {
        if (i) text[used++] = separator;
        used += (size_t)snprintf(text + used, VW_OPTION_CHOICES_BYTES - used, "%s", option->choice_name(i));
    }
}

void vw_option_usage(const struct vw_option *option, char text[VW_OPTION_USAGE_BYTES]) {
    char choices[VW_OPTION_CHOICES_BYTES];
    vw_option_choices(option, '|', choices);
    const char *argument = choices[0] ? choices : option->argument ? option->argument : "";
    const char *space = *argument ? " " : "";
    size_t used = (size_t)snprintf(text, VW_OPTION_USAGE_BYTES, "--%s%s%s", option->name, space, argument);
    if (option->letter && used < VW_OPTION_USAGE_BYTES)
        snprintf(text + used, VW_OPTION_USAGE_BYTES - used, ", -%c%s%s", option->letter, space, argument);
}

// Returns the option's field in the defaults. Those of the config are the library's.
static const void *default_of(const struct vw_program *program, const struct vw_option *option) {
    size_t config = offsetof(struct vw_options, config);
    if (option->offset >= config && option->offset < config + sizeof(struct vw_config))
        return (const char *)&vw_config_default + (option->offset - config);
    return (const char *)program->defaults + option->offset;
}

static void describe_default(const struct vw_program *program, const struct vw_option *option, char *text,
                             size_t text_bytes) {
    const void *field = default_of(program, option);
    text[0] = 0;
    if (option->default_text) snprintf(text, text_bytes, "%s", option->default_text);
    else if (option->kind == VW_OPTION_COUNT) snprintf(text, text_bytes, "%" PRIu32, *(const uint32_t *)field);
    else if (option->kind == VW_OPTION_SEED) snprintf(text, text_bytes, "%" PRIu64, *(const uint64_t *)field);
    else if (option->kind == VW_OPTION_REAL) snprintf(text, text_bytes, "%g", *(const double *)field);
    else if (option->kind == VW_OPTION_EFFECTS) snprintf(text, text_bytes, "%s", (const char *)field);
    else if (option->kind == VW_OPTION_CHOICE)
        snprintf(text, text_bytes, "%s", option->choice_name(*(const uint32_t *)field));
}

// Adds the defaults of fields that have their own.
static void describe_own(const struct vw_option *option, char *text, size_t text_bytes) {
    const struct vw_config_field *field = vw_config_find(option->name);
    for (uint32_t i = 0; field && !option->default_text && i < VW_FIELD_COUNT; i++)
        if (field->own[i].differs)
            snprintf(text + strlen(text), text_bytes - strlen(text), ", with --field %s %g", vw_field_name(i),
                     field->own[i].value);
}

// Returns true if the option is off by default: its default is 0, below its range (--replay, --same-state).
static bool is_off_by_default(const struct vw_option *option, const char *standard) {
    return option->kind == VW_OPTION_COUNT && option->least > 0 && strcmp(standard, "0") == 0;
}

void vw_option_sentence(const struct vw_program *program, const struct vw_option *option,
                        char text[VW_OPTION_HELP_BYTES]) {
    char range[VW_CONFIG_RANGE_BYTES], standard[300];
    vw_option_range(option, range);
    describe_default(program, option, standard, sizeof standard);
    describe_own(option, standard, sizeof standard);
    const char *before = "default ";
    if (is_off_by_default(option, standard)) {
        before = "";
        snprintf(standard, sizeof standard, "off by default");
    }
    bool has_range = range[0], has_default = standard[0];
    snprintf(text, VW_OPTION_HELP_BYTES, "%s%s%s%s%s%s%s.", option->help, has_range || has_default ? " (" : "", range,
             has_range && has_default ? "; " : "", has_default ? before : "", standard,
             has_range || has_default ? ")" : "");
}

// ---- Help -----------------------------------------------------------------------------------------------------------

enum { WIDTH = 80, OPTION_COLUMN = 24, COMMAND_COLUMN = 24 };

// Prints `text` word by word from column `column` on, and indents further lines. A newline in it becomes an empty line.
static void print_wrapped(const char *text, size_t column, size_t indent) {
    while (*text) {
        size_t length = strcspn(text, " \n");
        if (column > indent && column + 1 + length > WIDTH) {
            printf("\n%*s", (int)indent, "");
            column = indent;
        }
        bool is_first = column == indent;
        printf("%s%.*s", is_first ? "" : " ", (int)length, text);
        column += length + !is_first;
        text += length;
        if (*text == '\n') {
            printf("\n\n%*s", (int)indent, "");
            column = indent;
        }
        if (*text) text++;
    }
    printf("\n");
}

// Prints a term in the left column and its explanation in the right one; a long term has a line of its own.
static void print_term(const char *term, const char *text, size_t column) {
    printf("  %s", term);
    size_t used = 2 + strlen(term);
    if (used + 2 > column) {
        printf("\n");
        used = 0;
    }
    printf("%*s", (int)(column - used), "");
    print_wrapped(text, column, column);
}

void vw_help_print_program(const struct vw_program *program) {
    const char *name = program->name;
    printf("%s: %s\n\nusage: %s COMMAND [options]\n", name, program->summary, name);
    for (uint32_t group = 0; program->groups[group]; group++) {
        printf("\n%s:\n", program->groups[group]);
        for (uint32_t i = 0; i < program->command_count; i++) {
            const struct vw_program_command *command = &program->commands[i];
            if (command->group != group) continue;
            char term[COMMAND_COLUMN + 16];
            snprintf(term, sizeof term, "%s %s", command->name, command->operand ? command->operand : "");
            print_term(term, command->summary, COMMAND_COLUMN);
        }
    }
    printf("\n%s COMMAND --help (or -h) explains a command and its main options.\n"
           "%s help COMMAND lists all its options.\n"
           "%s --version prints the version.\n"
           "%s --generate-docs FOLDER writes man pages and bash completion.\n",
           name, name, name, name);
}

static bool is_listed(const struct vw_option *option, const struct vw_program_command *command, bool all) {
    return vw_option_fits(option, command) && (all || option->common);
}

static void print_option(const struct vw_program *program, const struct vw_option *option) {
    char usage[VW_OPTION_USAGE_BYTES], sentence[VW_OPTION_HELP_BYTES];
    vw_option_usage(option, usage);
    vw_option_sentence(program, option, sentence);
    print_term(usage, sentence, OPTION_COLUMN);
}

static void print_section(const struct vw_program *program, const struct vw_program_command *command,
                          enum vw_option_section section, bool all) {
    bool has_title = false;
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        if (option->section != section || !is_listed(option, command, all)) continue;
        if (!has_title) printf("\n%s:\n", vw_option_section_title(section));
        has_title = true;
        print_option(program, option);
    }
}

static int count_hidden(const struct vw_program *program, const struct vw_program_command *command) {
    int count = 0;
    for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
        const struct vw_option *option = vw_program_option(program, i);
        count += vw_option_fits(option, command) && !option->common;
    }
    return count;
}

void vw_help_print_command(const struct vw_program *program, const struct vw_program_command *command, bool all) {
    const char *operand = command->operand ? command->operand : "";
    printf("usage: %s %s%s%s%s [options]\n\n", program->name, command->name, *operand ? " " : "", operand,
           vw_command_needs_out(command) ? " --out FOLDER" : "");
    print_wrapped(command->summary, 0, 0);
    if (command->details) {
        printf("\n");
        print_wrapped(command->details, 0, 0);
    }
    for (enum vw_option_section section = 0; section < VW_SECTION_COUNT; section++)
        print_section(program, command, section, all);
    int hidden = all ? 0 : count_hidden(program, command);
    if (hidden) printf("\n%s help %s lists all options (%d more).\n", program->name, command->name, hidden);
}
