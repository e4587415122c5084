#include "value/evaluation/subsets.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

static const uint64_t SUBSET_SEED = 0x73756273657473; // no training has it: --seed counts up from small numbers
enum { DRAWS_PER_SUBSET = 100 };

static bool is_known(const struct vw_subsets *subsets, const uint32_t *places) {
    for (uint32_t i = 0; i < subsets->count; i++)
        if (!memcmp(subsets->places + (size_t)i * subsets->size, places, subsets->size * sizeof *places)) return true;
    return false;
}

enum vw_status vw_subsets_draw(uint32_t photo_count, uint32_t count, struct vw_subsets *subsets) {
    *subsets = (struct vw_subsets){.size = photo_count / 2};
    subsets->places = vw_allocate((size_t)count * subsets->size, sizeof *subsets->places);
    subsets->results = vw_allocate((size_t)count * VW_SUBSET_SEEDS, sizeof *subsets->results);
    uint32_t *order = vw_allocate(photo_count, sizeof *order);
    if (!subsets->places || !subsets->results || !order) {
        free(order);
        return VW_ERROR_MEMORY;
    }
    for (uint64_t draw = 0; subsets->count < count && draw < (uint64_t)count * DRAWS_PER_SUBSET; draw++) {
        vw_random_order(SUBSET_SEED, draw, photo_count, order);
        vw_sort_places(order, subsets->size);
        if (is_known(subsets, order)) continue;
        memcpy(subsets->places + (size_t)subsets->count++ * subsets->size, order, subsets->size * sizeof *order);
    }
    free(order);
    return VW_OK;
}

enum vw_status vw_subsets_retrain(struct vw_subsets *subsets, const uint32_t *photos, uint64_t first_seed,
                                  vw_retrain_function *retrain, void *context) {
    uint32_t count = subsets->count * VW_SUBSET_SEEDS;
    size_t members = (size_t)subsets->count * subsets->size;
    uint32_t *views = vw_allocate(members, sizeof *views);
    struct vw_retrain_params *retrainings = vw_allocate(count, sizeof *retrainings);
    enum vw_status status = views && retrainings ? VW_OK : VW_ERROR_MEMORY;
    for (size_t member = 0; !status && member < members; member++) views[member] = photos[subsets->places[member]];
    for (uint32_t i = 0; !status && i < count; i++)
        retrainings[i] = (struct vw_retrain_params){.views = views + (size_t)(i / VW_SUBSET_SEEDS) * subsets->size,
                                                    .view_count = subsets->size,
                                                    .seed = first_seed + i % VW_SUBSET_SEEDS};
    if (!status) status = retrain(context, retrainings, count, subsets->results);
    free(views);
    free(retrainings);
    return status;
}

void vw_subsets_free(struct vw_subsets *subsets) {
    free(subsets->places);
    free(subsets->results);
}
