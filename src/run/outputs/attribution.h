// Sums of scores by provider, a payout, and near-duplicate photos.
#ifndef VIEWWORTH_RUN_OUTPUTS_ATTRIBUTION_H
#define VIEWWORTH_RUN_OUTPUTS_ATTRIBUTION_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rows.h"
#include "run/scoring.h"
#include "value/payout.h"
#include "value/providers.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

struct vw_attribution {
    const char *out;                // borrowed
    const char *method;             // that near-duplicates go by: vw_scoring_payout_method
    struct vw_ledger_image *images; // owned: the ledger's, with the providers of now
    struct vw_provider_score *groups;
    uint32_t group_count; // groups over all methods; 0 when no photo has a provider
    struct vw_payouts payouts;
    struct vw_duplicate_score *duplicates;
    uint32_t duplicate_count;
};

// Reads the amount that is asked for; NULL: 0. VW_ERROR_USAGE when it is not an amount, and where the config (NULL:
// unknown) leaves no epoch to score.
enum vw_status vw_attribution_read_payout(const char *amount, const struct vw_config *config, uint64_t *cents);
// Returns VW_ERROR_USAGE when no photo has a provider to be paid.
enum vw_status vw_attribution_check_scene(const struct vw_scene *scene);
// Computes everything from the scores and writes the tables below to OUT, those that have rows. Warns of copies.
// Records the amount in the ledger, opened to append, so that verify makes the payout again by that. Free it also after
// a failure.
enum vw_status vw_attribution_make(const struct vw_scene *scene, struct vw_ledger *ledger,
                                   const struct vw_scoring *scoring, const char *out, uint64_t payout_cents,
                                   struct vw_attribution *attribution);
// Sums scores by provider and divides the amount (0: none is asked for), both by the providers of attribution->images
// and unless no photo to train on has one.
enum vw_status vw_attribution_of_providers(const struct vw_scoring *scoring, uint64_t payout_cents,
                                           struct vw_attribution *attribution);

enum vw_attribution_table {
    VW_TABLE_PROVIDERS,
    VW_TABLE_PAYOUT,
    VW_TABLE_PAYOUT_PHOTOS,
    VW_TABLE_DUPLICATES,
    VW_ATTRIBUTION_TABLES
};
extern const char *const vw_attribution_names[VW_ATTRIBUTION_TABLES]; // files in OUT
// Returns the rows of such a file; none: it is not written. Payouts have rows only where somebody is paid.
struct vw_rows vw_attribution_rows(const struct vw_attribution *attribution, enum vw_attribution_table table);
void vw_attribution_free(struct vw_attribution *attribution);

#endif
