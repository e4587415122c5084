// The options of viewworth, and how a row of a table of options reads: the only source for parsing, help, man pages and
// completion.
#ifndef VIEWWORTH_CLI_OPTION_TABLE_H
#define VIEWWORTH_CLI_OPTION_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cli/options.h"
#include "viewworth/train.h"

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

struct vw_command;
struct vw_program;

struct vw_option {
    const char *name;     // without dashes
    const char *argument; // what help calls the value; NULL: a flag, or one of the choices
    const char *help;     // one sentence without its full stop; range and default are added
    unsigned groups;      // VW_OPTIONS_* of the commands that take it
    enum vw_option_section section;
    enum vw_option_kind kind;
    size_t offset;            // of its field in the options of the program
    bool common;              // shown by --help, not by --help-all alone
    uint32_t least, most;     // range of a count that is not in vw_config, which has its own ranges; most 0: none
    const char *default_text; // the default of a text; NULL: none, or not worth a word
    const char *words;        // values that completion offers, with spaces between; NULL: file names
    const char *(*choice_name)(uint32_t choice);
    uint32_t choice_count;
};

// The fields of a row that say where its value goes, and the range of a count.
#define VW_OPTION_FIELD(options, type, field) .kind = VW_OPTION_##type, .offset = offsetof(options, field)
#define VW_OPTION_RANGE(from, to) .least = from, .most = to

extern const struct vw_option vw_option_table[];
extern const uint32_t vw_option_count;
extern const struct vw_options vw_options_default;

const char *vw_option_section_title(enum vw_option_section section);
// Whether the command takes the option.
bool vw_option_fits(const struct vw_option *option, const struct vw_command *command);
// Whether the command requires --out.
bool vw_command_needs_out(const struct vw_command *command);
// The numbers that an option accepts, for example "1 to 65536"; "" if it takes no number.
void vw_option_range(const struct vw_option *option, char text[VW_CONFIG_RANGE_BYTES]);
// The names of an option's choices with the separator between; "" without choices.
enum { VW_OPTION_CHOICES_BYTES = 128 };
void vw_option_choices(const struct vw_option *option, char separator, char text[VW_OPTION_CHOICES_BYTES]);
// "--rays N".
enum { VW_OPTION_USAGE_BYTES = 160 };
void vw_option_usage(const struct vw_option *option, char text[VW_OPTION_USAGE_BYTES]);
// The help sentence with range and default: "Training rays per step (1 to 65536, default 500)."
enum { VW_OPTION_HELP_BYTES = 640 };
void vw_option_sentence(const struct vw_program *program, const struct vw_option *option,
                        char text[VW_OPTION_HELP_BYTES]);

#endif
