// Scores of the rows of a ledger.
#ifndef VIEWWORTH_RUN_SCORING_H
#define VIEWWORTH_RUN_SCORING_H

#include "value/worth.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/value.h"

// Reads what scores are computed from: the ledger's steps and lasting credit, owned here, and its images, lent
// by the ledger. `config` is the run's. Unload it also after a failure.
enum vw_status vw_scoring_load(struct vw_ledger *ledger, const struct vw_config *config, struct vw_value_input *input);
void vw_scoring_unload(struct vw_value_input *input);

struct vw_scoring {
    struct vw_value_input input;
    struct vw_ledger_score *scores;
    uint32_t score_count;
    struct vw_ledger_retraining *retrainings; // the ledger's
    uint32_t retraining_count;
};

// Returns VW_ERROR_USAGE where burn-in leaves no epoch to score.
enum vw_status vw_check_scored_epochs(uint32_t epochs, uint32_t burn_in_epochs);
// Computes all scores from the ledger's steps and retrainings; `config` is the run's. Free it also after a
// failure.
enum vw_status vw_scoring_make(struct vw_ledger *ledger, const struct vw_config *config, struct vw_scoring *scoring);
void vw_scoring_free(struct vw_scoring *scoring);
// Compares the scores in the ledger with the computed ones; VW_ERROR_MISMATCH names the first that differs by
// more than the rounding of another C library. `path` is the ledger's, for messages.
enum vw_status vw_scoring_compare(const struct vw_scoring *scoring, struct vw_ledger *ledger, const char *path);
// Ends a run that stops early as "interrupted" or "failed", with the scores so far. Where they find no room the ledger
// stays "running", with a warning: an ended run has the scores that its steps give.
void vw_scoring_end_early(struct vw_ledger *ledger, const struct vw_config *config, const char *outcome);
// Computes the scores anew after `input` was given more.
enum vw_status vw_scoring_repeat(struct vw_scoring *scoring);
// Computes worth anew from other retrainings, an array for free() that the scoring owns from now on.
enum vw_status vw_scoring_set_retrainings(struct vw_scoring *scoring, struct vw_ledger_retraining *retrainings,
                                          uint32_t count);

// Returns the input of worth, borrowed from the scoring.
struct vw_worth_input vw_scoring_worth_input(const struct vw_scoring *scoring);
// Returns the method that payouts use: worth if there is one, otherwise the default.
const char *vw_scoring_payout_method(const struct vw_ledger_score *scores, uint32_t score_count);

#endif
