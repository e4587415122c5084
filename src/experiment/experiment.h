// The request of an experiment: a scene, the config of its trainings, and the folder of the results. An experiment
// makes several runs or retrainings, resumes those that the folder contains, and writes its tables there.
#ifndef VIEWWORTH_EXPERIMENT_EXPERIMENT_H
#define VIEWWORTH_EXPERIMENT_EXPERIMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "run/lasting/lasting_summary.h"
#include "run/session.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

struct vw_experiment_params {
    struct vw_scene_params scene;   // path is needed; gpu is ignored
    const struct vw_config *config; // needed; its seed is the first one
    struct vw_device_choice devices;
    const char *out;   // needed
    uint32_t seeds;    // as many are compared: config->seed and those after it
    uint32_t together; // runs or trainings that take their steps together on each device; 0: by it
    struct vw_report_options report;
    bool paper_methods; // reproduce: also the other forms of scores that the paper discusses (value.h)
    const char *methods, *run_equivalents; // benchmark, reproduce: as method_scorers.h has them
    struct vw_lasting_options lasting;     // for single runs
    struct vw_interrupt interrupt;         // asked between batches of steps, and between retrainings
    vw_run_progress *progress;             // called by single runs; NULL: none
    void *context;                         // passed to progress
};

// Checks what can be checked before any work: that `seed_count` seeds from the first on exist, that OUT can be a
// folder, and, with `scores`, that epochs are left after burn-in. VW_ERROR_USAGE names the option.
enum vw_status vw_experiment_check(const struct vw_experiment_params *params, uint32_t seed_count, bool scores);
// Opens devices and scene, and logs what was found. Does nothing when they are open.
enum vw_status vw_experiment_open_session(const struct vw_experiment_params *params, struct vw_session *session);

#endif
