#include "lab/evaluation/subset_trainings.h"

#include <stdlib.h>

#include "base/memory.h"

// ---- All subsets ----

static void add_subsets_of_size(struct vw_subsets *subsets, uint32_t size) {
    for (uint32_t mask = 0; mask < UINT32_C(1) << subsets->photo_count; mask++) {
        uint32_t places[VW_SUBSETS_ALL_PHOTOS_MAX], members = 0;
        for (uint32_t photo = 0; photo < subsets->photo_count; photo++)
            if (mask >> photo & 1) places[members++] = photo;
        if (members == size) vw_subsets_add(subsets, places, size);
    }
}

// Lists smaller ones first, so that both ranges are without gaps.
enum vw_status vw_subsets_list_all(uint32_t photo_count, uint32_t seed_count, struct vw_subsets *subsets) {
    *subsets = (struct vw_subsets){0};
    if (photo_count > VW_SUBSETS_ALL_PHOTOS_MAX)
        return vw_fail(VW_ERROR_USAGE, "--subsets all: %u photos have too many subsets; at most %d photos are possible",
                       photo_count, VW_SUBSETS_ALL_PHOTOS_MAX);
    uint32_t count = UINT32_C(1) << photo_count;
    enum vw_status status = vw_subsets_allocate(photo_count, count, seed_count, (size_t)count * photo_count, subsets);
    for (uint32_t size = 0; !status && size <= photo_count; size++) {
        if (size == photo_count / 2) subsets->halves.begin = subsets->count;
        if (size == vw_subsets_smallest(photo_count)) subsets->sizes.begin = subsets->count;
        add_subsets_of_size(subsets, size);
        if (size == photo_count / 2) subsets->halves.end = subsets->count;
    }
    subsets->sizes.end = subsets->count;
    return status;
}

// ---- Trainings ----

enum vw_status vw_subsets_retrain(struct vw_subsets *subsets, const uint32_t *photos, uint64_t first_seed,
                                  vw_retrain_function *retrain, void *context) {
    uint32_t seeds = subsets->seed_count, count = subsets->count * seeds, members = subsets->offsets[subsets->count];
    uint32_t *views = vw_allocate(members, sizeof *views);
    struct vw_retrain_params *retrainings = vw_allocate(count, sizeof *retrainings);
    enum vw_status status = views && retrainings ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t member = 0; !status && member < members; member++) views[member] = photos[subsets->places[member]];
    for (uint32_t i = 0; !status && i < count; i++)
        retrainings[i] = (struct vw_retrain_params){.views = views + subsets->offsets[i / seeds],
                                                    .view_count = vw_subset_size(subsets, i / seeds),
                                                    .seed = first_seed + i % seeds};
    if (!status) status = retrain(context, retrainings, count, subsets->results);
    free(views);
    free(retrainings);
    return status;
}
