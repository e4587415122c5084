#include "cli/help.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "viewworth/version.h"

// ---- Man pages ----

// Writes text so that roff prints it unchanged: hyphens that can be copied, no control lines, paragraphs between
// newlines.
static void write_text(FILE *stream, const char *text) {
    bool line_starts = true;
    for (; *text; text++) {
        if (line_starts && (*text == '.' || *text == '\'')) fputs("\\&", stream);
        line_starts = *text == '\n';
        if (*text == '\n') fputs("\n.PP\n", stream);
        else if (*text == '-') fputs("\\-", stream);
        else if (*text == '\\') fputs("\\e", stream);
        else fputc(*text, stream);
    }
}

static void write_line(FILE *stream, const char *text) {
    write_text(stream, text);
    fputc('\n', stream);
}

// Writes the beginning of a page. `command`: "" for the program's own page, else "-" and a name.
static void write_head(FILE *stream, const char *program, const char *command, const char *summary) {
    fputs(".TH \"", stream);
    for (const char *letter = program; *letter; letter++) fputc(toupper((unsigned char)*letter), stream);
    for (const char *letter = command; *letter; letter++) fputc(toupper((unsigned char)*letter), stream);
    fprintf(stream, "\" 1 \"\" \"viewworth %s\" \"viewworth\"\n.SH NAME\n", vw_version());
    write_text(stream, program);
    write_text(stream, command);
    write_text(stream, " - ");
    fputc(tolower((unsigned char)summary[0]), stream);
    write_line(stream, summary + 1);
    fprintf(stream, ".SH SYNOPSIS\n.B %s", program);
}

static void write_end(FILE *stream, const char *program, const char *see_also) {
    fputs(".SH EXIT STATUS\n.TP\n0\nThe command is done.\n.TP\n1\nThe command failed at run time. What was recorded is "
          "kept.\n.TP\n2\nThe command line or the input is wrong.\n.SH SEE ALSO\n",
          stream);
    write_text(stream, program);
    write_line(stream, see_also);
}

static void write_option(FILE *stream, const struct vw_program *program, const struct vw_option *option) {
    char usage[VW_OPTION_USAGE_BYTES], sentence[VW_OPTION_HELP_BYTES];
    vw_option_usage(option, usage);
    vw_option_sentence(program, option, sentence);
    fputs(".TP\n.B ", stream);
    write_line(stream, usage);
    write_line(stream, sentence);
}

static void write_options(FILE *stream, const struct vw_program *program, const struct vw_program_command *command) {
    fputs(".SH OPTIONS\n", stream);
    for (enum vw_option_section section = 0; section < VW_SECTION_COUNT; section++) {
        bool has_title = false;
        for (uint32_t i = 0; i < vw_program_option_count(program); i++) {
            const struct vw_option *option = vw_program_option(program, i);
            if (option->section != section || !vw_option_fits(option, command)) continue;
            if (!has_title) fprintf(stream, ".SS %s\n", vw_option_section_title(section));
            has_title = true;
            write_option(stream, program, option);
        }
    }
}

static void write_command_page(FILE *stream, const struct vw_program *program,
                               const struct vw_program_command *command) {
    char name[64];
    snprintf(name, sizeof name, "-%s", command->name);
    write_head(stream, program->name, name, command->summary);
    fprintf(stream, " %s\n", command->name);
    if (command->operand) write_text(stream, command->operand);
    if (command->operand && vw_command_needs_out(command)) fputc(' ', stream);
    if (vw_command_needs_out(command)) write_text(stream, "--out FOLDER");
    write_line(stream, command->operand || vw_command_needs_out(command) ? " [options]" : "[options]");
    fputs(".SH DESCRIPTION\n", stream);
    write_text(stream, command->summary);
    fputs(".\n.PP\n", stream);
    write_line(stream, command->details ? command->details : "");
    write_options(stream, program, command);
    write_end(stream, program->name, "(1)");
}

static void write_program_page(FILE *stream, const struct vw_program *program, const struct vw_program_command *none) {
    (void)none;
    write_head(stream, program->name, "", program->summary);
    fputs("\nCOMMAND [options]\n.SH DESCRIPTION\n", stream);
    write_line(stream, program->description);
    fputs(".SH COMMANDS\n", stream);
    for (uint32_t group = 0; program->groups[group]; group++) {
        fprintf(stream, ".SS %s\n", program->groups[group]);
        for (uint32_t i = 0; i < program->command_count; i++) {
            if (program->commands[i].group != group) continue;
            fputs(".TP\n.B ", stream);
            write_line(stream, program->commands[i].name);
            write_line(stream, program->commands[i].summary);
        }
    }
    write_end(stream, program->name, "-COMMAND(1), a page for every command");
}

// ---- Bash completion ----

static void write_command_options(FILE *stream, const struct vw_program *program,
                                  const struct vw_program_command *command) {
    fprintf(stream, "    %s) options='", command->name);
    for (uint32_t i = 0; i < vw_program_option_count(program); i++)
        if (vw_option_fits(vw_program_option(program, i), command))
            fprintf(stream, " --%s", vw_program_option(program, i)->name);
    fputs("' ;;\n", stream);
}

static void write_option_words(FILE *stream, const struct vw_option *option) {
    char choices[VW_OPTION_CHOICES_BYTES];
    vw_option_choices(option, ' ', choices);
    const char *words = choices[0] ? choices : option->words;
    if (words) fprintf(stream, "    --%s) words='%s' ;;\n", option->name, words);
}

static void write_completion(FILE *stream, const struct vw_program *program, const struct vw_program_command *none) {
    (void)none;
    const char *name = program->name;
    fprintf(stream, "# Bash completion of %s, generated from its table of options.\n_%s() {\n", name, name);
    fputs("    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} options='' words=''\n"
          "    case ${COMP_WORDS[1]} in\n",
          stream);
    for (uint32_t i = 0; i < program->command_count; i++) write_command_options(stream, program, &program->commands[i]);
    fputs("    esac\n    case $before in\n", stream);
    for (uint32_t i = 0; i < vw_program_option_count(program); i++)
        write_option_words(stream, vw_program_option(program, i));
    fputs("    esac\n"
          "    if ((COMP_CWORD == 1)) || [[ $COMP_CWORD == 2 && ${COMP_WORDS[1]} == help ]]; then\n        words='",
          stream);
    for (uint32_t i = 0; i < program->command_count; i++) fprintf(stream, "%s ", program->commands[i].name);
    fputs("help --help --version'\n    elif [[ $word == -* ]]; then\n        words=$options\n    fi\n"
          "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
          "}\n",
          stream);
    fprintf(stream, "complete -o default -F _%s %s # file names where there is nothing to offer\n", name, name);
}

// ---- Files ----

typedef void write_document(FILE *stream, const struct vw_program *program, const struct vw_program_command *command);

// Writes a document. Frees `path`, which is NULL when memory is short.
static enum vw_status write_file(char *path, write_document *write, const struct vw_program *program,
                                 const struct vw_program_command *command) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream document;
    if (!path) return VW_ERROR_MEMORY;
    if (vw_text_stream_open(&document)) write(document.stream, program, command);
    enum vw_status status = vw_text_stream_close(&document, path, &text, &size_bytes);
    if (!status) status = vw_file_write(path, text, size_bytes);
    free(text);
    free(path);
    return status;
}

enum vw_status vw_manual_write(const struct vw_program *program, const char *folder) {
    if (!*folder) return vw_fail(VW_ERROR_USAGE, "--generate-docs: name the folder to write into");
    const char *name = program->name;
    char *man = vw_path_join(folder, "man"), *completions = vw_path_join(folder, "completion");
    enum vw_status status = man && completions ? vw_folder_create(man) : VW_ERROR_MEMORY;
    if (!status) status = vw_folder_create(completions);
    if (!status) status = write_file(vw_format_text("%s/%s.1", man, name), write_program_page, program, NULL);
    for (uint32_t i = 0; i < program->command_count && !status; i++)
        status = write_file(vw_format_text("%s/%s-%s.1", man, name, program->commands[i].name), write_command_page,
                            program, &program->commands[i]);
    if (!status) status = write_file(vw_path_join(completions, name), write_completion, program, NULL);
    free(man);
    free(completions);
    return status;
}
