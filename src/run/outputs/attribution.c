#include "run/outputs/attribution.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "report/tables.h"
#include "run/out_folder.h"
#include "run/scoring.h"
#include "scene/duplicates.h"
#include "viewworth/log.h"

static bool has_providers(const struct vw_scene *scene) {
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && scene->views[i].provider[0]) return true;
    return false;
}

enum vw_status vw_attribution_read_payout(const struct vw_payout_options *payout, const struct vw_config *config,
                                          struct vw_payout_request *request) {
    *request = (struct vw_payout_request){.floor_equal = payout->floor_equal, .anyway = payout->anyway};
    if (!payout->amount) return VW_OK;
    if (!vw_payout_parse(payout->amount, &request->cents))
        return vw_fail(VW_ERROR_USAGE, "--payout takes an amount of 0.01 to %.0f, such as 1000 or 99.50, not \"%s\"",
                       (double)VW_PAYOUT_CENTS_MAX / 100, payout->amount);
    enum vw_status status = config ? vw_check_scored_epochs(config->epochs, config->burn_in_epochs) : VW_OK;
    return status ? vw_fail_context(status, "--payout") : VW_OK;
}

enum vw_payout_outcome vw_payout_decide(const char *method, const struct vw_payouts *payouts,
                                        const struct vw_payout_request *request) {
    if (strcmp(method, vw_worth_method) != 0 && !request->anyway) return VW_PAYOUT_UNKNOWN_WORTH;
    if (!payouts->told_apart && !request->anyway) return VW_PAYOUT_NOT_TOLD_APART;
    if (payouts->none_positive && !request->floor_equal) return VW_PAYOUT_NONE_POSITIVE;
    return VW_PAYOUT_PAID;
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
    if (status || !attribution->group_count) return status;
    struct vw_csv_text table = {0};
    const struct vw_rows rows = vw_provider_rows(attribution->groups, attribution->group_count);
    status = vw_rows_make_csv(attribution->providers_path, &rows, &table);
    return vw_result_write_table(status, attribution->out, "providers.csv", &table, attribution->made);
}

// Advises how many retrainings to begin with: two for each photo, and 24 at least.
static uint32_t advise(const struct vw_attribution *attribution, uint32_t image_count) {
    enum { LEAST = 24, PER_PHOTO = 2 };
    uint32_t photos = 0;
    for (uint32_t i = 0; i < image_count; i++) photos += strcmp(attribution->images[i].split, "train") == 0;
    uint32_t wanted = (PER_PHOTO * photos + VW_WORTH_REPEAT_EVERY - 1) / VW_WORTH_REPEAT_EVERY * VW_WORTH_REPEAT_EVERY;
    return wanted < LEAST ? LEAST : wanted;
}

static enum vw_status write_payouts(struct vw_attribution *attribution) {
    struct vw_csv_text table = {0}, of_photos = {0};
    const struct vw_rows rows = vw_payout_rows(&attribution->payouts),
                         photos = vw_photo_payout_rows(&attribution->payouts);
    enum vw_status status = vw_rows_make_csv(attribution->payout_path, &rows, &table);
    status = vw_result_write_table(status, attribution->out, "payout.csv", &table, attribution->made);
    if (status) return status;
    status = vw_rows_make_csv(attribution->payout_photos_path, &photos, &of_photos);
    return vw_result_write_table(status, attribution->out, "payout_photos.csv", &of_photos, attribution->made);
}

// Records what was asked for, where that is not what an earlier command was asked for. The list of checksums goes
// first: it has the chain head.
static enum vw_status record_request(struct vw_ledger *ledger, const struct vw_attribution *attribution) {
    const struct vw_payout_request *asked = &attribution->request;
    struct vw_payout_request recorded;
    enum vw_status status = vw_ledger_get_payout_request(ledger, &recorded);
    if (status || (asked->cents == recorded.cents &&
                   (!asked->cents || (asked->floor_equal == recorded.floor_equal && asked->anyway == recorded.anyway))))
        return status;
    status = vw_checksums_remove(attribution->out);
    return status ? status : vw_ledger_set_payout_request(ledger, asked);
}

// Pays, if that is asked for. A payout of an earlier command is gone: OUT has what this one was asked for.
static enum vw_status make_payout(const struct vw_scoring *scoring, struct vw_attribution *attribution) {
    if (!attribution->request.cents) return VW_OK;
    if (attribution->group_count == 0)
        return vw_fail(VW_ERROR_INPUT, "--payout: no photo has a score to pay by; take more --epochs");
    struct vw_payout_input input = {.of = vw_scoring_worth_input(scoring),
                                    .method = attribution->method,
                                    .amount_cents = attribution->request.cents,
                                    .floor_equal = attribution->request.floor_equal};
    input.of.images = attribution->images;
    enum vw_status status = vw_payouts_make(&input, &attribution->payouts);
    if (status) return status;
    attribution->outcome = vw_payout_decide(attribution->method, &attribution->payouts, &attribution->request);
    attribution->advised_retrainings = attribution->outcome == VW_PAYOUT_UNKNOWN_WORTH
                                           ? advise(attribution, input.of.image_count)
                                           : attribution->payouts.enough_retrainings;
    return attribution->outcome == VW_PAYOUT_PAID ? write_payouts(attribution) : VW_OK;
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
    if (status || !attribution->duplicate_count) return status;
    struct vw_csv_text table = {0};
    const struct vw_rows rows = vw_duplicate_rows(attribution->duplicates, attribution->duplicate_count);
    status = vw_rows_make_csv(attribution->duplicates_path, &rows, &table);
    return vw_result_write_table(status, attribution->out, "duplicates.csv", &table, attribution->made);
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

enum vw_status vw_attribution_make(const struct vw_scene *scene, struct vw_ledger *ledger,
                                   const struct vw_scoring *scoring, const char *out,
                                   const struct vw_payout_request *request, struct vw_checksums *made,
                                   struct vw_attribution *attribution) {
    *attribution = (struct vw_attribution){.out = out,
                                           .made = made,
                                           .method = vw_scoring_payout_method(scoring->scores, scoring->score_count),
                                           .request = *request};
    enum vw_status status = name_outputs(out, attribution);
    if (!status) status = take_providers(scene, scoring, attribution);
    if (!status) status = record_request(ledger, attribution);
    if (!status) status = make_groups(scene, scoring, attribution);
    if (!status) status = make_payout(scoring, attribution);
    if (!status) status = make_duplicates(scene, scoring, attribution);
    if (!status) warn(attribution);
    return status;
}

void vw_attribution_free(struct vw_attribution *attribution) {
    free(attribution->images);
    free(attribution->groups);
    vw_payouts_free(&attribution->payouts);
    free(attribution->duplicates);
    free(attribution->providers_path);
    free(attribution->payout_path);
    free(attribution->payout_photos_path);
    free(attribution->duplicates_path);
    *attribution = (struct vw_attribution){0};
}
