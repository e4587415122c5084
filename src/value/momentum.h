// Momentum-aware attribution: with Adam's beta1 = b the step at t moves the params by a mix of gradients, (1 - b) b^k of the one k steps
// ago, and so, to first order, does its delta of credits: delta(t) = sum over k of (1 - b) b^k c(t - k). The kernel is Adam's own (Kingma
// and Ba, "Adam: a method for stochastic optimization", ICLR 2015: the first moment); what is new here is to solve for the credits.
#ifndef VIEWWORTH_VALUE_MOMENTUM_H
#define VIEWWORTH_VALUE_MOMENTUM_H

#include <stdint.h>

#include "value/series.h"
#include "viewworth/status.h"

// Turns the step deltas of the visits into credits. Solves for one worth w per photo (of a visit) that explains all deltas in the sense of
// least squares, together with what is still in the first moment when burn-in ends. The credit of a visit is then w of its photo plus its
// share of what w leaves unexplained: (1 + b) times the residuals r that its gradient reaches, sum over k of b^k r(t + k). Over the visits
// of a photo those shares add up to nothing (the normal equations), so that its credits add up to visits * w. With b = 0 credits are
// deltas, to rounding. Steps without a value were not taken, or not seen: they stay without one. VW_ERROR_MEMORY.
enum vw_status vw_momentum_deconvolve(double beta1, uint32_t image_count, struct vw_series *series);

#endif
