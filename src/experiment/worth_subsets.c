#include "experiment/worth_subsets.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// ---- Subsets -------------------------------------------------------------------------------------------------------

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

static enum vw_status draw(struct vw_worth_subsets *drawn) {
    const struct vw_worth_subsets_params *params = &drawn->params;
    uint32_t needed = params->count - (params->count + VW_WORTH_REPEAT_EVERY - 1) / VW_WORTH_REPEAT_EVERY;
    enum vw_status status = vw_subsets_draw(
        &(struct vw_subsets_params){
            .photo_count = params->photo_count, .random_sizes = needed + 1, .seed_count = 1, .key = params->key},
        &drawn->subsets);
    if (!status) drop_all(&drawn->subsets);
    if (!status && drawn->subsets.count < needed)
        status = vw_fail(VW_ERROR_INPUT,
                         "--retrainings %" PRIu32 ": %" PRIu32 " photos have only %" PRIu32
                         " subsets of 40 to 100 %%; ask for fewer retrainings",
                         params->count, params->photo_count, drawn->subsets.count);
    return status;
}

enum vw_status vw_worth_subsets_draw(const struct vw_worth_subsets_params *params, struct vw_worth_subsets *drawn) {
    *drawn = (struct vw_worth_subsets){.params = *params};
    if (params->photo_count < 2) return vw_fail(VW_ERROR_INPUT, "worth needs at least 2 photos to train on");
    return draw(drawn);
}

void vw_worth_subsets_free(struct vw_worth_subsets *drawn) { vw_subsets_free(&drawn->subsets); }

// ---- Retrainings ---------------------------------------------------------------------------------------------------

static bool has_player(const struct vw_subsets *subsets, uint32_t subset, uint32_t player) {
    for (uint32_t i = subsets->offsets[subset]; i < subsets->offsets[subset + 1]; i++)
        if (subsets->places[i] == player) return true;
    return false;
}

// Lists retraining `number`.
static void list_photos(const struct vw_worth_subsets *drawn, uint32_t number, uint32_t *ids,
                        struct vw_ledger_retraining *retraining) {
    const struct vw_worth_subsets_params *params = &drawn->params;
    uint32_t count = 0;
    for (uint32_t i = 0; i < params->photo_count; i++)
        if (vw_worth_is_of_all(number) || has_player(&drawn->subsets, vw_worth_place(number), i))
            ids[count++] = params->photos[i];
    *retraining = (struct vw_ledger_retraining){.seed = params->first_seed + number,
                                                .epochs = params->epochs,
                                                .image_ids = ids,
                                                .image_count = count,
                                                .val_psnr = NAN};
}

enum vw_status vw_worth_retrainings_list(const struct vw_worth_subsets *drawn, uint32_t count,
                                         struct vw_ledger_retraining **retrainings) {
    size_t photos = drawn->params.photo_count;
    struct vw_ledger_retraining *made = vw_allocate(count, sizeof *made + photos * sizeof(uint32_t));
    if (!made) return VW_ERROR_MEMORY;
    uint32_t *ids = (uint32_t *)(made + count);
    for (uint32_t i = 0; i < count; i++) list_photos(drawn, i, ids + i * photos, &made[i]);
    *retrainings = made;
    return VW_OK;
}

void vw_worth_retrainings_describe(const struct vw_ledger_retraining *retrainings, uint32_t count,
                                   struct vw_retrain_params *trained) {
    for (uint32_t i = 0; i < count; i++)
        trained[i] = (struct vw_retrain_params){
            .views = retrainings[i].image_ids, .view_count = retrainings[i].image_count, .seed = retrainings[i].seed};
}

enum vw_status vw_worth_retrainings_train(struct vw_ledger_retraining *retrainings, uint32_t first, uint32_t count,
                                          vw_retrain_function *retrain, void *context) {
    struct vw_retrain_params *trained = vw_allocate(count - first, sizeof *trained);
    struct vw_retrain_result *results = vw_allocate(count - first, sizeof *results);
    enum vw_status status = trained && results ? VW_OK : VW_ERROR_MEMORY;
    if (!status) vw_worth_retrainings_describe(retrainings + first, count - first, trained);
    if (!status) status = retrain(context, trained, count - first, results);
    for (uint32_t i = first; !status && i < count; i++)
        retrainings[i].val_psnr = isfinite(results[i - first].val_psnr) ? results[i - first].val_psnr : NAN;
    free(trained);
    free(results);
    return status;
}
