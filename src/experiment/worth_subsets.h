// The photos and seeds of the retrainings of worth. They follow from the number of each retraining alone, so that more
// can be added later.
#ifndef VIEWWORTH_EXPERIMENT_WORTH_SUBSETS_H
#define VIEWWORTH_EXPERIMENT_WORTH_SUBSETS_H

#include "ledger/retraining.h"
#include "value/evaluation/outcomes.h"
#include "value/worth.h"

struct vw_worth_subsets_params {
    const uint32_t *photos; // image_ids that may be trained on, ascending; borrowed until they are freed
    uint32_t photo_count;
    uint32_t count;      // retrainings at most
    uint64_t key;        // other keys draw other subsets; not 0, which is of benchmarks
    uint64_t first_seed; // seed of the first retraining; those after it count up
    uint32_t epochs;
};

struct vw_worth_subsets {
    struct vw_worth_subsets_params params;
    struct vw_subsets subsets; // in the order of the retrainings
};

// Draws the subsets. Returns VW_ERROR_INPUT when the photos have fewer subsets. Free it also after a failure.
enum vw_status vw_worth_subsets_draw(const struct vw_worth_subsets_params *params, struct vw_worth_subsets *drawn);
void vw_worth_subsets_free(struct vw_worth_subsets *drawn);

// Lists the first `count` retrainings without outcomes: one array, owned by the caller (free), as
// vw_ledger_get_retrainings.
enum vw_status vw_worth_retrainings_list(const struct vw_worth_subsets *drawn, uint32_t count,
                                         struct vw_ledger_retraining **retrainings);
// Fills in what is trained; the retrainings lend their photos.
void vw_worth_retrainings_describe(const struct vw_ledger_retraining *retrainings, uint32_t count,
                                   struct vw_retrain_params *trained);
// Makes retrainings first ... count - 1 and fills their outcomes.
enum vw_status vw_worth_retrainings_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                          vw_retrain_function *retrain, void *context);

#endif
