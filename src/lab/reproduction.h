// Reproduction: the same scene valued with several seeds, and how far the scores agree.
#ifndef VIEWWORTH_LAB_REPRODUCTION_H
#define VIEWWORTH_LAB_REPRODUCTION_H

#include <stdint.h>

#include "experiment/experiment.h"
#include "lab/evaluation/full_agreement.h"
#include "lab/lasting_seeds.h"
#include "lab/reproduced_methods.h"
#include "viewworth/status.h"

// The agreement of all methods after some epochs.
struct vw_reproduction_stop {
    uint32_t epochs;
    uint64_t training_rays; // rays of a run until then: epochs x photos x rays
    struct vw_score_tables tables;
    struct vw_full_agreement **pairs; // owned, and each of them: [table][pair], (0,1), (0,2), ..., (1,2), ...
};

struct vw_reproduction {
    const struct vw_experiment_params *params; // borrowed
    const struct vw_method_params *evaluated;  // borrowed
    uint32_t pair_count;
    struct vw_reproduction_stop *stops; // owned: every 5 epochs (more epochs where that gives more than 20 stops); the
                                        // last one is after all epochs
    uint32_t stop_count;
    char *agreement_path, *scatter_path;  // owned
    struct vw_lasting_seeds lasting;      // empty unless params->lasting.wanted
    struct vw_reproduced_methods methods; // in the last stop; empty unless evaluated->methods are named
    char *report_path;                    // owned; NULL when there is no report
};

// Values the scene with params->seeds seeds and compares the scores, after params->config->epochs epochs at most. What
// differs between the runs is params->config->vary; for all but
// VW_VARY_ALL and VW_VARY_ALL_VALIDATION the base seed is the first one. Writes to OUT:
// - seed_<seed>/: the runs (experiment/experiment.h)
// - retrainings.db and gradient_scores_<seed>.csv, with evaluated->methods
// - reproduce.csv: header method,epochs,training_rays,seed_a,seed_b,photos,measure,value; a row per method, stop, pair
//   and measure (vw_agreement_name). `photos`: the number compared. An empty value: undefined.
// - scatter.csv: header name,method,seed_a,seed_b,value_a,value_b,corrupted; a row per method, pair and train photo
// after
//   all epochs. `corrupted`: 1 or 0, empty where ground truth is unknown.
// - lasting_seeds.csv (lasting_seeds.h), with params->lasting.wanted
// - report.html
// Free the result also after a failure.
enum vw_status vw_reproduction_make(const struct vw_experiment_params *params, const struct vw_method_params *evaluated,
                                    struct vw_reproduction *reproduction);
void vw_reproduction_free(struct vw_reproduction *reproduction);

#endif
