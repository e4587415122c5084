// Everyone a benchmark evaluates: the methods of the valued runs, and the baselines.
#ifndef VIEWWORTH_SCORERS_H
#define VIEWWORTH_SCORERS_H

#include "experiment/retrain.h"
#include "value/evaluation/evaluation.h"

enum { VW_SCORERS_MAX = 256 };

struct vw_scorers {
    struct vw_evaluation evaluation; // its arrays are those below
    struct vw_scorer list[VW_SCORERS_MAX];
    double *scores[VW_SCORERS_MAX];     // owned; [seed][photo] of each
    uint32_t trainings[VW_SCORERS_MAX]; // that each takes
    const char **ground_truths;         // owned array
};

// Reads the valued runs in OUT, of --seed and the seeds after it, and measures the baselines. Methods that lack a value
// for some photo are left out. Free it also after a failure.
enum vw_status vw_scorers_make(const struct vw_retrainer *retrainer, uint32_t seed_count, struct vw_scorers *scorers);
// Adds one with scores to be filled, [seed][photo], all NaN: NULL when memory is short. `name` is borrowed.
double *vw_scorers_add(struct vw_scorers *scorers, const char *name, uint32_t trainings);
void vw_scorers_free(struct vw_scorers *scorers);

#endif
