// Methods of the literature in a reproduction: what they say of each of its runs, beside what the ledgers say.
#ifndef VIEWWORTH_LAB_REPRODUCED_METHODS_H
#define VIEWWORTH_LAB_REPRODUCED_METHODS_H

#include "experiment/experiment.h"
#include "lab/method_scorers.h"
#include "lab/scorers.h"
#include "value/evaluation/score_tables.h"

struct vw_reproduced_methods {
    struct vw_scorers *scorers;          // owned; NULL: none are asked for
    char (*names)[VW_METHOD_NAME_BYTES]; // owned
    uint32_t *photos;                    // owned: those of the scorers
};

// Scores the photos of each run, which is there, by evaluated->methods, with retrainings of its own seeds in
// OUT/retrainings.db. Does nothing without any. Free it also after a failure.
enum vw_status vw_reproduced_methods_make(const struct vw_experiment_params *params,
                                          const struct vw_method_params *evaluated, struct vw_session *session,
                                          struct vw_reproduced_methods *methods);
// Adds their tables, and those of the baselines that depend on a run: the others agree whatever the seed. `images` are
// those of the runs; the names live as long as `methods`.
enum vw_status vw_reproduced_methods_add(const struct vw_reproduced_methods *methods,
                                         const struct vw_ledger_image *images, struct vw_score_tables *tables);
// Returns the cost of a set of a method's scores; NULL when that is not known.
const struct vw_scorer_cost *vw_reproduced_methods_cost(const struct vw_reproduced_methods *methods,
                                                        const char *method);
void vw_reproduced_methods_free(struct vw_reproduced_methods *methods);

#endif
