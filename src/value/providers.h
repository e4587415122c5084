// The scores of each provider's photos together, and how an amount of money is divided among providers. From score rows
// alone.
#ifndef VIEWWORTH_VALUE_PROVIDERS_H
#define VIEWWORTH_VALUE_PROVIDERS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_provider_score {
    const char *provider;      // borrowed from the images; "": all photos without a provider
    const char *method, *unit; // borrowed from the scores
    double value;              // sum of the photos' scores
    double standard_error;     // root of the sum of squares of the photos' standard errors; NaN if a photo has none
    uint32_t photo_count;
};

// Compares two of one method for qsort: the most valuable first, ties by name.
int vw_provider_score_compare(const void *left, const void *right);

// Sums scores into one row per method and provider: methods in the order of the scores, the most valuable provider
// first, ties by name. Methods whose scores do not add up over photos, such as quality, are left out
// (vw_value_method.additive).
// `*groups` is owned by the caller (free).
//
// The standard error assumes that the photos' errors are independent, because that is what score rows allow. Photos of
// one run are not quite independent: one may gain what another has prepared. In four runs of 22 photos and 29 epochs,
// for random groups of 6, it was 0.81 to 1.04 times (medians) the error from the group's own sums per epoch.
enum vw_status vw_providers_score(const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_provider_score **groups, uint32_t *group_count);

struct vw_payout {
    const struct vw_provider_score *group; // borrowed
    double share;                          // share of the amount, before rounding to cents
    uint64_t cents;
};

#define VW_PAYOUT_CENTS_MAX ((uint64_t)1000000000000000) // 10^13 of the currency

// Reads an amount such as "1000", "1000.5" or "999.99" in cents, 1 to VW_PAYOUT_CENTS_MAX; false for any other text.
bool vw_payout_parse(const char *text, uint64_t *cents);

// Divides the amount among the named providers of `method`, in the order of their groups. Photos without a provider get
// no share. A provider whose sum is not positive gets nothing; the others share in proportion to their sums. If no sum
// is positive, the scores do not divide the amount: all share equally, and `*none_positive` is set. The cents add up to
// the amount exactly: each provider gets the whole cents of its share, and the remaining cents go to the largest
// fractions, ties by name. `*payouts` is owned by the caller (free) and borrows from `groups`. VW_ERROR_INPUT if the
// method has no named provider.
enum vw_status vw_payout_divide(const struct vw_provider_score *groups, uint32_t group_count, const char *method,
                                uint64_t amount_cents, struct vw_payout **payouts, uint32_t *payout_count,
                                bool *none_positive);

// A photo's part of what its provider is paid.
struct vw_photo_payout {
    const struct vw_payout *payout;      // its provider's; borrowed
    const struct vw_ledger_image *image; // borrowed
    const struct vw_ledger_score *score; // score by vw_payout_split_method; borrowed
    double share;                        // share of its provider's amount, before rounding to cents
    uint64_t cents;
};

extern const char vw_payout_split_method[]; // "lasting_psnr"

struct vw_payout_scores { // borrowed
    const struct vw_ledger_score *scores;
    uint32_t score_count;
    const struct vw_ledger_image *images; // with their providers
    uint32_t image_count;
};

// Splits every payout among the provider's photos by lasting credit: each photo's share is in proportion to its credit
// above that of the scene's lowest photo, whoever supplied that one, since only differences of lasting credit mean
// something. So photos of equal credit get the same, and no photo loses by the company of its provider's others. A
// photo that harms, whose worth has its whole interval below 0, gets nothing. Where no photo of a provider is above the
// lowest, all of its photos share equally. The cents of a provider's photos add up to the provider's exactly: whole
// cents of the shares first, the remaining cents to the largest fractions, ties by name. Photos come provider by
// provider, in the order of the payouts. 0 photos: the scores lack lasting credit. `*photos` is owned by the caller
// (free). VW_ERROR_MEMORY.
enum vw_status vw_payout_split(const struct vw_payout *payouts, uint32_t payout_count,
                               const struct vw_payout_scores *scores, struct vw_photo_payout **photos,
                               uint32_t *photo_count);

#endif
