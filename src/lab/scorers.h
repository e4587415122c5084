// The scorers of the runs of an experiment: the scoring methods of the valued runs, and the baselines.
#ifndef VIEWWORTH_LAB_SCORERS_H
#define VIEWWORTH_LAB_SCORERS_H

#include <stdbool.h>

#include "experiment/experiment.h"
#include "experiment/retrain.h"
#include "lab/evaluation/evaluation.h"
#include "lab/methods/photo_features.h"

enum { VW_SCORERS_MAX = 256 };

// Cost of one set of scores.
struct vw_scorer_cost {
    double trainings; // on all photos; shorter ones are parts of one
    double seconds;   // CPU time; 0: that of as many trainings
};

struct vw_scorers {
    struct vw_evaluation evaluation; // its arrays are those below
    struct vw_scorer list[VW_SCORERS_MAX];
    double *scores[VW_SCORERS_MAX]; // owned; [seed][photo] of each
    struct vw_scorer_cost costs[VW_SCORERS_MAX];
    const char **ground_truths;        // owned array
    struct vw_photo_features features; // features of the photos, and of the valued runs
};

extern const char vw_leave_one_out_scorer[]; // "leave_one_out": scores by retraining without each photo

// Returns true if that is the name of a method (with its budget if it has one), of a baseline, of leave-one-out or of
// the worths from subsets.
bool vw_scorer_exists(const char *name);
// Opens the retrainer of an experiment's scorers: its results are means over the ends of the last epochs.
enum vw_status vw_scorers_open_retrainer(const struct vw_experiment_params *params, struct vw_session *session,
                                         enum vw_equal equal, struct vw_retrainer *retrainer);
// Reads the runs of the first `seed_count` seeds in params->out, and computes features and what needs no retraining.
// Methods without a score for some photo are left out. Free it also after a failure.
enum vw_status vw_scorers_make(const struct vw_experiment_params *params, const struct vw_retrainer *retrainer,
                               uint32_t seed_count, struct vw_scorers *scorers);
// Adds a scorer whose scores the caller fills, [seed][photo], all NaN at first; NULL when memory is short. `scorer`
// gives all but the scores.
double *vw_scorers_add(struct vw_scorers *scorers, struct vw_scorer scorer, struct vw_scorer_cost cost);
// Takes out those without a score for some photo, with a line in the log: sums over subsets need all.
void vw_scorers_drop_incomplete(struct vw_scorers *scorers);
// Fills scores[photo] with the worth from `count` retrainings of the evaluation's photos, whose prior is the scores of
// a valued seed; NaN where there are too few.
enum vw_status vw_scorers_find_worth(const struct vw_scorers *scorers, uint32_t valued,
                                     const struct vw_ledger_retraining *retrainings, uint32_t count, double *scores);
void vw_scorers_free(struct vw_scorers *scorers);

#endif
