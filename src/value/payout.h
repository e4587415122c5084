// The division of an amount of money: each photo is paid in proportion to its worth where that is positive, and a
// provider gets the sum over its photos. No provider's name enters a share, so that splitting and joining names changes
// nothing.
#ifndef VIEWWORTH_VALUE_PAYOUT_H
#define VIEWWORTH_VALUE_PAYOUT_H

#include <stdbool.h>
#include <stdint.h>

#include "value/worth.h"

#define VW_PAYOUT_CENTS_MAX ((uint64_t)1000000000000000) // 10^13 of the currency

// Reads an amount such as "1000", "1000.5" or "999.99" in cents, 1 to VW_PAYOUT_CENTS_MAX; false for any other text.
bool vw_payout_parse(const char *text, uint64_t *cents);

// The middle 90 % of payouts, in cents, when worths are redrawn within what other retrainings, with other subsets and
// seeds, and photos of which they say little leave open. Contains the payout itself.
struct vw_payout_interval {
    double low_cents, high_cents;
};

struct vw_photo_payout {
    const struct vw_ledger_image *image; // borrowed
    const struct vw_ledger_score *score; // its worth; borrowed
    double share;                        // share of the amount, before rounding to cents
    uint64_t cents;
    struct vw_payout_interval interval;
};

struct vw_payout {
    const char *provider;    // borrowed from the images
    double value;            // sum of the photos' positive worths
    double share;            // sum of the photos' shares
    uint64_t cents;          // sum of the photos' cents
    uint32_t photo_count;    // photos that have a worth
    uint32_t first_photo;    // index of the first of them
    uint32_t unvalued_count; // photos without one: they validate or are kept for tests
    struct vw_payout_interval interval;
};

enum vw_payout_outcome {
    VW_PAYOUT_NOT_ASKED,
    VW_PAYOUT_PAID,
    VW_PAYOUT_UNKNOWN_WORTH, // no retrainings, or too few
    VW_PAYOUT_NOT_TOLD_APART,
    VW_PAYOUT_NONE_POSITIVE,
};

struct vw_payouts {
    enum vw_payout_outcome outcome;
    uint64_t amount_cents;
    struct vw_payout *providers; // owned; the best paid first, ties by name; empty where worth is unknown
    uint32_t provider_count;
    struct vw_photo_payout *photos; // owned; provider by provider in the order of their names, each by image_id
    uint32_t photo_count;
    uint32_t retraining_count;
};

// Divides the amount by the worths of a ledger, and decides whether it is paid: not where the intervals of no two
// photos are apart, whoever their providers are. Photos without a provider get no share and take none. The cents add up
// to the amount exactly: each photo gets the whole cents of its share, and the remaining cents go to the largest
// fractions, ties by the photos' names. VW_ERROR_INPUT when no photo that has a worth has a provider. Free it also
// after a failure.
enum vw_status vw_payouts_make(const struct vw_worth_input *input, uint64_t amount_cents, struct vw_payouts *payouts);
// Divides the amount of payouts that have no more yet, by drawn worths as vw_worth_draw() makes them, which it
// overwrites.
enum vw_status vw_payouts_divide(const struct vw_worth_input *input, double *draws, struct vw_payouts *payouts);
void vw_payouts_free(struct vw_payouts *payouts);

#endif
