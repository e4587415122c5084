// Worth of providers' photos, payouts and near-duplicate photos.
#ifndef VIEWWORTH_RUN_OUTPUTS_ATTRIBUTION_H
#define VIEWWORTH_RUN_OUTPUTS_ATTRIBUTION_H

#include <stdbool.h>
#include <stdint.h>

#include "run/scoring.h"
#include "value/duplicate_scores.h"
#include "value/providers.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

struct vw_attribution {
    const char *method;             // that payouts and near-duplicates go by: vw_scoring_payout_method
    struct vw_ledger_image *images; // owned: the ledger's, with the providers that the scene has now
    struct vw_provider_score *groups;
    uint32_t group_count; // groups over all methods; 0 when no photo has a provider
    bool players;         // their worth is that of providers as players, not a sum over photos
    uint64_t amount_cents;
    struct vw_payout *payouts; // none unless asked for
    uint32_t payout_count;
    bool none_positive;
    struct vw_photo_payout *photos; // none without payouts or lasting credit
    uint32_t photo_count;
    struct vw_duplicate_score *duplicates;
    uint32_t duplicate_count;
    char *providers_path, *payout_path, *payout_photos_path, *duplicates_path; // owned
};

// Reads an amount. VW_ERROR_USAGE when it is none, and where the config (NULL: unknown) leaves no epoch to score.
enum vw_status vw_attribution_read_payout(const char *payout, const struct vw_config *config, uint64_t *cents);
// Returns VW_ERROR_USAGE when no photo has a provider to be paid.
enum vw_status vw_attribution_check_scene(const struct vw_scene *scene);
// Computes everything from the scores and writes providers.csv, payout.csv, payout_photos.csv and duplicates.csv to
// OUT, those that have rows. Divides no amount where payout_cents is 0. Warns of copies. Free it also after a failure.
enum vw_status vw_attribution_make(const struct vw_scene *scene, const struct vw_scoring *scoring, const char *out,
                                   uint64_t payout_cents, struct vw_attribution *attribution);
void vw_attribution_free(struct vw_attribution *attribution);

#endif
