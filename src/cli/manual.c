#include "cli/help.h"
#include "cli/option_text.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "viewworth/version.h"

struct page {
    const struct vw_program *program;
    const char *name;                 // name of the man page; NULL: the completion
    const struct vw_command *command; // NULL: the program's own page
};

// ---- Man pages ----

// Writes text so that roff prints it unchanged: hyphens that can be copied, no control lines, paragraphs between
// newlines.
static void write_roff(FILE *stream, const char *text) {
    bool line_starts = true;
    for (; *text; text++) {
        if (line_starts && (*text == '.' || *text == '\'')) fputs("\\&", stream);
        line_starts = *text == '\n';
        if (*text == '\n') fputs("\n.PP\n", stream);
        else if (*text == '-') fputs("\\-", stream);
        else if (*text == '\\') fputs("\\e", stream);
        else fputc(*text, stream);
    }
    fputc('\n', stream);
}

static void write_title(FILE *stream, const char *page) {
    fputs(".TH \"", stream);
    for (const char *letter = page; *letter; letter++) fputc(toupper((unsigned char)*letter), stream);
    fprintf(stream, "\" 1 \"\" \"viewworth %s\" \"viewworth\"\n", vw_version());
}

static void write_name(FILE *stream, const char *page, const char *summary) {
    fputs(".SH NAME\n", stream);
    char *line = vw_format_text("%s - %c%s", page, tolower((unsigned char)summary[0]), summary + 1);
    if (line) write_roff(stream, line);
    free(line);
}

static void write_ends(FILE *stream, const char *see_also) {
    fputs(".SH EXIT STATUS\n.TP\n0\nThe command is done.\n.TP\n1\nThe command failed at run time. What was recorded is "
          "kept.\n.TP\n2\nThe command line or the input is wrong.\n.SH SEE ALSO\n",
          stream);
    write_roff(stream, see_also);
}

static void write_option(FILE *stream, const struct vw_program *program, const struct vw_option *option) {
    char usage[VW_OPTION_USAGE_BYTES], sentence[VW_OPTION_HELP_BYTES];
    vw_option_usage(option, usage);
    vw_option_sentence(program, option, sentence);
    fputs(".TP\n.B ", stream);
    write_roff(stream, usage);
    write_roff(stream, sentence);
}

static void write_options(FILE *stream, const struct vw_program *program, const struct vw_command *command) {
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

static void write_command_page(FILE *stream, const struct page *page) {
    const struct vw_program *program = page->program;
    const struct vw_command *command = page->command;
    write_title(stream, page->name);
    write_name(stream, page->name, command->summary);
    fprintf(stream, ".SH SYNOPSIS\n.B %s %s\n", program->name, command->name);
    char *call = vw_format_text("%s%s [options]", command->operand ? command->operand : "",
                                vw_command_needs_out(command) ? " --out FOLDER" : "");
    if (call) write_roff(stream, call + (call[0] == ' '));
    free(call);
    fputs(".SH DESCRIPTION\n", stream);
    char *description = vw_format_text("%s.\n%s", command->summary, command->details ? command->details : "");
    if (description) write_roff(stream, description);
    free(description);
    write_options(stream, program, command);
    char *see_also = vw_format_text("%s(1)", program->name);
    write_ends(stream, see_also ? see_also : "");
    free(see_also);
}

static void write_program_page(FILE *stream, const struct vw_program *program) {
    write_title(stream, program->name);
    write_name(stream, program->name, program->summary);
    fprintf(stream, ".SH SYNOPSIS\n.B %s\nCOMMAND [options]\n.SH DESCRIPTION\n", program->name);
    write_roff(stream, program->description);
    fputs(".SH COMMANDS\n", stream);
    for (uint32_t group = 0; program->groups[group]; group++) {
        fprintf(stream, ".SS %s\n", program->groups[group]);
        for (uint32_t i = 0; i < program->command_count; i++) {
            if (program->commands[i].group != group) continue;
            fputs(".TP\n.B ", stream);
            write_roff(stream, program->commands[i].name);
            write_roff(stream, program->commands[i].summary);
        }
    }
    char *see_also = vw_format_text("%s-COMMAND(1), a page for every command", program->name);
    write_ends(stream, see_also ? see_also : "");
    free(see_also);
}

// ---- Bash completion ----

static void write_command_words(FILE *stream, const struct vw_program *program) {
    for (uint32_t i = 0; i < program->command_count; i++) fprintf(stream, "%s ", program->commands[i].name);
    fputs("--help --version", stream);
}

static void write_command_options(FILE *stream, const struct vw_program *program, const struct vw_command *command) {
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

static void write_completion(FILE *stream, const struct vw_program *program) {
    const char *name = program->name;
    fprintf(stream, "# Bash completion of %s, generated from its table of options.\n_%s() {\n", name, name);
    fputs("    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} options='' words=''\n"
          "    case ${COMP_WORDS[1]} in\n",
          stream);
    for (uint32_t i = 0; i < program->command_count; i++) write_command_options(stream, program, &program->commands[i]);
    fputs("    esac\n    case $before in\n", stream);
    for (uint32_t i = 0; i < vw_program_option_count(program); i++)
        write_option_words(stream, vw_program_option(program, i));
    fputs("    esac\n    if ((COMP_CWORD == 1)); then\n        words='", stream);
    write_command_words(stream, program);
    fputs("'\n    elif [[ $word == -* ]]; then\n        words=$options\n    fi\n"
          "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
          "}\n",
          stream);
    fprintf(stream, "complete -o default -F _%s %s # file names where there is nothing to offer\n", name, name);
}

// ---- Files ----

static void write_page(FILE *stream, const struct page *page) {
    if (page->command) write_command_page(stream, page);
    else if (page->name) write_program_page(stream, page->program);
    else write_completion(stream, page->program);
}

static enum vw_status write_file(const char *path, const struct page *page) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream manual;
    if (!path) return VW_ERROR_MEMORY;
    if (vw_text_stream_open(&manual)) write_page(manual.stream, page);
    enum vw_status status = vw_text_stream_close(&manual, path, &text, &size_bytes);
    if (!status) status = vw_file_write(path, text, size_bytes);
    free(text);
    return status;
}

static enum vw_status write_man_page(const char *folder, const struct page *page) {
    char *path = vw_format_text("%s/man/%s.1", folder, page->name);
    enum vw_status status = write_file(path, page);
    free(path);
    return status;
}

static enum vw_status write_command_pages(const struct vw_program *program, const char *folder) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < program->command_count && !status; i++) {
        char *name = vw_format_text("%s-%s", program->name, program->commands[i].name);
        const struct page page = {.program = program, .name = name, .command = &program->commands[i]};
        status = name ? write_man_page(folder, &page) : VW_ERROR_MEMORY;
        free(name);
    }
    return status;
}

enum vw_status vw_manual_write(const struct vw_program *program, const char *folder) {
    if (!*folder) return vw_fail(VW_ERROR_USAGE, "--generate-docs: name the folder to write into");
    char *man = vw_path_join(folder, "man"), *completions = vw_path_join(folder, "completion");
    char *path = completions ? vw_path_join(completions, program->name) : NULL;
    enum vw_status status = man && path ? vw_folder_create(man) : VW_ERROR_MEMORY;
    if (!status) status = vw_folder_create(completions);
    if (!status) status = write_man_page(folder, &(struct page){.program = program, .name = program->name});
    if (!status) status = write_command_pages(program, folder);
    if (!status) status = write_file(path, &(struct page){.program = program});
    free(man);
    free(completions);
    free(path);
    return status;
}
