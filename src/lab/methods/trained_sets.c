#include "lab/methods/trained_sets.h"

#include <stdlib.h>

#include "base/memory.h"

enum vw_status vw_trained_sets_allocate(const struct vw_retraining_input *input, uint32_t count,
                                        struct vw_trained_sets *sets) {
    size_t places = (size_t)count * input->photo_count;
    *sets = (struct vw_trained_sets){.count = count,
                                     .photo_count = input->photo_count,
                                     .has = vw_allocate(places, sizeof *sets->has),
                                     .views = vw_allocate(places, sizeof *sets->views),
                                     .retrainings = vw_allocate(count, sizeof *sets->retrainings),
                                     .results = vw_allocate(count, sizeof *sets->results)};
    return sets->has && sets->views && sets->retrainings && sets->results ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_trained_sets_train(const struct vw_retraining_input *input, struct vw_trained_sets *sets) {
    for (uint32_t set = 0; set < sets->count; set++) {
        size_t first = (size_t)set * sets->photo_count;
        struct vw_retrain_params *retraining = &sets->retrainings[set];
        retraining->views = sets->views + first;
        retraining->view_count = 0;
        for (uint32_t i = 0; i < sets->photo_count; i++)
            if (sets->has[first + i]) sets->views[first + retraining->view_count++] = input->photos[i];
    }
    return input->retrain(input->context, sets->retrainings, sets->count, sets->results);
}

void vw_trained_sets_free(struct vw_trained_sets *sets) {
    free(sets->has);
    free(sets->views);
    free(sets->retrainings);
    free(sets->results);
}
