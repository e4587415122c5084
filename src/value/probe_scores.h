// Scores from probes (`value --same-state`, --first-order), by PSNR and by L1, oriented so that positive = helps.
//
// same_state_*: the mean change of the measure by a step on the photo, over the probed states and the draws of pixels
// at each. Source: option (c) of Cheimariotis et al. (see value.h). visits: number of draws. The standard error is that
// of the means per state (NaN below two states), because the draws of a state share the state. resampling_stderr is the
// part of the draws: sqrt(mean over states of the draws' variance / visits), NaN if no state has two draws.
//
// first_order_*: the sum, over the photo's steps after burn-in, of the derivative of the measure along the step times
// the step's length. The standard error is that of a sum of `visits` independent contributions; resampling_stderr is
// NaN.
//
// Neither has an interval of its value or rank, because these errors ignore what states or epochs of a run share.
#ifndef VIEWWORTH_VALUE_PROBE_SCORES_H
#define VIEWWORTH_VALUE_PROBE_SCORES_H

#include "viewworth/value.h"

struct vw_probe_method {
    const char *name, *unit, *formula;
};
// All of these methods, in the order of scores.
const struct vw_probe_method *vw_probe_methods(uint32_t *count);

// Appends a score per train image for every method for which the run has probes with values: method by method, in image
// order. `scores` must have room for vw_probe_methods' count times image_count more.
enum vw_status vw_probe_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                      uint32_t *score_count);

#endif
