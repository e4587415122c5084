// A program: its commands and options, from which parsing, help, man pages and completion follow.
#ifndef VIEWWORTH_CLI_PROGRAM_H
#define VIEWWORTH_CLI_PROGRAM_H

#include <stddef.h>
#include <stdint.h>

#include "cli/option.h"
#include "cli/options.h"
#include "viewworth/status.h"

struct vw_program_command {
    uint32_t group; // an index into the program's groups
    const char *name;
    const char *operand; // as help spells it; with "..." at its end one or more; NULL: none
    const char *summary; // an imperative sentence without full stop
    const char *details; // its results and remarks; paragraphs end with \n; NULL: nothing more
    unsigned options;    // VW_OPTIONS_* it takes
    enum vw_status (*run)(const struct vw_options *options);
};

struct vw_option_rows {
    const struct vw_option *rows;
    const uint32_t *count;
};

enum { VW_PROGRAM_OPTIONS_MAX = 128 }; // bits of vw_options.given
struct vw_program {
    const char *name;          // "viewworth"
    const char *summary;       // one line without full stop
    const char *description;   // the paragraph of its man page
    const char *const *groups; // headings of commands in help, in this order; NULL ends them
    const struct vw_program_command *commands;
    uint32_t command_count;
    struct vw_option_rows tables[2];   // the second one is empty unless the program adds options
    const struct vw_options *defaults; // begins a struct of options_bytes; its config is not read
    size_t options_bytes;
};

// Returns the number of options in both tables.
static inline uint32_t vw_program_option_count(const struct vw_program *program) {
    return *program->tables[0].count + (program->tables[1].count ? *program->tables[1].count : 0);
}

static inline const struct vw_option *vw_program_option(const struct vw_program *program, uint32_t index) {
    uint32_t first_count = *program->tables[0].count;
    return index < first_count ? &program->tables[0].rows[index] : &program->tables[1].rows[index - first_count];
}

// Runs what the command line says. Prints errors to stderr, and returns the exit code.
int vw_program_run(const struct vw_program *program, int argc, char **argv);

// The options of viewworth, which viewworth-lab extends.
extern const struct vw_option vw_option_table[];
extern const uint32_t vw_option_count;
extern const struct vw_options vw_options_default;

#endif
