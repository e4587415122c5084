// Scores from probes (`value --same-state`), oriented so that positive = better.
//
// same_state_psnr: the mean change of val_psnr by a step on the photo, over the probed states and the draws of pixels
// at each. Source: option (c) of Cheimariotis et al. (see value.h). visits: number of draws. The standard error is that
// of the means per state (NaN below two states), because the draws of a state share the state. resampling_stderr is the
// part of the draws: sqrt(mean over states of the draws' variance / visits), NaN if no state has two draws. There is no
// interval of the value or the rank, because these errors ignore what the states of a run share.
#ifndef VIEWWORTH_VALUE_PROBE_SCORES_H
#define VIEWWORTH_VALUE_PROBE_SCORES_H

#include "viewworth/value.h"

// Appends a score per train image, in image order, if the run has such probes with values. `scores` must have room for
// image_count more. VW_ERROR_INPUT for a probe of an image that is not in `images`, VW_ERROR_MEMORY.
enum vw_status vw_probe_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                      uint32_t *score_count);

#endif
