// Scores: what each photo is worth, computed from the rows of a ledger alone (no GPU).
//
// Source: Cheimariotis et al., "Image valuation in NeRF-based 3D reconstruction", CAIP 2025, the step form.
//
// The delta d of a step is the validation measure after the step minus the measure before it; it is credited to the
// photo that the step trained on. _psnr methods measure the mean over validation views of the PSNR, _loss methods the
// mean absolute error. Every delta is oriented so that positive = better. A score combines the deltas of a photo over
// the E epochs e = 1 ... E after burn-in. A step that is flagged as non-finite has no delta, and the next delta starts
// from the last finite value. The methods:
//
//   dv_psnr, dv_loss
//       sum of d: the paper's equation. dv_psnr is the photo's credit: what the steps on the photo moved. A negative
//       credit does not say that training is better without the photo
//   momentum_psnr
//       sum of credits c(t) = (d(t) - b d(t - 1)) / (1 - b), where t - 1 is the step before, on whatever photo, and b
//       is the momentum. This inverts d(t) = sum over k of (1 - b) b^k c(t - k), which is how Adam's first moment
//       (Kingma and Ba, ICLR 2015) spreads the credits to first order. Only for runs with b > 0. A step has no credit
//       if its d or that of the step before is unknown
//   quality
//       how well the photo fits: the mean of two ranks, each scaled to [0,1] (ties share their mean): that of dv_loss,
//       and that of minus the mean training loss over the photo's visits in the last third of the E epochs (rounded
//       up). 1 fits best. It finds photos that do not fit, such as those with occluders, wrong exposure, noise or a
//       wrong pose; it does not find blur. It does not say what they are worth. It is not a sum, and its zero means
//       nothing. A photo without both has no quality. Its standard error is that of a block bootstrap (Kuensch, "The
//       jackknife and the bootstrap for general stationary observations", Annals of Statistics 1989), seeded: 400
//       times, blocks of neighbouring epochs (E^(1/3) long, at most half of the late third; circular) are drawn anew,
//       within the late third and within the epochs before it, for both ranks and all photos alike. The variance is
//       divided by the share that such blocks show of it (1 - length of a block / late epochs) and raised by half for
//       what all epochs of a run share (as in src/value/uncertainty.h of the source tree). The 95 % interval is that of
//       Student with E - 1 degrees of freedom, cut to [0,1]; NaN below four epochs
//   lasting_psnr, lasting_loss
//       the effect of the steps on the photo at the end of the training: the sum, over all steps t on the photo
//       (those of burn-in too), of lambda(t) . s(t), where s(t) is the step's change of the params and lambda(t) the
//       gradient by the params after step t of U, the mean over states of the last epochs of the validation PSNR
//       (dB), or of minus the mean absolute error. lambda is carried back from the end step by step: lambda <- lambda
//       - H P lambda, with P the preconditioner of Adam and H the Gauss-Newton product (Martens, "Deep learning via
//       Hessian-free optimization", ICML 2010). So a step is credited with what U gains by it, to first order, with
//       all that later steps repair or undo (Hara et al., "Data cleansing for models trained with SGD", NeurIPS 2019;
//       Ilyas and Engstrom, "MAGIC", arXiv 2504.16430). Scores of several photos can be added. Compare photos with
//       each other; zero has no meaning. Only for runs with a backward pass (viewworth lasting). The pass covers one
//       seed, so there is no standard error and no interval; reproduce --lasting measures them over seeds
//   worth_psnr
//       the loss of validation PSNR of a training on all photos without the photo, at equal steps and over seeds: below
//       0 the photo harms. Only for runs with retrainings (`worth`). Their outcomes U(S), means over the ends of the
//       last epochs, are fitted by U(S) = c + g log s + sum over photos of b_i (x_i / s - 1), where s is the share of
//       photos in S and x_i is 1 in S, otherwise 0: at equal steps the members share the training. Worth is the fit's
//       difference at all photos. b minimises sum of (U - fit)^2 + lambda |b - B f|^2 + rho lambda |B - B0|^2, where f
//       has the standardised scores lasting_psnr, dv_psnr, lasting_loss, dv_loss and quality that every photo has, and
//       B0 is lasting_psnr in dB, unscaled. Fits of 64 (lambda, rho) are averaged by their left-out error E as
//       E^(-n/2); the interval is Student's, of the posterior variance within and between them
//       (src/value/evaluation/worth_regression.h of the source tree). Least-squares worths are a datamodel (Ilyas et
//       al. 2022). The joint worth of a provider is fitted in the same way, with providers as players
//
// The other forms that the paper discusses, only on request (vw_value_input.paper_methods):
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
#ifndef VIEWWORTH_VALUE_H
#define VIEWWORTH_VALUE_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

// The rows of a ledger from which scores are computed. All borrowed.
struct vw_value_input {
    const struct vw_step_record *records; // all steps in order
    uint64_t record_count;
    uint32_t burn_in_epochs;
    const struct vw_ledger_image *images; // by image_id
    uint32_t image_count;
    struct vw_lasting_pass lasting; // not used unless it has a row for every record but the first
    double beta1;                   // momentum of the run's optimiser, in [0,1); 0: none
    bool paper_methods;             // also compute the other forms that the paper discusses, after all others
};

struct vw_value_method {
    const char *name, *unit, *formula; // the formula in one line, with d, e and E as above
    bool additive;                     // the scores of several photos can be added
    bool has_zero;                     // 0 means something: scores may be compared with it
};
// Lists all methods but those of vw_value_input.paper_methods, in the order of the scores. The array is static.
const struct vw_value_method *vw_value_methods(uint32_t *count);
// Returns NULL for a name that is not in vw_value_methods.
const struct vw_value_method *vw_value_method_find(const char *name);
// The method that tables show first: "dv_psnr".
extern const char vw_value_default_method[];

// Computes the score of every method for every train image, method by method, in image order. Each score has
// - value, unit, visits (the number of visits that count);
// - standard_error and the ends of the 95 % interval of value and rank, from the photo's contribution in each epoch
//   (src/value/uncertainty.h of the source tree).
// Scores of lasting credit have no intervals. A method has no scores if no photo has a visit that counts; without a
// step after burn-in the count is 0. `*scores` is owned by the caller (free); its strings are static. VW_ERROR_INPUT
// for a step on an image that is not in `images`, VW_ERROR_MEMORY.
enum vw_status vw_value_score(const struct vw_value_input *input, struct vw_ledger_score **scores,
                              uint32_t *score_count);

VW_PUBLIC_END

#endif
