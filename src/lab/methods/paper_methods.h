// The other forms of scores from steps that Cheimariotis et al. (CAIP 2025) discuss, in the terms of viewworth/value.h.
// revisit_* follows the overview figure; the paper rejects the last epoch and progress weights.
//
//   revisit_psnr, revisit_loss
//       sum over visits of the measure minus the measure after the photo's previous visit (which may be in burn-in);
//       this is how the paper's overview figure puts it. The sum telescopes to the last visit's measure minus the
//       first's
//   last_epoch_psnr
//       d in the last epoch
//   linear_psnr
//       sum of w d, w = 2 e / (E + 1): later epochs weigh more (the paper's "training progress"); the mean of w is 1
//   exponential_psnr
//       sum of w d, w = exp(3 e / E) divided by its mean
#ifndef VIEWWORTH_LAB_METHODS_PAPER_METHODS_H
#define VIEWWORTH_LAB_METHODS_PAPER_METHODS_H

#include "value/methods.h"

// The methods, as vw_value_input.further takes them.
extern const struct vw_method vw_paper_methods[];
extern const uint32_t vw_paper_method_count;

#endif
