#include "run/outputs/attribution.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "report/tables.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/scoring.h"
#include "scene/duplicates.h"
#include "viewworth/log.h"

static bool has_providers(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && scene->views[i].provider[0]) return true;
    return false;
}

enum vw_status vw_attribution_read_payout(const char *amount, const struct vw_config *config, uint64_t *cents) {
    *cents = 0;
    if (!amount) return VW_OK;
    if (!vw_payout_parse(amount, cents))
        return vw_fail(VW_ERROR_USAGE, "--payout takes an amount of 0.01 to %.0f, such as 1000 or 99.50, not \"%s\"",
                       (double)VW_PAYOUT_CENTS_MAX / 100, amount);
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

static bool has_provided_images(const struct vw_attribution *attribution, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_ledger_image *image = &attribution->images[i];
        if (image->provider && *image->provider && !strcmp(image->split, vw_split_name(VW_SPLIT_TRAIN))) return true;
    }
    return false;
}

enum vw_status vw_attribution_of_providers(const struct vw_scoring *scoring, uint64_t payout_cents,
                                           struct vw_attribution *attribution) {
    struct vw_worth_input worth = vw_scoring_worth_input(scoring);
    worth.images = attribution->images;
    if (!has_provided_images(attribution, worth.image_count)) return VW_OK;
    enum vw_status status = vw_providers_score(worth.scores, worth.score_count, worth.images, worth.image_count,
                                               &attribution->groups, &attribution->group_count);
    return status || !payout_cents ? status : vw_payouts_make(&worth, payout_cents, &attribution->payouts);
}

// Records what was asked for, where that is not what an earlier command was asked for. The list of checksums goes
// first: it has the chain head.
static enum vw_status record_request(struct vw_ledger *ledger, const char *out, uint64_t cents) {
    struct vw_payout_request recorded;
    enum vw_status status = vw_ledger_get_payout_request(ledger, &recorded);
    if (status || cents == recorded.cents) return status;
    status = vw_file_remove(out, VW_CHECKSUMS_FILE);
    return status ? status : vw_ledger_set_payout_request(ledger, &(struct vw_payout_request){.cents = cents});
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
            "%u group%s of near-duplicates with several providers (first: %s); each copy earns credit, so pay for one "
            "photo of each group",
            shared_count, vw_plural(shared_count), shared->image->name);
    if (leaked)
        vw_log_warning("%u group%s of near-duplicates with both training and validation photos (first: %s), which "
                       "inflates their scores; exclude one side",
                       leaked_count, vw_plural(leaked_count), leaked->image->name);
}

// ---- Tables --------------------------------------------------------------------------------------------------------

const char *const vw_attribution_names[VW_ATTRIBUTION_TABLES] = {[VW_TABLE_PROVIDERS] = "providers.csv",
                                                                 [VW_TABLE_PAYOUT] = "payout.csv",
                                                                 [VW_TABLE_PAYOUT_PHOTOS] = "payout_photos.csv",
                                                                 [VW_TABLE_DUPLICATES] = "duplicates.csv"};

struct vw_rows vw_attribution_rows(const struct vw_attribution *attribution, enum vw_attribution_table table) {
    bool paid = attribution->payouts.outcome == VW_PAYOUT_PAID;
    if (table == VW_TABLE_PROVIDERS) return vw_provider_rows(attribution->groups, attribution->group_count);
    if (table == VW_TABLE_DUPLICATES) return vw_duplicate_rows(attribution->duplicates, attribution->duplicate_count);
    if (!paid) return (struct vw_rows){0};
    return table == VW_TABLE_PAYOUT ? vw_payout_rows(&attribution->payouts)
                                    : vw_photo_payout_rows(&attribution->payouts);
}

static enum vw_status write_tables(const struct vw_attribution *attribution) {
    enum vw_status status = VW_OK;
    for (int i = 0; i < VW_ATTRIBUTION_TABLES && !status; i++) {
        const struct vw_rows rows = vw_attribution_rows(attribution, i);
        struct vw_csv_text table = {0};
        if (!rows.count) continue;
        status = vw_rows_make_csv(vw_attribution_names[i], &rows, &table);
        status = vw_result_write_table(status, attribution->out, vw_attribution_names[i], &table);
    }
    return status;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

enum vw_status vw_attribution_make(const struct vw_scene *scene, struct vw_ledger *ledger,
                                   const struct vw_scoring *scoring, const char *out, uint64_t payout_cents,
                                   struct vw_attribution *attribution) {
    *attribution =
        (struct vw_attribution){.out = out, .method = vw_scoring_payout_method(scoring->scores, scoring->score_count)};
    enum vw_status status = take_providers(scene, scoring, attribution);
    if (!status) status = record_request(ledger, out, payout_cents);
    if (!status) status = vw_attribution_of_providers(scoring, payout_cents, attribution);
    if (!status) status = make_duplicates(scene, scoring, attribution);
    if (!status) status = write_tables(attribution);
    if (!status) warn(attribution);
    return status;
}

void vw_attribution_free(struct vw_attribution *attribution) {
    free(attribution->images);
    free(attribution->groups);
    vw_payouts_free(&attribution->payouts);
    free(attribution->duplicates);
    *attribution = (struct vw_attribution){0};
}
