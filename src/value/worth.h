// Worth: what a photo adds to trainings with the others, by retrainings on subsets of the photos. The formula is in
// viewworth/value.h; the regression in value/evaluation/worth_regression.h.
#ifndef VIEWWORTH_VALUE_WORTH_H
#define VIEWWORTH_VALUE_WORTH_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/worth_regression.h"
#include "value/providers.h"
#include "viewworth/ledger.h"

extern const char vw_worth_method[]; // "worth_psnr"

// The plan of retrainings by their number: every VW_WORTH_REPEAT_EVERY-th is on all photos, which shows the noise and
// the level. With 2 to VW_WORTH_PROVIDERS_MAX providers, every second of the others has whole providers, until there
// are VW_WORTH_PER_PROVIDER for each provider. The rest are on 40 to 100 % of the photos.
enum { VW_WORTH_REPEAT_EVERY = 8, VW_WORTH_PROVIDERS_MAX = 12, VW_WORTH_PER_PROVIDER = 4 };
enum vw_worth_kind { VW_WORTH_ALL, VW_WORTH_PROVIDERS, VW_WORTH_PHOTOS };
// Returns the kind of retraining `number`, and its place among those of that kind. 0 or 1 providers: no retraining
// leaves one out.
enum vw_worth_kind vw_worth_kind_of(uint32_t number, uint32_t provider_count, uint32_t *place);

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

// Replaces the sums of vw_worth_method by the worth of providers as players, where there are enough retrainings on
// whole providers; images have their providers. `*replaced` tells whether. Groups of the method are put in order again.
enum vw_status vw_worth_of_groups(const struct vw_worth_input *input, struct vw_provider_score *groups,
                                  uint32_t group_count, bool *replaced);

// The accuracy of predictions of left-out retrainings, beyond what follows from the number of photos.
struct vw_worth_claim {
    const char *method; // borrowed; vw_worth_method is the first, then its prior's methods
    struct vw_worth_accuracy accuracy;
};
struct vw_worth_summary {
    uint32_t retraining_count, repeat_count, provider_retraining_count; // in all; on all photos; of whole providers
    struct vw_worth_claim claims[1 + VW_WORTH_PRIORS];
    uint32_t claim_count;
    double r2;       // over all left-out outcomes, the number of photos included
    double noise_db; // standard deviation of trainings on all photos; NaN with fewer than 2
    double ceiling;  // the correlation with one outcome that this noise permits; 0: the outcomes are all noise
};
// Summarises the retrainings. `input->scores` may contain vw_worth_method or not.
enum vw_status vw_worth_summarise(const struct vw_worth_input *input, struct vw_worth_summary *summary);

#endif
