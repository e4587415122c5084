// Coverage: what a photo tells of the trained field that the other photos do not tell, as a prior of its worth. From
// the photo's camera alone: no colour of the photo enters.
//   I_i(e) = sum over pixels of photo i and channels of (d colour / d e)^2, the Fisher information of grid entry e
//            under colour errors of equal variance; without its terms between entries (FisherRF, arXiv 2311.17874)
//   coverage(i) = sum over e of log((l + sum over all j of I_j(e)) / (l + sum over j other than i of I_j(e)))
// Photos of the same camera share what they cover: each copy lowers the coverage of the others. No unit; more = covers
// more; it has no zero that says anything.
#ifndef VIEWWORTH_TRAIN_COVERAGE_H
#define VIEWWORTH_TRAIN_COVERAGE_H

#include <stdint.h>

#include "train/probes/probe_context.h"

// The l of the formula: this share of the mean of sum over j of I_j(e), over the entries that any photo informs.
extern const double coverage_prior_share;
double vw_coverage_prior(const double *total, uint64_t count);
// One photo's coverage by `count` entries: `total` is the sum over all photos, `own` among them.
double vw_coverage_of(const double *total, const double *own, uint64_t count, double prior);

// Of every train photo, in the order of schedule->train_views, for the params that are on the device; these keep their
// bits. I is estimated (Hutchinson) by squared gradients of colours with random signs: `passes` times, each on as many
// pixels as a step has, the same ones of every photo. When nothing is in flight.
enum vw_status vw_coverage_measure(const struct vw_probe_context *context, uint32_t passes, double *coverage);

#endif
