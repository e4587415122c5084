// The photos and seeds of the retrainings of worth. They follow from the number of each retraining alone, so that more
// can be added later.
#ifndef VIEWWORTH_EXPERIMENT_WORTH_PLAN_H
#define VIEWWORTH_EXPERIMENT_WORTH_PLAN_H

#include "ledger/retraining.h"
#include "value/evaluation/subsets.h"
#include "value/worth.h"

struct vw_worth_plan_params {
    const uint32_t *photos; // image_ids that may be trained on, ascending; borrowed until the plan is freed
    uint32_t photo_count;
    const char *const *providers; // by photo; also borrowed; NULL: none
    uint32_t count;               // retrainings at most
    uint64_t key;                 // plans of other keys draw other subsets; not 0, which is of benchmarks
    uint64_t first_seed;          // seed of the first retraining; those after it count up
    uint32_t epochs;
};

struct vw_worth_plan {
    struct vw_worth_plan_params params;
    const char *providers[VW_WORTH_PROVIDERS_MAX + 1];
    uint32_t provider_count;                   // at most VW_WORTH_PROVIDERS_MAX + 1, which is too many
    struct vw_subsets of_photos, of_providers; // in the order of the retrainings
};

// Makes the plan. Returns VW_ERROR_INPUT when the photos have fewer subsets. Free it also after a failure.
enum vw_status vw_worth_plan_make(const struct vw_worth_plan_params *params, struct vw_worth_plan *plan);
void vw_worth_plan_free(struct vw_worth_plan *plan);

// Retrainings 0 ... count - 1, without outcomes: one array, owned by the caller (free), as vw_ledger_get_retrainings.
enum vw_status vw_worth_plan_list(const struct vw_worth_plan *plan, uint32_t count,
                                  struct vw_ledger_retraining **retrainings);
// Makes retrainings first ... count - 1 and fills their outcomes.
enum vw_status vw_worth_plan_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                   vw_retrain_function *retrain, void *context);

#endif
