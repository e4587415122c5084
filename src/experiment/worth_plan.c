#include "experiment/worth_plan.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// ---- Subsets -------------------------------------------------------------------------------------------------------

static const char *provider_of(const struct vw_worth_plan *plan, uint32_t photo) {
    return plan->params.providers && plan->params.providers[photo] ? plan->params.providers[photo] : "";
}

static uint32_t find_provider(const struct vw_worth_plan *plan, uint32_t photo) {
    uint32_t place = 0;
    while (place < plan->provider_count && strcmp(plan->providers[place], provider_of(plan, photo)) != 0) place++;
    return place;
}

static void list_providers(struct vw_worth_plan *plan) {
    for (uint32_t i = 0; i < plan->params.photo_count && plan->provider_count <= VW_WORTH_PROVIDERS_MAX; i++)
        if (find_provider(plan, i) == plan->provider_count)
            plan->providers[plan->provider_count++] = provider_of(plan, i);
}

// Leaves out the subset of all: the retrainings on all photos are others.
static void drop_all(struct vw_subsets *subsets) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < subsets->count; i++) {
        uint32_t size = vw_subset_size(subsets, i);
        if (size == subsets->photo_count) continue;
        memmove(subsets->places + subsets->offsets[kept], subsets->places + subsets->offsets[i],
                size * sizeof *subsets->places);
        subsets->offsets[kept + 1] = subsets->offsets[kept] + size;
        kept++;
    }
    subsets->count = kept;
}

static enum vw_status draw(uint32_t players, uint32_t needed, uint64_t key, struct vw_subsets *subsets) {
    const struct vw_subsets_params params = {
        .photo_count = players, .random_sizes = needed + 1, .seed_count = 1, .key = key};
    enum vw_status status = vw_subsets_draw(&params, subsets);
    if (!status) drop_all(subsets);
    return status;
}

static enum vw_status draw_photos(struct vw_worth_plan *plan) {
    const struct vw_worth_plan_params *params = &plan->params;
    uint32_t needed = params->count - (params->count + VW_WORTH_REPEAT_EVERY - 1) / VW_WORTH_REPEAT_EVERY;
    enum vw_status status = draw(params->photo_count, needed, params->key, &plan->of_photos);
    if (!status && plan->of_photos.count < needed)
        status = vw_fail(VW_ERROR_INPUT,
                         "--retrainings %" PRIu32 ": %" PRIu32 " photos have only %" PRIu32
                         " subsets of 40 to 100 %%; ask for fewer retrainings",
                         params->count, params->photo_count, plan->of_photos.count);
    return status;
}

// Draws subsets of providers. Few providers have few subsets, which are repeated with other seeds.
static enum vw_status draw_providers(struct vw_worth_plan *plan) {
    const struct vw_worth_plan_params *params = &plan->params;
    if (!params->provider_retrainings) return VW_OK;
    if (plan->provider_count < 2 || plan->provider_count > VW_WORTH_PROVIDERS_MAX)
        return vw_fail(VW_ERROR_USAGE,
                       "--provider-retrainings needs 2 to %d providers, and the run has %s; leave it out, or value the "
                       "scene with other --providers",
                       VW_WORTH_PROVIDERS_MAX, plan->provider_count < 2 ? "fewer" : "more");
    return draw(plan->provider_count, params->provider_retrainings, params->key, &plan->of_providers);
}

enum vw_status vw_worth_plan_make(const struct vw_worth_plan_params *params, struct vw_worth_plan *plan) {
    *plan = (struct vw_worth_plan){.params = *params};
    if (params->photo_count < 2) return vw_fail(VW_ERROR_INPUT, "worth needs at least 2 photos to train on");
    list_providers(plan);
    enum vw_status status = draw_photos(plan);
    return status ? status : draw_providers(plan);
}

void vw_worth_plan_free(struct vw_worth_plan *plan) {
    vw_subsets_free(&plan->of_photos);
    vw_subsets_free(&plan->of_providers);
}

// ---- Retrainings ---------------------------------------------------------------------------------------------------

static bool has_player(const struct vw_subsets *subsets, uint32_t subset, uint32_t player) {
    for (uint32_t i = subsets->offsets[subset]; i < subsets->offsets[subset + 1]; i++)
        if (subsets->places[i] == player) return true;
    return false;
}

static const uint64_t PROVIDER_SEEDS = (uint64_t)1 << 31; // apart from those of the others

static bool is_in(const struct vw_worth_plan *plan, bool whole_providers, uint32_t number, uint32_t photo) {
    if (whole_providers)
        return has_player(&plan->of_providers, number % plan->of_providers.count, find_provider(plan, photo));
    return vw_worth_is_of_all(number) || has_player(&plan->of_photos, vw_worth_place(number), photo);
}

// Lists retraining `number` of its kind.
static void list_photos(const struct vw_worth_plan *plan, bool whole_providers, uint32_t number, uint32_t *ids,
                        struct vw_ledger_retraining *retraining) {
    const struct vw_worth_plan_params *params = &plan->params;
    uint32_t count = 0;
    for (uint32_t i = 0; i < params->photo_count; i++)
        if (is_in(plan, whole_providers, number, i)) ids[count++] = params->photos[i];
    *retraining =
        (struct vw_ledger_retraining){.whole_providers = whole_providers,
                                      .seed = params->first_seed + number + (whole_providers ? PROVIDER_SEEDS : 0),
                                      .epochs = params->epochs,
                                      .image_ids = ids,
                                      .image_count = count,
                                      .val_psnr = NAN};
}

enum vw_status vw_worth_plan_list(const struct vw_worth_plan *plan, const struct vw_worth_plan_progress *progress,
                                  struct vw_ledger_retraining **retrainings) {
    size_t photos = plan->params.photo_count;
    uint32_t next[2] = {0}, count = progress->photo_retrainings + progress->provider_retrainings;
    struct vw_ledger_retraining *made = vw_allocate(count, sizeof *made + photos * sizeof(uint32_t));
    if (!made) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(made + count);
    for (uint32_t i = 0; i < count; i++) {
        bool whole = i < progress->recorded_count ? progress->recorded[i].whole_providers
                                                  : next[false] >= progress->photo_retrainings;
        list_photos(plan, whole, next[whole]++, ids + i * photos, &made[i]);
    }
    *retrainings = made;
    return VW_OK;
}

void vw_worth_plan_describe(const struct vw_ledger_retraining *retrainings, uint32_t count,
                            struct vw_retrain_params *trained) {
    for (uint32_t i = 0; i < count; i++)
        trained[i] = (struct vw_retrain_params){
            .views = retrainings[i].image_ids, .view_count = retrainings[i].image_count, .seed = retrainings[i].seed};
}

enum vw_status vw_worth_plan_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                   vw_retrain_function *retrain, void *context) {
    struct vw_retrain_params *trained = vw_allocate(count - first, sizeof *trained);
    struct vw_retrain_result *results = vw_allocate(count - first, sizeof *results);
    enum vw_status status = trained && results ? VW_OK : VW_ERROR_MEMORY;
    if (!status) vw_worth_plan_describe(retrainings + first, count - first, trained);
    if (!status) status = retrain(context, trained, count - first, results);
    for (uint32_t i = first; !status && i < count; i++)
        retrainings[i].val_psnr = isfinite(results[i - first].val_psnr) ? results[i - first].val_psnr : NAN;
    free(trained);
    free(results);
    return status;
}
