// A row of a table of options: the only source for parsing, help, man pages and completion.
#ifndef VIEWWORTH_CLI_OPTION_H
#define VIEWWORTH_CLI_OPTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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

#endif
