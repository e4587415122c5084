// Worth: what a photo adds to trainings with the others, by retrainings on subsets of the photos.
//
// Their outcomes U(S), means over the ends of the last epochs, are fitted by U(S) = c + g log s + sum over photos of
// b_i (x_i / s - 1), where s is the share of photos in S and x_i is 1 in S, otherwise 0: at equal steps the members
// share the training. Worth is the fit's difference at all photos. b minimises sum of (U - fit)^2 + lambda |b - B f|^2
// + rho lambda |B - B0|^2, where f has the standardised scores lasting_psnr, dv_psnr, lasting_loss, dv_loss and quality
// that every photo has, and B0 is lasting_psnr in dB, unscaled (value/evaluation/worth_regression.h).
#ifndef VIEWWORTH_VALUE_WORTH_H
#define VIEWWORTH_VALUE_WORTH_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/worth_regression.h"
#include "viewworth/ledger.h"

extern const char vw_worth_method[]; // "worth_psnr"

// The plan of retrainings by their number, which no provider's name changes: every VW_WORTH_REPEAT_EVERY-th is on all
// photos, which shows the noise and the level; the rest are on 40 to 100 % of the photos.
enum { VW_WORTH_REPEAT_EVERY = 8 };
// Returns whether retraining `number` is on all photos.
bool vw_worth_is_of_all(uint32_t number);
// Returns the place of retraining `number` among those that are not on all photos.
uint32_t vw_worth_place(uint32_t number);

// Rows of a ledger. All borrowed.
struct vw_worth_input {
    const struct vw_ledger_retraining *retrainings;
    uint32_t retraining_count;
    const struct vw_ledger_image *images; // by image_id
    uint32_t image_count;
    const struct vw_ledger_score *scores; // the other methods, of which those of vw_worth_prior_methods are the prior
    uint32_t score_count;
};

// Methods whose scores are the prior, if every train photo has one. Without retrainings only the first existing one
// is used.
enum { VW_WORTH_PRIORS = 5 };
extern const char *const vw_worth_prior_methods[VW_WORTH_PRIORS];
// Returns the first of these methods that has scores; NULL: none.
const char *vw_worth_first_prior(const struct vw_ledger_score *scores, uint32_t score_count);

// Appends the scores vw_worth_method to the array (room for one per image), in image order; none where there are too
// few retrainings with a value.
enum vw_status vw_worth_append(const struct vw_worth_input *input, struct vw_ledger_score *scores,
                               uint32_t *score_count);

// Draws the worths of all photos together VW_RESAMPLES times from what the retrainings leave open: draws[draw][image],
// NaN for images that do not train, or where there are too few retrainings.
enum vw_status vw_worth_draw(const struct vw_worth_input *input, double *draws);

// The accuracy of predictions of left-out retrainings, beyond what follows from the number of photos.
struct vw_worth_claim {
    const char *method; // borrowed; vw_worth_method is the first, then its prior's methods
    struct vw_worth_accuracy accuracy;
};
struct vw_worth_summary {
    uint32_t retraining_count, repeat_count; // in all; on all photos
    struct vw_worth_claim claims[1 + VW_WORTH_PRIORS];
    uint32_t claim_count;
    double r2;       // over all left-out outcomes, the number of photos included
    double noise_db; // standard deviation of trainings on all photos; NaN with fewer than 2
    double ceiling;  // the correlation with one outcome that this noise permits; 0: the outcomes are all noise
};
// Summarises the retrainings. `input->scores` may contain vw_worth_method or not.
enum vw_status vw_worth_summarise(const struct vw_worth_input *input, struct vw_worth_summary *summary);

#endif
