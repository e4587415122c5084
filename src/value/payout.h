// The division of an amount of money: each photo is paid by its own score, and a provider gets the sum over its photos.
// Uses only ledger rows. No provider's name enters a share, so that splitting and joining names changes nothing.
#ifndef VIEWWORTH_VALUE_PAYOUT_H
#define VIEWWORTH_VALUE_PAYOUT_H

#include <stdbool.h>
#include <stdint.h>

#include "value/worth.h"

#define VW_PAYOUT_CENTS_MAX ((uint64_t)1000000000000000) // 10^13 of the currency

// Reads an amount such as "1000", "1000.5" or "999.99" in cents, 1 to VW_PAYOUT_CENTS_MAX; false for any other text.
bool vw_payout_parse(const char *text, uint64_t *cents);

// The middle 90 % of payouts, in cents, when scores are redrawn within their uncertainty. Contains the payout itself.
// The uncertainty of worth is that of other retrainings, with other subsets and seeds, and of photos of which they say
// little; that of another method is its standard errors. NaN: a score has no error.
struct vw_payout_interval {
    double low_cents, high_cents;
};

// A photo's payout.
struct vw_photo_payout {
    const struct vw_ledger_image *image; // borrowed
    const struct vw_ledger_score *score; // by which it is paid; borrowed
    double share;                        // share of the amount, before rounding to cents
    uint64_t cents;
    struct vw_payout_interval interval;
};

// A provider's payout.
struct vw_payout {
    const char *provider;                                  // borrowed from the images
    const char *method, *unit;                             // method and unit of the scores that pay
    double value;                                          // sum of the photos' positive scores
    double share;                                          // sum of the photos' shares
    uint64_t cents;                                        // sum of the photos' cents
    uint32_t photo_count;                                  // photos that have a score
    uint32_t first_photo;                                  // index of the first of them
    uint32_t validating_count, test_count, unscored_count; // photos without one: by split; of the train split
    struct vw_payout_interval interval;
    uint32_t alike_count; // other providers with a score whose intervals overlap: they are not told apart
};

struct vw_payout_input {
    struct vw_worth_input of; // retrainings, images with their providers, scores of all methods
    const char *method;       // pays: vw_worth_method, or a method with standard errors
    uint64_t amount_cents;    // at least 1
    bool floor_equal;         // where no photo's score is positive, all get the same; otherwise no one gets anything
};

struct vw_payouts {
    struct vw_payout *providers; // owned; the best paid first, ties by name
    uint32_t provider_count;
    struct vw_photo_payout *photos; // owned; provider by provider, each by image_id
    uint32_t photo_count;
    bool none_positive;
    bool told_apart;             // some two photos are, by their intervals, whoever their providers are
    uint32_t retraining_count;   // on photos
    uint32_t enough_retrainings; // estimate of how many would tell two apart, more than were made; 0: no number that
                                 // can be made, or that is at most 100,000
};

// Divides the amount. A photo's share is in proportion to its score where that is positive, else 0. Photos without a
// provider get no share and take none. The cents add up to the amount exactly: each photo gets the whole cents of its
// share, and the remaining cents go to the largest fractions, ties by the photos' names. VW_ERROR_INPUT when no photo
// with a score has a provider. Free it also after a failure.
enum vw_status vw_payouts_make(const struct vw_payout_input *input, struct vw_payouts *payouts);
void vw_payouts_free(struct vw_payouts *payouts);

#endif
