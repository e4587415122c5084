#include "run/outputs/attribution.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "report/tables.h"
#include "run/scoring.h"
#include "scene/duplicates.h"
#include "viewworth/log.h"

static bool has_providers(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && scene->views[i].provider[0]) return true;
    return false;
}

enum vw_status vw_attribution_read_payout(const char *payout, const struct vw_config *config, uint64_t *cents) {
    if (!vw_payout_parse(payout, cents))
        return vw_fail(VW_ERROR_USAGE, "--payout takes an amount of 0.01 to %.0f, such as 1000 or 99.50, not \"%s\"",
                       (double)VW_PAYOUT_CENTS_MAX / 100, payout);
    enum vw_status status = config ? vw_check_scored_epochs(config->epochs, config->burn_in_epochs) : VW_OK;
    return status ? vw_fail_context(status, "--payout") : VW_OK;
}

enum vw_status vw_attribution_check_scene(const struct vw_scene *scene) {
    if (has_providers(scene)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--payout: no photo to train on has a provider; name them by --providers FILE.csv");
}

// Providers may be named after the run: they decide no bit of it.
static enum vw_status take_providers(const struct vw_scene *scene, const struct vw_scoring *scoring,
                                     struct vw_attribution *attribution) {
    const struct vw_value_input *input = &scoring->input;
    bool changed = false;
    attribution->images = vw_allocate(input->image_count, sizeof *attribution->images);
    if (!attribution->images) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const char *recorded = input->images[i].provider ? input->images[i].provider : "";
        attribution->images[i] = input->images[i];
        attribution->images[i].provider = scene->views[input->images[i].image_id].provider;
        changed = changed || strcmp(attribution->images[i].provider, recorded) != 0;
    }
    if (changed) vw_log_warning("providers are those given now, not those that the ledger recorded when the run began");
    return VW_OK;
}

static enum vw_status name_outputs(const char *out, struct vw_attribution *attribution) {
    attribution->providers_path = vw_path_join(out, "providers.csv");
    attribution->payout_path = vw_path_join(out, "payout.csv");
    attribution->payout_photos_path = vw_path_join(out, "payout_photos.csv");
    attribution->duplicates_path = vw_path_join(out, "duplicates.csv");
    return attribution->providers_path && attribution->payout_path && attribution->payout_photos_path &&
                   attribution->duplicates_path
               ? VW_OK
               : VW_ERROR_MEMORY;
}

static enum vw_status make_groups(const struct vw_scene *scene, const struct vw_scoring *scoring,
                                  struct vw_attribution *attribution) {
    if (!has_providers(scene)) return VW_OK;
    enum vw_status status =
        vw_providers_score(scoring->scores, scoring->score_count, attribution->images, scoring->input.image_count,
                           &attribution->groups, &attribution->group_count);
    struct vw_worth_input worth = vw_scoring_worth_input(scoring);
    worth.images = attribution->images;
    if (!status)
        status = vw_worth_of_groups(&worth, attribution->groups, attribution->group_count, &attribution->players);
    if (!status && attribution->group_count > 0)
        status = vw_table_write_providers(attribution->providers_path, attribution->groups, attribution->group_count);
    return status;
}

static enum vw_status split_payouts(const struct vw_scoring *scoring, struct vw_attribution *attribution) {
    const struct vw_payout_scores scores = {scoring->scores, scoring->score_count, attribution->images,
                                            scoring->input.image_count};
    enum vw_status status = vw_payout_split(attribution->payouts, attribution->payout_count, &scores,
                                            &attribution->photos, &attribution->photo_count);
    if (status || !attribution->photo_count) return status;
    return vw_table_write_payout_photos(attribution->payout_photos_path, attribution->photos, attribution->photo_count);
}

static enum vw_status make_payout(const struct vw_scoring *scoring, struct vw_attribution *attribution) {
    if (!attribution->amount_cents) return VW_OK;
    if (attribution->group_count == 0)
        return vw_fail(VW_ERROR_INPUT, "--payout: no photo has a score to pay by; take more --epochs");
    enum vw_status status =
        vw_payout_divide(attribution->groups, attribution->group_count, attribution->method, attribution->amount_cents,
                         &attribution->payouts, &attribution->payout_count, &attribution->none_positive);
    if (!status)
        status = vw_table_write_payout(attribution->payout_path, attribution->payouts, attribution->payout_count);
    return status ? status : split_payouts(scoring, attribution);
}

static enum vw_status make_duplicates(const struct vw_scene *scene, const struct vw_scoring *scoring,
                                      struct vw_attribution *attribution) {
    struct vw_duplicate *found = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_scene_find_duplicates(scene, &found, &count);
    if (!status)
        status = vw_duplicates_score(found, count, attribution->method, scoring->scores, scoring->score_count,
                                     attribution->images, scoring->input.image_count, &attribution->duplicates,
                                     &attribution->duplicate_count);
    if (!status && attribution->duplicate_count > 0)
        status = vw_table_write_duplicates(attribution->duplicates_path, attribution->duplicates,
                                           attribution->duplicate_count);
    free(found);
    return status;
}

// Warns in one line each, however many groups there are.
static void warn(const struct vw_attribution *attribution) {
    const struct vw_duplicate_score *rows = attribution->duplicates, *shared = NULL, *leaked = NULL;
    uint32_t shared_count = 0, leaked_count = 0;
    for (uint32_t i = attribution->duplicate_count; i-- > 0;) {
        if (i > 0 && rows[i].group == rows[i - 1].group) continue; // not the first of its group
        if (rows[i].provider_count > 1) shared = &rows[i], shared_count++;
        if (rows[i].validation_count > 0) leaked = &rows[i], leaked_count++;
    }
    if (shared)
        vw_log_warning(
            "%u groups of near-duplicates belong to several providers (first: %s); each copy earns credit, so "
            "pay for one photo of each group",
            shared_count, shared->image->name);
    if (leaked)
        vw_log_warning("%u groups of near-duplicates contain both training and validation photos (first: %s), which "
                       "inflates their scores; exclude one side",
                       leaked_count, leaked->image->name);
    if (attribution->none_positive)
        vw_log_warning("--payout: no provider's sum is positive, so that all share equally");
}

enum vw_status vw_attribution_make(const struct vw_scene *scene, const struct vw_scoring *scoring, const char *out,
                                   uint64_t payout_cents, struct vw_attribution *attribution) {
    *attribution = (struct vw_attribution){.method = vw_scoring_payout_method(scoring->scores, scoring->score_count),
                                           .amount_cents = payout_cents};
    enum vw_status status = name_outputs(out, attribution);
    if (!status) status = take_providers(scene, scoring, attribution);
    if (!status) status = make_groups(scene, scoring, attribution);
    if (!status) status = make_payout(scoring, attribution);
    if (!status) status = make_duplicates(scene, scoring, attribution);
    if (!status) warn(attribution);
    return status;
}

void vw_attribution_free(struct vw_attribution *attribution) {
    free(attribution->images);
    free(attribution->groups);
    free(attribution->payouts);
    free(attribution->photos);
    free(attribution->duplicates);
    free(attribution->providers_path);
    free(attribution->payout_path);
    free(attribution->payout_photos_path);
    free(attribution->duplicates_path);
    *attribution = (struct vw_attribution){0};
}
