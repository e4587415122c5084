#include "value/evaluation/outcomes.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

// No training has these seeds: --seed counts up from small numbers.
static const uint64_t SUBSET_SEED = 0x73756273657473, SIZES_SEED = 0x73697a6573;
enum { DRAWS_PER_SUBSET = 100 };

uint32_t vw_subsets_smallest(uint32_t photo_count) { return (photo_count * VW_SUBSETS_LOWEST_PERCENT + 99) / 100; }

enum vw_status vw_subsets_allocate(uint32_t photo_count, uint32_t most, uint32_t seed_count, size_t members,
                                   struct vw_subsets *subsets) {
    *subsets = (struct vw_subsets){.photo_count = photo_count, .seed_count = seed_count};
    subsets->offsets = vw_allocate((size_t)most + 1, sizeof *subsets->offsets);
    subsets->places = vw_allocate(members, sizeof *subsets->places);
    subsets->results = vw_allocate((size_t)most * seed_count, sizeof *subsets->results);
    return subsets->offsets && subsets->places && subsets->results ? VW_OK : VW_ERROR_MEMORY;
}

// ---- Random subsets ----

static bool is_known(const struct vw_subsets *subsets, const uint32_t *places, uint32_t size) {
    for (uint32_t i = 0; i < subsets->count; i++)
        if (vw_subset_size(subsets, i) == size &&
            !memcmp(subsets->places + subsets->offsets[i], places, size * sizeof *places))
            return true;
    return false;
}

void vw_subsets_add(struct vw_subsets *subsets, const uint32_t *places, uint32_t size) {
    uint32_t first = subsets->offsets[subsets->count];
    memcpy(subsets->places + first, places, size * sizeof *places);
    subsets->offsets[++subsets->count] = first + size;
}

static uint32_t draw_size(uint64_t key, uint64_t draw, uint32_t photo_count) {
    uint32_t words[4], lowest = vw_subsets_smallest(photo_count);
    vw_random_words(SIZES_SEED + key, VW_RANDOM_ORDER, draw, 0, 1, words);
    return lowest + vw_random_below(words[0], photo_count - lowest + 1);
}

// Draws `count` more subsets; `order` has room for all photos.
static struct vw_subset_range draw(struct vw_subsets *subsets, uint32_t count, bool halves, uint64_t key,
                                   uint32_t *order) {
    uint32_t photo_count = subsets->photo_count;
    struct vw_subset_range drawn = {subsets->count, subsets->count};
    for (uint64_t i = 0; subsets->count - drawn.begin < count && i < (uint64_t)count * DRAWS_PER_SUBSET; i++) {
        uint32_t size = halves ? photo_count / 2 : draw_size(key, i, photo_count);
        vw_random_order((halves ? SUBSET_SEED : SIZES_SEED) + key, i, photo_count, order);
        vw_sort_places(order, size);
        if (!is_known(subsets, order, size)) vw_subsets_add(subsets, order, size);
    }
    drawn.end = subsets->count;
    return drawn;
}

enum vw_status vw_subsets_draw(const struct vw_subsets_params *params, struct vw_subsets *subsets) {
    uint32_t most = params->halves + params->random_sizes;
    uint32_t *order = vw_allocate(params->photo_count, sizeof *order);
    enum vw_status status =
        vw_subsets_allocate(params->photo_count, most, params->seed_count, (size_t)most * params->photo_count, subsets);
    if (!order) status = VW_ERROR_MEMORY;
    if (!status) subsets->halves = draw(subsets, params->halves, true, params->key, order);
    if (!status) subsets->sizes = draw(subsets, params->random_sizes, false, params->key, order);
    free(order);
    return status;
}

void vw_subsets_free(struct vw_subsets *subsets) {
    free(subsets->offsets);
    free(subsets->places);
    free(subsets->results);
}

static const struct {
    const char *name;
    size_t offset;
    bool higher_is_better;
} named_outcomes[VW_OUTCOME_COUNT] = {
    {"val_psnr", offsetof(struct vw_retrain_result, val_psnr), true},
    {"val_ssim", offsetof(struct vw_retrain_result, val_ssim), true},
    {"val_l1", offsetof(struct vw_retrain_result, val_l1), false},
    {"test_psnr", offsetof(struct vw_retrain_result, test_psnr), true},
    {"test_ssim", offsetof(struct vw_retrain_result, test_ssim), true},
    {"test_l1", offsetof(struct vw_retrain_result, test_l1), false},
};

const char *vw_outcome_name(enum vw_outcome outcome) { return named_outcomes[outcome].name; }

bool vw_outcome_higher_is_better(enum vw_outcome outcome) { return named_outcomes[outcome].higher_is_better; }

double vw_outcome_of(const struct vw_retrain_result *result, enum vw_outcome outcome) {
    double value;
    memcpy(&value, (const char *)result + named_outcomes[outcome].offset, sizeof value);
    return value;
}

static struct vw_outcome_mean mean_of(const struct vw_spread *spread) {
    if (!spread->count) return (struct vw_outcome_mean){NAN, NAN};
    return (struct vw_outcome_mean){spread->mean, sqrt(vw_spread_variance(spread) / (double)spread->count)};
}

struct vw_outcome_mean vw_samples_average(const double *samples, uint32_t count) {
    struct vw_spread spread = {0};
    for (uint32_t i = 0; i < count; i++) vw_spread_add(&spread, samples[i]);
    return mean_of(&spread);
}

struct vw_paired_difference vw_samples_compare(const double *samples, const double *against, uint32_t count) {
    struct vw_spread spread = {0};
    for (uint32_t i = 0; i < count; i++) vw_spread_add(&spread, samples[i] - against[i]);
    struct vw_outcome_mean mean = mean_of(&spread);
    double half = count > 1 ? vw_student_quantile(count - 1) * mean.standard_error : NAN;
    struct vw_paired_difference paired = {mean.mean, mean.standard_error, mean.mean - half, mean.mean + half, false};
    paired.beyond_noise = paired.ci_low > 0 || paired.ci_high < 0; // never where they are NaN
    return paired;
}

// ---- Subsets ----

static void keep_subset(const struct vw_retrain_result *results, uint32_t subset, enum vw_outcome outcome,
                        uint32_t stride, struct vw_outcomes *outcomes) {
    uint32_t seeds = outcomes->seed_count;
    double mean = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        double value = vw_outcome_of(&results[seed], outcome);
        outcomes->values[(size_t)seed * stride + outcomes->count] = value;
        mean += value / seeds;
    }
    if (!isfinite(mean)) return;
    outcomes->means[outcomes->count] = mean;
    outcomes->kept[outcomes->count++] = subset;
}

enum vw_status vw_outcomes_of_subsets(const struct vw_subsets *subsets, struct vw_subset_range range,
                                      enum vw_outcome outcome, struct vw_outcomes *outcomes) {
    uint32_t most = range.end - range.begin, seeds = subsets->seed_count;
    *outcomes = (struct vw_outcomes){.seed_count = seeds};
    outcomes->kept = vw_allocate(most, sizeof *outcomes->kept);
    outcomes->values = vw_allocate((size_t)most * (seeds + 1), sizeof *outcomes->values);
    if (!outcomes->kept || !outcomes->values) return VW_ERROR_MEMORY;
    outcomes->means = outcomes->values + (size_t)seeds * most;
    for (uint32_t i = range.begin; i < range.end; i++)
        keep_subset(subsets->results + (size_t)i * seeds, i, outcome, most, outcomes);
    for (uint32_t seed = 1; seed < seeds; seed++) // closes the gaps that subsets without a value leave
        for (uint32_t i = 0; i < outcomes->count; i++)
            outcomes->values[(size_t)seed * outcomes->count + i] = outcomes->values[(size_t)seed * most + i];
    return VW_OK;
}

void vw_outcomes_free(struct vw_outcomes *outcomes) {
    free(outcomes->kept);
    free(outcomes->values);
}
