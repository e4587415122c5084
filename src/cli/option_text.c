#include "cli/option_text.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

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
