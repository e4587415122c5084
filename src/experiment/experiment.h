// The request of an experiment: a scene, the config of its trainings, and the folder of the results. An experiment
// makes several runs or retrainings, resumes those that the folder contains, and writes its tables there.
#ifndef VIEWWORTH_EXPERIMENT_EXPERIMENT_H
#define VIEWWORTH_EXPERIMENT_EXPERIMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "run/lasting/lasting_summary.h"
#include "run/session.h"
#include "viewworth/gpu.h"
#include "viewworth/ledger.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_experiment_params {
    struct vw_scene_params scene;   // path is needed; gpu is ignored
    const struct vw_config *config; // needed; its seed is the first one
    struct vw_device_choice devices;
    const char *out;   // needed
    uint32_t seeds;    // as many are compared: config->seed and those after it
    uint32_t together; // runs or trainings that take their steps together on each device; 0: by it
    struct vw_report_options report;
    struct vw_lasting_options lasting; // for single runs
    struct vw_interrupt interrupt;     // asked between submissions of steps, and between retrainings
    vw_run_progress *progress;         // called by single runs; NULL: none
    void *context;                     // passed to progress
};

// Checks what can be checked before any work: that `seed_count` seeds from the first on exist, that OUT can be a
// folder, and, with `scores`, that epochs are left after burn-in. VW_ERROR_USAGE names the option.
enum vw_status vw_experiment_check(const struct vw_experiment_params *params, uint32_t seed_count, bool scores);
// Opens devices and scene, and logs what was found. Does nothing when they are open.
enum vw_status vw_experiment_open_session(const struct vw_experiment_params *params, struct vw_session *session);

// ---- Valued runs that take their steps at the same time, and differ by the seed: each in OUT/seed_<seed> ----

// Makes params->seeds runs, from the seed of the config on, in a pool on the devices of the session, which is opened
// unless it is open; the caller closes it. A run that is there is resumed; a finished one stays as it is. After a
// failure no other run begins, but those that have begun go on. VW_ERROR_USAGE when OUT itself contains a run, or when
// a folder contains another one: the message says what differs. After VW_ERROR_INTERRUPTED the same call resumes.
enum vw_status vw_seed_runs_make(const struct vw_experiment_params *params, struct vw_session *session);
// Returns the path of a file of a seed's run ("field.vwf"), owned by the caller; NULL when memory is short.
char *vw_seed_run_path(const char *out, uint64_t seed, const char *file);
// Opens the ledger of a seed's run; the caller closes it. VW_ERROR_INPUT when there is none, or a link.
enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger);

// ---- Prices ---------------------------------------------------------------------------------------------------------

// The prices of the commands that train: how often, and how long on a scene, at every accuracy level.

enum { VW_PRICED_COMMANDS = 5, VW_PRICED_LEVELS = 4 };

struct vw_priced_command {
    const char *name, *words; // "worth"; "worth --retrainings 64", which the price is of
    uint32_t trainings;       // at most
};
extern const struct vw_priced_command vw_priced_commands[VW_PRICED_COMMANDS];

struct vw_level_prices {
    const char *level;
    uint64_t steps;                     // steps of one training
    double seconds[VW_PRICED_COMMANDS]; // NaN: too few steps to measure, or the level does not fit
};

// Measures steps of the scene at every level, with the other numbers of the config and the explicit ones
// (vw_config_explicit) that a level would set, for a second or two each.
enum vw_status vw_prices_estimate(const struct vw_config *config, uint64_t explicit_fields,
                                  const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_decision *effects, uint32_t effect_count,
                                  struct vw_level_prices prices[VW_PRICED_LEVELS]);

#endif
