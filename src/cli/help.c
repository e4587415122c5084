#include "cli/help.h"
#include "cli/option_text.h"

#include <stdio.h>
#include <string.h>

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
