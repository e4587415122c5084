// A program: its commands and options, from which parsing, help, man pages and completion follow.
#ifndef VIEWWORTH_CLI_PROGRAM_H
#define VIEWWORTH_CLI_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "cli/options.h"
#include "viewworth/status.h"

// ---- Options: rows of tables, the only source for parsing, help, man pages and completion ---------------------------

enum vw_option_kind {
    VW_OPTION_FLAG,   // bool
    VW_OPTION_TEXT,   // const char *
    VW_OPTION_TEXTS,  // struct vw_texts
    VW_OPTION_COUNT,  // uint32_t
    VW_OPTION_SEED,   // uint64_t
    VW_OPTION_REAL,   // double
    VW_OPTION_CHOICE, // an enum of 32 bits, by its names
    VW_OPTION_EFFECTS // the config's own copy
};

// The headings under which help and man pages list options, in this order.
enum vw_option_section {
    VW_SECTION_MAIN,
    VW_SECTION_SCENE,
    VW_SECTION_TRAINING,
    VW_SECTION_TIME,
    VW_SECTION_SCORES,
    VW_SECTION_FIELD,
    VW_SECTION_GENERAL,
    VW_SECTION_COUNT
};

struct vw_option {
    const char *name;     // without dashes
    const char *argument; // name of the value in help; NULL: a flag, or one of the choices
    const char *help;     // one sentence without its full stop; range and default are added
    unsigned groups;      // VW_OPTIONS_* of the commands that take it
    enum vw_option_section section;
    enum vw_option_kind kind;
    size_t offset;            // offset of its field in the options of the program
    bool common;              // shown by --help, not by help COMMAND alone
    bool all;                 // a count that may be "all", which is the largest of its range
    const char *zero;         // the word for a count of 0, which is not in its range; NULL: none
    uint32_t least, most;     // range of a count that is not in vw_config, which has its own ranges; most 0: none
    const char *default_text; // the default of a text; NULL: none, or not worth a word
    const char *needs;        // option that must be given too, where the command has it; NULL: none
    const char *words;        // values that completion offers, with spaces between; NULL: file names
    char letter;              // its short form, "o" for "-o"; 0: none
    const char *(*choice_name)(uint32_t choice);
    uint32_t choice_count;
};

// The fields of a row that say where its value goes, and the range of a count.
#define VW_OPTION_FIELD(options, type, field) .kind = VW_OPTION_##type, .offset = offsetof(options, field)
#define VW_OPTION_RANGE(from, to) .least = from, .most = to

// ---- Commands -------------------------------------------------------------------------------------------------------

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

static inline uint32_t vw_program_option_count(const struct vw_program *program) {
    return *program->tables[0].count + (program->tables[1].count ? *program->tables[1].count : 0);
}

static inline const struct vw_option *vw_program_option(const struct vw_program *program, uint32_t index) {
    uint32_t first_count = *program->tables[0].count;
    return index < first_count ? &program->tables[0].rows[index] : &program->tables[1].rows[index - first_count];
}

// Reads a command's arguments (argv[0] is the command's name) over the program's defaults; `options` begins a struct of
// program->options_bytes. VW_ERROR_USAGE names the option and what it takes or needs. With --help nothing
// is required.
enum vw_status vw_options_parse(const struct vw_program *program, const struct vw_program_command *command, int argc,
                                char **argv, struct vw_options *options);
// Returns true if the command line contains the option of that name (without dashes).
bool vw_options_have(const struct vw_options *options, const char *name);
// Runs what the command line says. Prints errors to stderr, and returns the exit code.
int vw_program_run(const struct vw_program *program, int argc, char **argv);

// The options of viewworth, which viewworth-lab extends.
extern const struct vw_option vw_option_table[];
extern const uint32_t vw_option_count;
extern const struct vw_options vw_options_default;

// ---- Interrupts -----------------------------------------------------------------------------------------------------

// Ctrl-C and SIGTERM as a request to stop between two pieces of work, so that what is recorded stays whole.

// Returns an interrupt that watches from the first time that it is asked. The first SIGINT or SIGTERM of the process
// after that only makes it requested; the second one ends the program. A signal before that ends the program at once.
struct vw_interrupt vw_interrupt_watch(void);
// Asks the kernel for a SIGTERM when the batch that started this process ends, however it ends; nothing without one.
void vw_interrupt_follow_batch(void);

#endif
