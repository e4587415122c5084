// The command line as a struct: what a command was asked to do. cli/option_table.c has the options.
#ifndef VIEWWORTH_CLI_OPTIONS_H
#define VIEWWORTH_CLI_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>

#include "experiment/photo_sets.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_program;

// --preset: the options of a published method by one name.
enum vw_option_preset {
    VW_PRESET_NONE,
    VW_PRESET_HASH,
    VW_PRESET_SPLATS,
    VW_PRESET_NERF,
    VW_PRESET_NERF_W,
    VW_PRESET_HA_NERF,
    VW_PRESET_PAPER,
    VW_PRESET_COUNT
};
// Returns the options that a preset sets: "NAME=VALUE NAME=VALUE ...".
const char *vw_option_preset_options(enum vw_option_preset preset);

// An option that may be repeated, in the order given.
enum { VW_TEXTS_MOST = 32 };
struct vw_texts {
    const char *texts[VW_TEXTS_MOST];
    uint32_t count;
};

// Everything that a command line can contain. Texts are borrowed from argv; NULL: the option was not given.
struct vw_options {
    const char *operand;         // the command's first operand, SCENE for example
    const char *const *operands; // all operands
    uint32_t operand_count;
    const char *device;
    const char *memory;           // for pixels, with its unit
    struct vw_scene_params scene; // path: the operand
    struct vw_config config;
    const char *initial; // the .ply file that the config begins from
    const char *out;
    bool resume, profile;
    uint32_t seeds;    // number of runs; select has a default of its own
    uint32_t together; // trainings in a submission; 0: by the device
    struct vw_lasting_options lasting;
    struct vw_report_options report;
    const char *payout;
    uint32_t retrainings;    // in all
    double until_confidence; // 0: make all of them
    const char *accuracy, *budget;
    enum vw_option_preset preset;
    const char *expect;
    uint32_t replay_steps;  // 0: none; UINT32_MAX: all, as of retrainings
    const char *parameters; // names of those that tradeoff changes
    const char *view;
    const char *cameras, *points; // files that export writes
    const char *to, *copy;
    bool quick;
    const char *rule;
    const char *method; // the method that selects photos
    struct vw_texts lists;
    enum vw_equal equal;
    const char *scores; // OUT of a valued run
    bool depth;
    const char *pose, *path, *video; // where render stands, without a photo
    uint32_t frames;
    const char *among;   // poses that next chooses among
    uint32_t proposals;  // places that next proposes
    const char *devices; // indices or names with commas between, or "all"
    uint32_t per_device; // processes at a time
    uint32_t job;        // the only one to run, from 1; 0: all
    bool slurm;
    bool json, quiet, help;
    const struct vw_program *program; // private: whose options these are
    uint64_t given[2];                // private: a bit per option of the program
};

// The options of a command line that has none. The config's are vw_config_default.
#define VW_OPTIONS_DEFAULT                                                                                             \
    { .per_device = 1, .seeds = 3, .frames = 60, .proposals = 10 }

// Groups of options that commands take. Every command takes VW_OPTIONS_ALWAYS.
enum {
    VW_OPTIONS_DEVICE = 1,
    VW_OPTIONS_SCENE = 2,
    VW_OPTIONS_TRAINING = 4,
    VW_OPTIONS_OUT = 8, // --out, which is required, and --resume
    VW_OPTIONS_VIEW = 16,
    VW_OPTIONS_JSON = 32,
    VW_OPTIONS_NEXT = 64,
    VW_OPTIONS_VERIFY = 128,
    VW_OPTIONS_EXPORT = 256,
    VW_OPTIONS_ALWAYS = 512,
    VW_OPTIONS_CHECK = 1024,
    VW_OPTIONS_IMPORT = 2048,     // --out, which is required, and the training options that scores depend on
    VW_OPTIONS_ONE_RUN = 8192,    // commands that make a single run
    VW_OPTIONS_ONE_VALUE = 16384, // commands that value a single run
    VW_OPTIONS_RUNS = 32768,      // commands that make several runs in one folder (--out is required) and always resume
    VW_OPTIONS_SELECT = 65536,
    VW_OPTIONS_COMPARE = 131072,
    VW_OPTIONS_REPORT = 262144,
    VW_OPTIONS_THUMBNAILS = 524288, // commands that write a report
    VW_OPTIONS_TRADEOFF = 1048576,
    VW_OPTIONS_LASTING = 4194304, // commands that may compute lasting credit
    VW_OPTIONS_WORTH = 8388608,
    VW_OPTIONS_BATCH = 16777216,
    VW_OPTIONS_MERGE = 33554432,
    VW_OPTIONS_OTHER = 67108864, // the first of a program that adds options of its own
    // Options of the command value; the jobs of a batch accept them too.
    VW_OPTIONS_OF_VALUE = VW_OPTIONS_DEVICE | VW_OPTIONS_SCENE | VW_OPTIONS_TRAINING | VW_OPTIONS_ONE_RUN |
                          VW_OPTIONS_ONE_VALUE | VW_OPTIONS_LASTING | VW_OPTIONS_OUT | VW_OPTIONS_THUMBNAILS |
                          VW_OPTIONS_JSON,
};

#endif
