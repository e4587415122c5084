// Scores: what each photo is worth, computed from step records alone (no GPU).
//
// Source: Cheimariotis et al., "Image valuation in NeRF-based 3D reconstruction", CAIP 2025: the step form. The delta d
// of the photo used at step t is the validation measure after the step minus the one before it; a score is made of a
// photo's deltas over all epochs e = 1 ... E from `burn_in` on. Steps flagged non-finite have no value: they are left
// out, and the next delta is taken from the last finite value. Every delta and every score is oriented so that positive
// = helps. The methods, each seen through PSNR (_psnr: the mean over validation views; _psnr_pooled) or mean absolute
// error (_loss):
//
//   dv_psnr, dv_loss, dv_psnr_pooled   sum of d: the paper's equation
//   revisit_*          sum of d, but each the measure minus the one after this photo's visit before (also one in
//   burn-in): the words of the
//                      paper's overview figure. The sum telescopes to the last visit's measure minus the first's
//   last_epoch_psnr    d in the run's last epoch
//   linear_psnr        sum of w d with w = 2 e / (E + 1): later epochs weigh more (the paper's "training progress");
//   weights have mean 1 exponential_psnr   likewise, w = exp(3 e / E) divided by its mean middle_*           sum of d
//   over the epochs E/6 < e <= E/2 (rounded up): after the large early deltas, before the noise of late ones win_rate_*
//   visits that helped less visits that harmed, per visit: in [-1,1]. The share of visits that helped is (1 + score) /
//   2
//                      where no d is 0
//   root_*             cube root of the sum of d, which keeps the sign: large damage weighs less
//   root_sum_psnr      sum of sign(d) sqrt|d|: a single outsized delta weighs less
//   clipped_*          sum of d, each clipped at three robust spreads (statistics.h) from the median of its epoch
//   momentum_*         sum of credits c(t) = (d(t) - b d(t - 1)) / (1 - b), d(t - 1) of the step before, on whatever
//   photo: solves
//                      d(t) = sum over k of (1 - b) b^k c(t - k), which is what Adam's first moment (Kingma and Ba,
//                      ICLR 2015) makes of the gradients, and so of the credits to first order, with momentum b; only
//                      for runs with b > 0. A step whose d, or that of the step before, is not known has no credit
#ifndef VIEWWORTH_VALUE_H
#define VIEWWORTH_VALUE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

// What scores are computed from: the rows of a ledger. Borrowed.
struct vw_value_input {
    const struct vw_step_record *records; // all steps in order
    uint64_t record_count;
    const struct vw_probe *probes; // by step and index; none without --noise-floor, --same-state and --first-order
    uint64_t probe_count;
    uint32_t burn_in_epochs;
    const struct vw_ledger_image *images; // by image_id
    uint32_t image_count;
    double beta1; // momentum of the run's optimiser; 0 without
};

struct vw_value_method {
    const char *name, *unit, *formula; // the formula in a line; d, e and E as above
    bool additive;                     // a sum over visits, so that scores of several photos add up
};
// Every method, in the order of the scores; of runs without momentum those named momentum_* have no scores.
const struct vw_value_method *vw_value_methods(uint32_t *count);
// What tables show first.
extern const char vw_value_default_method[];

// Every method's score for every train image, method by method, in image order: value, unit, standard error and
// interval from what the photo contributes in each epoch (src/value/uncertainty.h; of a cube root the ends of the sum's
// interval with the standard error scaled alike), visits that count, interval of the rank, and the sampling error (what
// the draws of the photo's own steps contribute, each from the state it started in; draws before it, of other photos
// too, move that state and are not in it): sqrt(sum of the visits' squared weights times the mean over the photo's
// probed steps of the variance of the delta over the redraws and the step itself, all from the same state); NaN without
// such a step and for methods that are no weighted sum of step deltas.
// `*scores` is owned by the caller (free); method and unit strings are static. A method for which no photo has a visit
// that counts has no scores; no step after burn-in gives count 0. VW_ERROR_INPUT for a step on an image that is not
// among them, VW_ERROR_MEMORY. The probes' methods (src/value/probe_scores.h) have no intervals.
enum vw_status vw_value_score(const struct vw_value_input *input, struct vw_ledger_score **scores,
                              uint32_t *score_count);
// One method's values alone, by image: what vw_value_score gives, but NaN for an image without a visit that counts, and
// everywhere where `method` is not one of vw_value_methods. VW_ERROR_INPUT and VW_ERROR_MEMORY as there.
enum vw_status vw_value_of_method(const struct vw_value_input *input, const char *method, double *values);

// The noise of the measurement, from a run's probes of it (`value --noise-floor`). NaN where no probe of that kind has
// a value.
struct vw_noise_floor {
    uint64_t repeated_count, zero_learning_rate_count, resampled_count; // probes of each kind that have values
    double repeated_db,
        zero_learning_rate_db; // largest |delta of val_psnr| by validating once more, by a step with learning rate 0: 0
                               // exactly where validation is a pure function of the params
    double
        resampled_db; // root mean square over probed steps of the spread (standard deviation) of the delta of val_psnr
    double resampled_l1; // likewise of val_l1
};
void vw_value_noise_floor(const struct vw_value_input *input, struct vw_noise_floor *floor);

VW_PUBLIC_END

#endif
