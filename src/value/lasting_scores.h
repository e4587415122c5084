// The scores lasting_psnr and lasting_loss, from the backward pass over a run: the effect of the steps on a photo at
// the end of the training. Scores of several photos can be added.
//
// A score is the sum, over all steps t on the photo (those of burn-in too), of lambda(t) . s(t), where s(t) is the
// step's change of the params and lambda(t) the gradient by the params after step t of U, the mean over states of the
// last epochs of the validation PSNR (dB), or of minus the mean absolute error. lambda is carried back from the end
// step by step: lambda <- lambda - H P lambda, with P the preconditioner of Adam and H the Gauss-Newton product
// (Martens, "Deep learning via Hessian-free optimization", ICML 2010). So a step is credited with what U gains by it,
// to first order, with all that later steps repair or undo (Hara et al., "Data cleansing for models trained with SGD",
// NeurIPS 2019; Ilyas and Engstrom, "MAGIC", arXiv 2504.16430). The pass covers one seed, so there is no standard error
// and no interval; reproduce --lasting measures them over seeds.
#ifndef VIEWWORTH_VALUE_LASTING_SCORES_H
#define VIEWWORTH_VALUE_LASTING_SCORES_H

#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/value.h"

// Appends them for every train image, in image order; nothing without a backward pass over exactly the input's steps,
// and no lasting_loss where the first step's is NaN (halves.h). There is no standard error: the pass contains nothing
// of other seeds, by which lasting credit differs most.
enum vw_status vw_lasting_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                        uint32_t *score_count);

// The growth of the gradient during the backward pass: the largest ratio of its length at a step to that at a later
// one. Lengths of steps that U itself averages over do not count, unless all do. 1: it never grew.
struct vw_lasting_growth {
    double factor;
    uint64_t first_step, last_step; // it grew from last_step back to first_step
};
struct vw_lasting_growth vw_lasting_growth_of(const struct vw_lasting_pass *pass, uint64_t steps_per_epoch);

// Returns Pearson's correlation of predicted and measured over the photos of the gate. NaN: fewer than three.
double vw_lasting_gate(const struct vw_lasting_pass *pass, bool loss);
extern const double vw_lasting_gate_least; // below it lasting credit is not to be trusted

#endif
