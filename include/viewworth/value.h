// Scores: what each photo is worth, computed from the rows of a ledger alone (no GPU).
//
// Source: Cheimariotis et al., "Image valuation in NeRF-based 3D reconstruction", CAIP 2025, the step form.
//
// The delta d of a step is the validation measure after the step minus the measure before it; it is credited to the
// photo that the step trained on. _psnr methods measure the weighted mean over validation views of the PSNR, _loss
// methods the mean absolute error. Every delta is oriented so that positive = better. A score combines the deltas of a
// photo over the E epochs e = 1 ... E after burn-in. A step that is flagged as non-finite has no delta, and the next
// delta starts from the last finite value. The methods:
//
//   dv_psnr, dv_loss
//       sum of d: the photo's credit, what the steps on it moved. A negative credit does not say that training is
//       better without the photo
//   momentum_psnr
//       sum of (d(t) - b d(t - 1)) / (1 - b), where b is the momentum: inverts Adam's filter to first order. Only for
//       runs with b > 0. A step has no credit if its d or that of the step before is unknown
//   quality
//       how well the photo fits, 0 to 1 (best): the mean of its ranks by dv_loss and by minus its late training loss.
//       Not a sum; its zero means nothing; a photo without both has none (src/value/quality.h of the source tree)
//   train_fit
//       minus the late training loss, in dB (-10 log10 of the run's own loss): how well the photo itself fits, whatever
//       it does for others. Not a sum; its zero means nothing
//   lasting_psnr, lasting_loss
//       what the end of the training gains by the steps on the photo, to first order. Compare photos with each other;
//       zero has no meaning. Only for runs with a backward pass (src/value/lasting_scores.h)
//   worth_psnr
//       the loss of validation PSNR of a training on all photos without the photo, at equal steps and over seeds: below
//       0 the photo harms. Only for runs with retrainings (src/value/worth.h)
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
    struct vw_lasting_pass lasting;  // not used unless it has a row for every record but the first
    double beta1;                    // momentum of the run's optimiser, in [0,1); 0: none
    const struct vw_method *further; // methods to compute after all others: those of the laboratory; NULL: none
    uint32_t further_count;
};

struct vw_value_method {
    const char *name, *unit, *formula; // the formula in one line, with d, e and E as above
    bool additive;                     // the scores of several photos can be added
    bool has_zero;                     // 0 means something: scores may be compared with it
};
// Lists all methods but those of vw_value_input.further, in the order of the scores. The array is static.
const struct vw_value_method *vw_value_methods(uint32_t *count);
// Returns NULL for a name that is not in vw_value_methods.
const struct vw_value_method *vw_value_method_find(const char *name);
// The method of every run with scores: "dv_psnr".
extern const char vw_value_default_method[];
// Returns the method that answers for a photo's value, which tables, report and selection use unless another is named:
// "worth_psnr" if it has scores, else "lasting_psnr", else "dv_psnr".
const char *vw_value_main_method(const struct vw_ledger_score *scores, uint32_t score_count);

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
