// From the rows of a ledger to scores.
#ifndef VIEWWORTH_SCORING_H
#define VIEWWORTH_SCORING_H

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/value.h"

// Reads what scores are computed from: the ledger's steps, probes and lasting credit, owned here, and its images, lent
// by the ledger. `config` is the run's. Unload it also after a failure.
enum vw_status vw_scoring_load(struct vw_ledger *ledger, const struct vw_config *config, struct vw_value_input *input);
void vw_scoring_unload(struct vw_value_input *input);

struct vw_scoring {
    struct vw_value_input input;
    struct vw_ledger_score *scores;
    uint32_t score_count;
    struct vw_noise_floor noise_floor;
};

// Computes all scores from the ledger's steps and probes; `config` is the run's. Free it also after a failure.
enum vw_status vw_scoring_make(struct vw_ledger *ledger, const struct vw_config *config, struct vw_scoring *scoring);
void vw_scoring_free(struct vw_scoring *scoring);

#endif
