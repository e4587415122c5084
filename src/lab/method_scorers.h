// The methods of methods/registry.h as scorers of the runs of an experiment: one per method and budget,
// "tmc_shapley_40" or "tmc_shapley_4N", as the budget was given.
#ifndef VIEWWORTH_LAB_METHOD_SCORERS_H
#define VIEWWORTH_LAB_METHOD_SCORERS_H

#include "lab/methods/registry.h"
#include "lab/scorers.h"

// The methods that are evaluated beside the scores of the product.
struct vw_method_params {
    const char *methods;         // names with commas between, or "all"; NULL: none
    const char *run_equivalents; // their budgets with commas between: numbers, and N, N/2, 4N, ... of N train photos;
                                 // NULL: the default ones
    bool paper_methods;          // also the other forms of scores that the paper discusses (value.h)
};

extern const char vw_method_budgets_default[]; // "1,2,4,10,N,4N"

enum { VW_METHOD_BUDGETS_MAX = 12, VW_METHOD_NAME_BYTES = 40 };

// Checks names and budgets before any training. VW_ERROR_USAGE.
enum vw_status vw_method_scorers_check(const struct vw_method_params *params);
// Returns how many seeds, from that of the config on, the experiment has with those of the methods' retrainings.
uint32_t vw_method_scorers_seed_count(const struct vw_experiment_params *params);
// Returns how many retrainings the methods of `seeds` runs need at most.
uint64_t vw_method_scorers_count(const struct vw_method_params *params, uint32_t seeds,
                                 const struct vw_retrainer *retrainer);
// Adds the scorers of each valued run. A budget that is too small for a method is left out, with a line in
// the log. `*names` is owned by the caller (free), also after a failure, and outlives the scorers.
enum vw_status vw_method_scorers_add(const struct vw_method_params *params, struct vw_retrainer *retrainer,
                                     struct vw_scorers *scorers, char (**names)[VW_METHOD_NAME_BYTES]);

#endif
