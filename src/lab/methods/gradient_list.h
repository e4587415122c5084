// The methods that score photos by gradients along one run (gradient_scores.h).
#ifndef VIEWWORTH_LAB_METHODS_GRADIENT_LIST_H
#define VIEWWORTH_LAB_METHODS_GRADIENT_LIST_H

#include <stdbool.h>

enum vw_gradient_method {
    VW_GRADIENT_IN_RUN_FIRST,
    VW_GRADIENT_IN_RUN_SECOND,
    VW_GRADIENT_TRACIN,
    VW_GRADIENT_TRACIN_ADAM,
    VW_GRADIENT_INFLUENCE,
    VW_GRADIENT_METHODS
};

struct vw_gradient_method_row {
    const char *name, *meaning;
    bool has_sign; // a score below 0 says that the photo harms
    // In trainings with validation: the run, and what the pass takes beside, which the methods of a pass share
    // (../../train/README.md, "Scores from gradients").
    double run_equivalents;
};
// Their names in the order of the table, for texts.
#define VW_GRADIENT_METHOD_NAMES "in_run_shapley, in_run_shapley_second, tracin, tracin_adam, influence"
extern const struct vw_gradient_method_row vw_gradient_methods[VW_GRADIENT_METHODS];

#endif
