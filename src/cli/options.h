// The command line: one table of options, used for parsing and for --help alike.
#ifndef VIEWWORTH_CLI_OPTIONS_H
#define VIEWWORTH_CLI_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/train.h"

// An option that may be repeated, in the order given.
enum { VW_TEXTS_MOST = 32 };
struct vw_texts {
    const char *texts[VW_TEXTS_MOST];
    uint32_t count;
};

// What is made equal between lists of different lengths that are compared.
enum vw_equal { VW_EQUAL_STEPS, VW_EQUAL_EPOCHS };
const char *vw_equal_name(enum vw_equal equal); // "steps", "epochs"

// Everything a command line can say. Texts are borrowed from argv; NULL where nothing was said.
struct vw_options {
    const char *operand;         // SCENE or OUT, by command; the first where there may be several
    const char *const *operands; // all of them
    uint32_t operand_count;
    const char *device;
    const char *format;
    const char *pool;
    const char *train_list, *val_list, *test_list;
    const char *providers;
    uint32_t downscale;
    uint32_t corrupt;
    struct vw_config config;
    const char *out;
    bool resume, profile, measure;
    uint32_t seeds; // runs to compare
    const char *payout;
    double until_stable; // 0: take all epochs
    const char *accuracy, *budget;
    struct vw_plan *plan; // what these led to (cli/choice.h); NULL: nothing was chosen
    const char *expect;
    uint32_t replay_steps;
    uint32_t subsets;
    uint32_t halves;        // that a sweep evaluates scores by
    const char *parameters; // that a sweep turns
    bool leave_one_out;
    const char *curves;
    const char *view;
    const char *to;
    bool positive, significant, not_harmful;
    const char *top, *drop;
    const char *method; // whose scores choose
    struct vw_texts lists;
    enum vw_equal equal;
    const char *scores; // a valued run
    uint32_t views;
    bool no_thumbnails;
    bool json, quiet, help;
    uint64_t given[2]; // private: a bit per option
};

// Groups of options, as commands take them. --quiet and --help belong to every command.
enum {
    VW_OPTIONS_DEVICE = 1,
    VW_OPTIONS_SCENE = 2,
    VW_OPTIONS_TRAINING = 4,
    VW_OPTIONS_OUT = 8, // --out, which must be given, and --resume; likewise VW_OPTIONS_RUNS
    VW_OPTIONS_VIEW = 16,
    VW_OPTIONS_JSON = 32,
    VW_OPTIONS_VALUE = 64,
    VW_OPTIONS_VERIFY = 128,
    VW_OPTIONS_INFO = 256,
    VW_OPTIONS_ALWAYS = 512,
    VW_OPTIONS_REPRODUCE = 1024,
    VW_OPTIONS_IMPORT = 2048, // --out, which must be given, and what of the training bears on scores
    VW_OPTIONS_BENCHMARK = 4096,
    VW_OPTIONS_ONE_RUN = 8192,    // of commands that make a single run
    VW_OPTIONS_ONE_VALUE = 16384, // and value it
    VW_OPTIONS_RUNS = 32768,      // of commands that make several in one folder, and always go on with them
    VW_OPTIONS_SELECT = 65536,
    VW_OPTIONS_COMPARE = 131072,
    VW_OPTIONS_REPORT = 262144,
    VW_OPTIONS_THUMBNAILS = 524288, // of commands that write a report
    VW_OPTIONS_TRADEOFF = 1048576,
};

struct vw_command {
    const char *name;
    const char
        *operand; // the one operand it needs, as help spells it, or with "..." at its end at least one; NULL for none
    const char *summary; // one line
    const char *details; // what it leaves behind and what to know, for its own help
    unsigned options;    // VW_OPTIONS_* it takes
    enum vw_status (*run)(const struct vw_options *options);
};

// Reads a command's arguments (argv[0] is the command's name) over the defaults. VW_ERROR_USAGE names the option and
// what it takes. With --help nothing else is demanded.
enum vw_status vw_options_parse(const struct vw_command *command, int argc, char **argv, struct vw_options *options);
// Whether the command line had the option of that name, without dashes.
bool vw_options_have(const struct vw_options *options, const char *name);
// A command's usage and options with their defaults, to stdout.
void vw_options_print_help(const struct vw_command *command);

#endif
