#include "lab/evaluation/leave_one_out.h"

#include <stdlib.h>

#include "base/memory.h"
#include "lab/evaluation/photo_values.h"

// ---- Trainings ----

// Returns a training on all photos but one, whose place is left_out; on all of them when it is the number of photos.
static struct vw_retrain_params retraining_without(const struct vw_evaluation *evaluation, uint32_t left_out,
                                                   uint64_t seed, uint32_t *views) {
    struct vw_retrain_params retraining = {.views = views, .seed = seed};
    for (uint32_t i = 0; i < evaluation->photo_count; i++)
        if (i != left_out) views[retraining.view_count++] = evaluation->photos[i];
    return retraining;
}

static void take_results(const struct vw_retrain_result *results, struct vw_left_out *left_out) {
    uint32_t photos = left_out->photo_count, of_seed = photos + 1;
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++)
        for (uint32_t seed = 0; seed < left_out->seed_count; seed++) {
            const struct vw_retrain_result *all = results + (size_t)seed * of_seed;
            for (uint32_t i = 0; i < photos; i++)
                left_out->worths[truth][(size_t)seed * photos + i] =
                    vw_outcome_of(all, vw_truths[truth]) - vw_outcome_of(all + 1 + i, vw_truths[truth]);
        }
}

enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint32_t seed_count, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, struct vw_left_out *left_out) {
    uint32_t photos = evaluation->photo_count, of_seed = photos + 1, count = seed_count * of_seed;
    uint32_t *views = vw_allocate((size_t)count * photos, sizeof *views);
    struct vw_retrain_params *retrainings = vw_allocate(count, sizeof *retrainings);
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status = views && retrainings && results ? VW_OK : VW_ERROR_MEMORY;
    *left_out = (struct vw_left_out){.seed_count = seed_count, .photo_count = photos};
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++)
        if (!(left_out->worths[truth] = vw_allocate((size_t)seed_count * photos, sizeof(double))))
            status = VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++) // each seed begins with the training on all photos
        retrainings[i] = retraining_without(evaluation, i % of_seed ? i % of_seed - 1 : photos,
                                            first_seed + i / of_seed, views + (size_t)i * photos);
    if (!status) status = retrain(context, retrainings, count, results);
    if (!status) take_results(results, left_out);
    free(views);
    free(retrainings);
    free(results);
    return status;
}

void vw_left_out_free(struct vw_left_out *left_out) {
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++) free(left_out->worths[truth]);
}

// ---- Agreement with scores ----

enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const struct vw_left_out *left_out,
                                         struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++) {
        const struct vw_photo_values values = {.group = "leave_one_out",
                                               .name = vw_outcome_name(vw_truths[truth]),
                                               .values = left_out->worths[truth],
                                               .seed_count = left_out->seed_count};
        status = vw_evaluate_photo_values(evaluation, &values, metrics);
    }
    return status;
}
