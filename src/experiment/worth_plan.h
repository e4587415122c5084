// The photos and seeds of the retrainings of worth. They follow from the number of each retraining among those of its
// kind alone, so that more can be added later, and so that retrainings with whole providers change none of the others.
#ifndef VIEWWORTH_EXPERIMENT_WORTH_PLAN_H
#define VIEWWORTH_EXPERIMENT_WORTH_PLAN_H

#include "ledger/retraining.h"
#include "value/evaluation/subsets.h"
#include "value/worth.h"

struct vw_worth_plan_params {
    const uint32_t *photos; // image_ids that may be trained on, ascending; borrowed until the plan is freed
    uint32_t photo_count;
    const char *const *providers;  // by photo; also borrowed; NULL: none
    uint32_t count;                // retrainings at most, but those with whole providers
    uint32_t provider_retrainings; // retrainings with whole providers at most
    uint64_t key;                  // plans of other keys draw other subsets; not 0, which is of benchmarks
    uint64_t first_seed;           // seed of the first retraining; those after it count up
    uint32_t epochs;
};

struct vw_worth_plan {
    struct vw_worth_plan_params params;
    const char *providers[VW_WORTH_PROVIDERS_MAX + 1];
    uint32_t provider_count;                   // at most VW_WORTH_PROVIDERS_MAX + 1, which is too many
    struct vw_subsets of_photos, of_providers; // in the order of the retrainings
};

// Makes the plan. Returns VW_ERROR_INPUT when the photos have fewer subsets, VW_ERROR_USAGE when whole providers are
// asked for and there is one, or too many. Free it also after a failure.
enum vw_status vw_worth_plan_make(const struct vw_worth_plan_params *params, struct vw_worth_plan *plan);
void vw_worth_plan_free(struct vw_worth_plan *plan);

// The part of the plan that is carried out.
struct vw_worth_plan_progress {
    const struct vw_ledger_retraining *recorded; // borrowed; their kinds say in which order they were made
    uint32_t recorded_count;
    uint32_t photo_retrainings, provider_retrainings; // how many there will be in all, those recorded included
};
// Lists the recorded retrainings and the next ones, those with whole providers last, without outcomes: one array, owned
// by the caller (free), as vw_ledger_get_retrainings.
enum vw_status vw_worth_plan_list(const struct vw_worth_plan *plan, const struct vw_worth_plan_progress *progress,
                                  struct vw_ledger_retraining **retrainings);
// Fills in what is trained; the retrainings lend their photos.
void vw_worth_plan_describe(const struct vw_ledger_retraining *retrainings, uint32_t count,
                            struct vw_retrain_params *trained);
// Makes retrainings first ... count - 1 and fills their outcomes.
enum vw_status vw_worth_plan_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                   vw_retrain_function *retrain, void *context);

#endif
