// What providers' photos are worth together, and how an amount of money is divided among them. From score rows alone.
#ifndef VIEWWORTH_PROVIDERS_H
#define VIEWWORTH_PROVIDERS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_provider_score {
    const char *provider;      // borrowed from the images; "" stands for all photos without one
    const char *method, *unit; // borrowed from the scores
    double value;              // sum of the photos' scores
    double standard_error; // root of the sum of the squares of the photos' standard errors; NaN when a photo has none
    uint32_t photo_count;
};

// A row per method and provider, methods in the order of the scores, the most valuable provider first, ties by name.
// Methods whose scores do not add up over photos, such as roots and rates, are left out (vw_value_method.additive).
// `*groups` is owned by the caller (free).
//
// The standard error takes the photos' errors as independent, for the score rows of every method hold what that needs.
// Photos of one run are not quite: what one gains another may have prepared or may take back. In four runs of 22 photos
// and 29 epochs it came, for random groups of 6, to 0.81 to 1.04 times (medians) the error that the group's own sums
// per epoch give. The sum of same_state_* is what one step on each of the photos brings, as a mean over the same
// states, which photos share: there, of 20 states and 12 photos, it came to 0.6 times the error that the group's own
// sums per state give, and is to be read as too small.
enum vw_status vw_providers_score(const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_provider_score **groups, uint32_t *group_count);

struct vw_payout {
    const struct vw_provider_score *group; // borrowed
    double share;                          // of the amount, before rounding to cents
    uint64_t cents;
};

#define VW_PAYOUT_CENTS_MAX ((uint64_t)1000000000000000) // 10^13 of the currency

// An amount such as "1000", "1000.5" or "999.99" in cents, 1 to VW_PAYOUT_CENTS_MAX; false for any other text.
bool vw_payout_parse(const char *text, uint64_t *cents);

// Divides the amount among the named providers of `method`, in the order of their groups; photos without a provider are
// nobody's and share in nothing. The cents add up to the amount exactly: each provider gets the whole cents of its
// share, and the cents that are left go to the largest fractions, ties by name. The rule for scores that are not
// positive: a provider whose sum is not positive gets nothing, the others share in proportion to their sums. Where no
// sum is positive the scores do not tell who helped: then all share equally, and `*nobody_helped` says so.
// `*payouts` is owned by the caller (free) and borrows from `groups`. VW_ERROR_INPUT when the method has no named
// provider.
enum vw_status vw_payout_divide(const struct vw_provider_score *groups, uint32_t group_count, const char *method,
                                uint64_t amount_cents, struct vw_payout **payouts, uint32_t *payout_count,
                                bool *nobody_helped);

#endif
