// Scores: what each photo is worth, computed from step records alone (no GPU).
//
// Source: Cheimariotis et al., "Image valuation in NeRF-based 3D reconstruction", CAIP 2025: the step form. The delta of the photo used
// at step t is the validation measure after the step minus the one before it; a score is the sum of a photo's deltas over all epochs
// from `burn_in` on. Steps flagged non-finite have no value: they are left out, and the next delta is taken from the last finite value.
// Every score is oriented so that positive = helps.
#ifndef VIEWWORTH_VALUE_H
#define VIEWWORTH_VALUE_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/step_record.h"

// Every method's score for every train image, method by method, in image order: value, unit, standard error (of a sum of `visits` deltas:
// their standard deviation times sqrt(visits); NaN below 2 visits) and visits. `*scores` is owned by the caller (free); method and unit
// strings are static. No step after burn-in gives count 0.
enum vw_status vw_value_score(const struct vw_step_record *records, uint64_t record_count, uint32_t burn_in_epochs,
                              const struct vw_ledger_image *images, uint32_t image_count, struct vw_ledger_score **scores,
                              uint32_t *score_count);

#endif
