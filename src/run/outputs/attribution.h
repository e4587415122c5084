// What providers' photos are worth together, what each is paid, and which photos are copies of others: the part of
// `value` for markets.
#ifndef VIEWWORTH_ATTRIBUTION_H
#define VIEWWORTH_ATTRIBUTION_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/scoring.h"
#include "run/training_run.h"
#include "value/duplicate_scores.h"
#include "value/providers.h"

struct vw_attribution {
    const char *method;             // that is shown and paid by
    struct vw_ledger_image *images; // owned: the ledger's, with the providers that this command gives
    struct vw_provider_score *groups;
    uint32_t group_count; // of all methods; 0 when no photo has a provider
    uint64_t amount_cents;
    struct vw_payout *payouts; // none unless asked for
    uint32_t payout_count;
    bool nobody_helped;
    struct vw_duplicate_score *duplicates;
    uint32_t duplicate_count;
    char *providers_path, *payout_path, *duplicates_path; // owned
};

// Before any step: whether --payout is an amount that there will be scores to pay by, and whether there is somebody to
// be paid. VW_ERROR_USAGE.
enum vw_status vw_attribution_check_options(const struct vw_options *options);
enum vw_status vw_attribution_check_scene(const struct vw_options *options, const struct vw_scene *scene);
// Works everything out by the scores of `method`, and writes providers.csv, payout.csv and duplicates.csv where there
// is something to write. Those that new steps make out of date vw_training_finish has removed. Warns of what is wrong.
// Free it also after a failure.
enum vw_status vw_attribution_make(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                   const char *method, struct vw_attribution *attribution);
void vw_attribution_print(const struct vw_attribution *attribution);
// Adds providers, payout and duplicates to `root`; false when memory is short.
bool vw_attribution_add_json(const struct vw_attribution *attribution, json_t *root);
void vw_attribution_free(struct vw_attribution *attribution);

#endif
