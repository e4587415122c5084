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

// Makes the plan. Few providers have few subsets, which are repeated with other seeds.
enum vw_status vw_worth_plan_make(const struct vw_worth_plan_params *params, struct vw_worth_plan *plan) {
    uint32_t needed[3] = {0}, place;
    *plan = (struct vw_worth_plan){.params = *params};
    if (params->photo_count < 2) return vw_fail(VW_ERROR_INPUT, "worth needs at least 2 photos to train on");
    list_providers(plan);
    for (uint32_t i = 0; i < params->count; i++) needed[vw_worth_kind_of(i, plan->provider_count, &place)]++;
    enum vw_status status = draw(params->photo_count, needed[VW_WORTH_PHOTOS], params->key, &plan->of_photos);
    if (!status && needed[VW_WORTH_PROVIDERS])
        status = draw(plan->provider_count, needed[VW_WORTH_PROVIDERS], params->key, &plan->of_providers);
    if (!status && plan->of_photos.count < needed[VW_WORTH_PHOTOS])
        status = vw_fail(VW_ERROR_INPUT,
                         "--retrainings %" PRIu32 ": %" PRIu32 " photos have only %" PRIu32
                         " subsets of 40 to 100 %%; ask for fewer retrainings",
                         params->count, params->photo_count, plan->of_photos.count);
    return status;
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

static void list_photos(const struct vw_worth_plan *plan, uint32_t number, uint32_t *ids,
                        struct vw_ledger_retraining *retraining) {
    const struct vw_worth_plan_params *params = &plan->params;
    uint32_t place, count = 0;
    enum vw_worth_kind kind = vw_worth_kind_of(number, plan->provider_count, &place);
    if (kind == VW_WORTH_PROVIDERS) place %= plan->of_providers.count;
    for (uint32_t i = 0; i < params->photo_count; i++)
        if (kind == VW_WORTH_ALL || (kind == VW_WORTH_PHOTOS && has_player(&plan->of_photos, place, i)) ||
            (kind == VW_WORTH_PROVIDERS && has_player(&plan->of_providers, place, find_provider(plan, i))))
            ids[count++] = params->photos[i];
    *retraining = (struct vw_ledger_retraining){.whole_providers = kind == VW_WORTH_PROVIDERS,
                                                .seed = params->first_seed + number,
                                                .epochs = params->epochs,
                                                .image_ids = ids,
                                                .image_count = count,
                                                .val_psnr = NAN};
}

enum vw_status vw_worth_plan_list(const struct vw_worth_plan *plan, uint32_t count,
                                  struct vw_ledger_retraining **retrainings) {
    size_t photos = plan->params.photo_count;
    struct vw_ledger_retraining *made = vw_allocate(count, sizeof *made + photos * sizeof(uint32_t));
    if (!made) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(made + count);
    for (uint32_t i = 0; i < count; i++) list_photos(plan, i, ids + i * photos, &made[i]);
    *retrainings = made;
    return VW_OK;
}

enum vw_status vw_worth_plan_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                   vw_retrain_function *retrain, void *context) {
    struct vw_retrain_params *trained = vw_allocate(count - first, sizeof *trained);
    struct vw_retrain_result *results = vw_allocate(count - first, sizeof *results);
    enum vw_status status = trained && results ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = first; !status && i < count; i++)
        trained[i - first] = (struct vw_retrain_params){
            .views = retrainings[i].image_ids, .view_count = retrainings[i].image_count, .seed = retrainings[i].seed};
    if (!status) status = retrain(context, trained, count - first, results);
    for (uint32_t i = first; !status && i < count; i++)
        retrainings[i].val_psnr = isfinite(results[i - first].val_psnr) ? results[i - first].val_psnr : NAN;
    free(trained);
    free(results);
    return status;
}
