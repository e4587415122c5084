#include "lab/evaluation/exact_values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "lab/evaluation/photo_values.h"

const char *vw_exact_value_name(enum vw_exact_value value) {
    static const char *const names[] = {"shapley", "banzhaf", "leave_one_out"};
    _Static_assert(VW_ARRAY_COUNT(names) == VW_EXACT_COUNT, "an exact value has no name");
    return names[value];
}

// Returns |S|! (N - 1 - |S|)! / N!, as 1 / (N times the number of subsets of that size among the others).
static double shapley_weight(uint32_t photo_count, uint32_t size) {
    double subsets = 1;
    for (uint32_t i = 0; i < size; i++) subsets = subsets * (photo_count - 1 - i) / (i + 1);
    return 1 / (photo_count * subsets);
}

static uint32_t size_of(uint32_t mask) {
    uint32_t size = 0;
    for (; mask; mask &= mask - 1) size++;
    return size;
}

// Finds the values of one photo in a game, whose outcomes are by mask: bit i is photo i.
static void find_values(const double *game, uint32_t photo_count, uint32_t photo, double values[VW_EXACT_COUNT]) {
    uint32_t bit = UINT32_C(1) << photo, all = (UINT32_C(1) << photo_count) - 1;
    for (int i = 0; i < VW_EXACT_COUNT; i++) values[i] = 0;
    for (uint32_t mask = 0; mask <= all; mask++) {
        if (mask & bit) continue;
        double marginal = game[mask | bit] - game[mask];
        values[VW_EXACT_SHAPLEY] += shapley_weight(photo_count, size_of(mask)) * marginal;
        values[VW_EXACT_BANZHAF] += marginal / (1 << (photo_count - 1));
    }
    values[VW_EXACT_LEAVE_ONE_OUT] = game[all] - game[all ^ bit];
}

static void list_game(const struct vw_subsets *subsets, enum vw_outcome outcome, uint32_t seed, double *game) {
    for (uint32_t i = 0; i < subsets->count; i++) {
        uint32_t mask = 0;
        for (uint32_t j = subsets->offsets[i]; j < subsets->offsets[i + 1]; j++)
            mask |= UINT32_C(1) << subsets->places[j];
        game[mask] = vw_outcome_of(&subsets->results[(size_t)i * subsets->seed_count + seed], outcome);
    }
}

enum vw_status vw_exact_values_find(const struct vw_subsets *subsets, struct vw_exact_values *exact) {
    uint32_t photos = subsets->photo_count, seeds = subsets->seed_count;
    double *game = vw_allocate(subsets->count, sizeof *game);
    enum vw_status status = game ? VW_OK : VW_ERROR_MEMORY;
    *exact = (struct vw_exact_values){.photo_count = photos, .seed_count = seeds};
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++) {
        for (int i = 0; i < VW_EXACT_COUNT; i++) {
            exact->values[truth][i] = vw_allocate((size_t)seeds * photos, sizeof(double));
            if (!exact->values[truth][i]) status = VW_ERROR_MEMORY;
        }
        for (uint32_t seed = 0; !status && seed < seeds; seed++) {
            list_game(subsets, vw_truths[truth], seed, game);
            for (uint32_t photo = 0; photo < photos; photo++) {
                double values[VW_EXACT_COUNT];
                find_values(game, photos, photo, values);
                for (int i = 0; i < VW_EXACT_COUNT; i++)
                    exact->values[truth][i][(size_t)seed * photos + photo] = values[i];
            }
        }
    }
    free(game);
    return status;
}

void vw_exact_values_free(struct vw_exact_values *exact) {
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++)
        for (int i = 0; i < VW_EXACT_COUNT; i++) free(exact->values[truth][i]);
}

enum vw_status vw_evaluate_exact_values(const struct vw_evaluation *evaluation, const struct vw_exact_values *exact,
                                        struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (int i = 0; i < VW_EXACT_COUNT; i++) {
        char group[VW_METRIC_BYTES];
        snprintf(group, sizeof group, "exact_%s", vw_exact_value_name((enum vw_exact_value)i));
        for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++) {
            const struct vw_photo_values values = {.group = group,
                                                   .name = vw_outcome_name(vw_truths[truth]),
                                                   .values = exact->values[truth][i],
                                                   .seed_count = exact->seed_count};
            status = vw_evaluate_photo_values(evaluation, &values, metrics);
        }
    }
    return status;
}
