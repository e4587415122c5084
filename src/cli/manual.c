#include "cli/manual.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "cli/help.h"
#include "cli/option_table.h"
#include "viewworth/version.h"

// ---- Man pages ----

// Text as roff prints it unchanged: hyphens that can be copied, no control lines, paragraphs between newlines.
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

static void write_option(FILE *stream, const struct vw_option *option) {
    char usage[VW_OPTION_USAGE_BYTES], sentence[VW_OPTION_HELP_BYTES];
    vw_option_usage(option, usage);
    vw_option_sentence(option, sentence);
    fputs(".TP\n.B ", stream);
    write_roff(stream, usage);
    write_roff(stream, sentence);
}

static void write_options(FILE *stream, const struct vw_command *command) {
    fputs(".SH OPTIONS\n", stream);
    for (enum vw_option_section section = 0; section < VW_SECTION_COUNT; section++) {
        bool has_title = false;
        for (int i = 0; i < vw_option_count; i++) {
            const struct vw_option *option = &vw_option_table[i];
            if (option->section != section || !vw_option_fits(option, command)) continue;
            if (!has_title) fprintf(stream, ".SS %s\n", vw_option_section_title(section));
            has_title = true;
            write_option(stream, option);
        }
    }
}

static void write_command_page(FILE *stream, const char *page, const struct vw_command *command) {
    write_title(stream, page);
    write_name(stream, page, command->summary);
    fprintf(stream, ".SH SYNOPSIS\n.B viewworth %s\n", command->name);
    char *call = vw_format_text("%s%s [options]", command->operand ? command->operand : "",
                                vw_command_needs_out(command) ? " --out FOLDER" : "");
    if (call) write_roff(stream, call + (call[0] == ' '));
    free(call);
    fputs(".SH DESCRIPTION\n", stream);
    char *description = vw_format_text("%s.\n%s", command->summary, command->details ? command->details : "");
    if (description) write_roff(stream, description);
    free(description);
    write_options(stream, command);
    write_ends(stream, "viewworth(1)");
}

static void write_program_page(FILE *stream, const struct vw_command *commands, size_t count) {
    write_title(stream, "viewworth");
    write_name(stream, "viewworth", "What each photo is worth to a 3-D reconstruction");
    fputs(".SH SYNOPSIS\n.B viewworth\nCOMMAND [options]\n.SH DESCRIPTION\n", stream);
    write_roff(stream, "viewworth trains a radiance field from posed photos, one photo per step, and measures the "
                       "validation photos after every step. It keeps a ledger of how much each photo changed the "
                       "validation error, and computes scores with uncertainty from it.");
    fputs(".SH COMMANDS\n", stream);
    for (enum vw_command_group group = 0; group < VW_COMMANDS_COUNT; group++) {
        fprintf(stream, ".SS %s\n", vw_command_group_title(group));
        for (size_t i = 0; i < count; i++) {
            if (commands[i].group != group) continue;
            fputs(".TP\n.B ", stream);
            write_roff(stream, commands[i].name);
            write_roff(stream, commands[i].summary);
        }
    }
    write_ends(stream, "viewworth-value(1) and a page for every other command: viewworth-COMMAND(1)");
}

// ---- Bash completion ----

static void write_command_words(FILE *stream, const struct vw_command *commands, size_t count) {
    for (size_t i = 0; i < count; i++) fprintf(stream, "%s ", commands[i].name);
    fputs("--help --version", stream);
}

static void write_command_options(FILE *stream, const struct vw_command *command) {
    fprintf(stream, "    %s) options='", command->name);
    for (int i = 0; i < vw_option_count; i++)
        if (vw_option_fits(&vw_option_table[i], command)) fprintf(stream, " --%s", vw_option_table[i].name);
    fputs("' ;;\n", stream);
}

static void write_option_words(FILE *stream, const struct vw_option *option) {
    char choices[VW_OPTION_CHOICES_BYTES];
    vw_option_choices(option, ' ', choices);
    const char *words = choices[0] ? choices : option->words;
    if (words) fprintf(stream, "    --%s) words='%s' ;;\n", option->name, words);
}

static void write_completion(FILE *stream, const struct vw_command *commands, size_t count) {
    fputs("# Bash completion of viewworth, generated from its table of options.\n"
          "_viewworth() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} options='' words=''\n"
          "    case ${COMP_WORDS[1]} in\n",
          stream);
    for (size_t i = 0; i < count; i++) write_command_options(stream, &commands[i]);
    fputs("    esac\n    case $before in\n", stream);
    for (int i = 0; i < vw_option_count; i++) write_option_words(stream, &vw_option_table[i]);
    fputs("    esac\n    if ((COMP_CWORD == 1)); then\n        words='", stream);
    write_command_words(stream, commands, count);
    fputs("'\n    elif [[ $word == -* ]]; then\n        words=$options\n    fi\n"
          "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
          "}\n"
          "complete -o default -F _viewworth viewworth # file names where there is nothing to offer\n",
          stream);
}

// ---- Files ----

struct page {
    const char *name; // of the man page; NULL: the completion
    const struct vw_command *command;
    const struct vw_command *commands; // all of them, if `command` is NULL
    size_t count;
};

static void write_page(FILE *stream, const struct page *page) {
    if (page->command) write_command_page(stream, page->name, page->command);
    else if (page->name) write_program_page(stream, page->commands, page->count);
    else write_completion(stream, page->commands, page->count);
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

static enum vw_status write_command_pages(const char *folder, const struct vw_command *commands, size_t count) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < count && !status; i++) {
        char *name = vw_format_text("viewworth-%s", commands[i].name);
        status = name ? write_man_page(folder, &(struct page){.name = name, .command = &commands[i]}) : VW_ERROR_MEMORY;
        free(name);
    }
    return status;
}

enum vw_status vw_manual_write(const char *folder, const struct vw_command *commands, size_t count) {
    if (!*folder) return vw_fail(VW_ERROR_USAGE, "--generate-docs: name the folder to write into");
    struct page program = {.name = "viewworth", .commands = commands, .count = count};
    struct page completion = {.commands = commands, .count = count};
    char *man = vw_path_join(folder, "man"), *completions = vw_path_join(folder, "completion");
    char *path = vw_path_join(folder, "completion/viewworth");
    enum vw_status status = man && completions && path ? vw_folder_create(man) : VW_ERROR_MEMORY;
    if (!status) status = vw_folder_create(completions);
    if (!status) status = write_man_page(folder, &program);
    if (!status) status = write_command_pages(folder, commands, count);
    if (!status) status = write_file(path, &completion);
    free(man);
    free(completions);
    free(path);
    return status;
}
