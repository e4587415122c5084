// Scores from what was measured beside the steps: `value --same-state` and --first-order. Of PSNR and of L1 each,
// oriented so that positive = helps.
//
// same_state_*: the mean, over the states that were probed and the draws at each, of what a step on the photo does to
// the measure of that state. Source: option (c) of Cheimariotis et al. (see value.h). visits: draws in all. The
// standard error comes from the means of the states (NaN below two), since the draws of a state share what is peculiar
// to it; the sampling error is what the draws contribute: sqrt(mean over states of the draws' variance / visits), NaN
// where no state has two.
//
// first_order_*: the sum, over the photo's steps behind burn-in, of the measure's derivative along the step times the
// step. The standard error is that of a sum of `visits` independent contributions; there is no sampling error.
//
// Neither has an interval or one of its rank: these errors heed nothing that the states or the epochs of a run share.
#ifndef VIEWWORTH_VALUE_PROBE_SCORES_H
#define VIEWWORTH_VALUE_PROBE_SCORES_H

#include "viewworth/value.h"

struct vw_probe_method {
    const char *name, *unit, *formula;
};
// All of them, in the order of scores, whether or not a run has such probes.
const struct vw_probe_method *vw_probe_methods(uint32_t *count);

// Appends a score per train image for every method of which a run has probes with values: method by method, in image
// order. `scores` has room for vw_probe_methods' count times image_count more.
enum vw_status vw_probe_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                      uint32_t *score_count);

#endif
