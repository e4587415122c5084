#include "experiment/fold_scores.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "value/uncertainty.h"
#include "viewworth/value.h"

enum { SHARED_DEGREES = 2 };

// A score with what sorts it: the place of its method, then its photo.
struct entry {
    const struct vw_ledger_score *score;
    uint32_t method;
};

// One photo's scores of one method.
struct photo {
    double sum, squares; // squares: of the differences from the mean
    double own_variance;
    uint32_t folds; // with visits
    double between; // s^2; NaN below two folds
};

static int compare_entries(const void *left, const void *right) {
    const struct entry *a = left, *b = right;
    if (a->method != b->method) return a->method < b->method ? -1 : 1;
    if (a->score->image_id != b->score->image_id) return a->score->image_id < b->score->image_id ? -1 : 1;
    return a->score < b->score ? -1 : a->score > b->score;
}

static uint32_t place_of(const char *method, const char **methods, uint32_t *count) {
    uint32_t place = 0;
    while (place < *count && strcmp(methods[place], method) != 0) place++;
    if (place == *count) methods[(*count)++] = method;
    return place;
}

static uint32_t list_entries(const struct vw_fold_scores *folds, uint32_t fold_count, const char **methods,
                             struct entry *entries) {
    uint32_t count = 0, method_count = 0;
    for (uint32_t k = 0; k < fold_count; k++)
        for (uint32_t i = 0; i < folds[k].count; i++)
            entries[count++] =
                (struct entry){&folds[k].scores[i], place_of(folds[k].scores[i].method, methods, &method_count)};
    if (count) qsort(entries, count, sizeof *entries, compare_entries);
    return count;
}

static uint32_t count_alike(const struct entry *entries, uint32_t count, bool same_photo) {
    uint32_t alike = 1;
    while (alike < count && entries[alike].method == entries->method &&
           (!same_photo || entries[alike].score->image_id == entries->score->image_id))
        alike++;
    return alike;
}

static struct photo sum_photo(const struct entry *entries, uint32_t count) {
    struct photo photo = {.between = NAN};
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_ledger_score *score = entries[i].score;
        if (!score->visits || !isfinite(score->value)) continue;
        photo.sum += score->value;
        photo.own_variance += score->standard_error * score->standard_error;
        photo.folds++;
    }
    for (uint32_t i = 0; i < count && photo.folds; i++) {
        double difference = entries[i].score->value - photo.sum / photo.folds;
        if (entries[i].score->visits && isfinite(difference)) photo.squares += difference * difference;
    }
    if (photo.folds > 1) photo.between = photo.squares / (photo.folds - 1);
    return photo;
}

// Pools a photo's scores over the folds; a photo that trained in one fold keeps that score.
static struct vw_ledger_score pool_photo(const struct entry *entries, uint32_t count, const struct photo *photo,
                                         double median) {
    struct vw_ledger_score pooled = *entries->score;
    pooled.visits = 0;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_ledger_score *score = entries[i].score;
        bool counts = score->visits && isfinite(score->value);
        if (photo->folds == 1 && counts) pooled = *score;
        else if (counts) pooled.visits += score->visits;
    }
    if (photo->folds == 1) return pooled;
    uint32_t folds = photo->folds;
    pooled.value = folds ? photo->sum / folds : 0;
    pooled.standard_error = pooled.ci_low = pooled.ci_high = NAN;
    if (!folds) return pooled;
    uint32_t degrees = folds - 1 + SHARED_DEGREES;
    double between = (photo->squares + SHARED_DEGREES * median) / degrees, within = photo->own_variance / folds;
    pooled.standard_error = sqrt(fmax(between, within) / folds); // fmax prefers a number to NaN
    double half = vw_student_quantile(degrees) * pooled.standard_error;
    pooled.ci_low = pooled.value - half;
    pooled.ci_high = pooled.value + half;
    if (!strcmp(pooled.method, "quality")) {
        pooled.ci_low = fmax(pooled.ci_low, 0);
        pooled.ci_high = fmin(pooled.ci_high, 1);
    }
    return pooled;
}

// Pools the scores of a method. `variances` has room for one per photo.
static uint32_t pool_method(const struct entry *entries, uint32_t count, double *variances,
                            struct vw_ledger_score *pooled) {
    uint32_t known = 0, photos = 0;
    for (uint32_t i = 0, alike; i < count; i += alike) {
        alike = count_alike(entries + i, count - i, true);
        struct photo photo = sum_photo(entries + i, alike);
        if (isfinite(photo.between)) variances[known++] = photo.between;
    }
    double median = vw_median(variances, known);
    for (uint32_t i = 0, alike; i < count; i += alike) {
        alike = count_alike(entries + i, count - i, true);
        struct photo photo = sum_photo(entries + i, alike);
        pooled[photos++] = pool_photo(entries + i, alike, &photo, median);
    }
    for (uint32_t i = 0; i < photos; i++) variances[i] = pooled[i].value;
    const struct vw_value_method *method = photos ? vw_value_method_find(pooled->method) : NULL;
    vw_rank_intervals(pooled, photos, method && method->additive ? vw_length_variance(variances, photos) : 0);
    return photos;
}

enum vw_status vw_fold_scores_pool(const struct vw_fold_scores *folds, uint32_t fold_count,
                                   struct vw_ledger_score **pooled, uint32_t *pooled_count) {
    uint32_t most = 0, made = 0;
    for (uint32_t k = 0; k < fold_count; k++) most += folds[k].count;
    struct entry *entries = vw_allocate(most, sizeof *entries);
    const char **methods = vw_allocate(most, sizeof *methods);
    double *variances = vw_allocate(most, sizeof *variances);
    struct vw_ledger_score *scores = vw_allocate(most, sizeof *scores);
    bool whole = entries && methods && variances && scores;
    uint32_t count = whole ? list_entries(folds, fold_count, methods, entries) : 0;
    for (uint32_t i = 0, alike; i < count; i += alike) {
        alike = count_alike(entries + i, count - i, false);
        made += pool_method(entries + i, alike, variances, scores + made);
    }
    free(entries);
    free(methods);
    free(variances);
    if (!whole) {
        free(scores);
        return VW_ERROR_MEMORY;
    }
    *pooled = scores;
    *pooled_count = made;
    return VW_OK;
}
