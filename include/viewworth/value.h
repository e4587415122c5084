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

// What scores are computed from: the rows of a ledger. Borrowed.
struct vw_value_input {
    const struct vw_step_record *records; // all steps in order
    uint64_t record_count;
    const struct vw_probe *probes; // by step and index; none without --noise-floor, --same-state and --first-order
    uint64_t probe_count;
    uint32_t burn_in_epochs;
    const struct vw_ledger_image *images; // by image_id
    uint32_t image_count;
};

// Every method's score for every train image, method by method, in image order: value, unit, standard error (of a sum of `visits` deltas:
// their standard deviation times sqrt(visits); NaN below 2 visits), visits, and the sampling error (what the draws of the photo's own steps
// contribute, each from the state it started in; draws before it, of other photos too, move that state and are not in it): sqrt(visits
// times the mean over the photo's probed steps of the variance of the delta over the redraws and the step itself, all from the same state);
// NaN without such a step.
// `*scores` is owned by the caller (free); method and unit strings are static. No step after burn-in gives count 0.
enum vw_status vw_value_score(const struct vw_value_input *input, struct vw_ledger_score **scores, uint32_t *score_count);

// The noise of the measurement, from a run's probes of it (`value --noise-floor`). NaN where no probe of that kind has a value.
struct vw_noise_floor {
    uint64_t repeats, stills, redraws; // probes of each kind that have values
    double repeat_db, still_db; // largest |delta of val_psnr| by validating once more, by a step with learning rate 0: 0 exactly where
                                // validation is a pure function of the params
    double redraw_db;           // root mean square over probed steps of the spread (standard deviation) of the delta of val_psnr
    double redraw_l1;           // likewise of val_l1
};
void vw_value_noise_floor(const struct vw_value_input *input, struct vw_noise_floor *floor);

#endif
