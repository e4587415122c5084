#include "value/evaluation/worth_regression.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "value/evaluation/resampling.h"

const char vw_subset_worth_name[] = "subset_worth";

static const uint64_t FOLD_SEED = 0x666f6c6473; // of no training
// Penalties that cross-validation chooses from, per subset: 1e-8, 4e-8, ... 10.7.
enum { PENALTIES = 16 };
static const double LEAST_PENALTY = 1e-8, PENALTY_FACTOR = 4;
static const double GUARD = 1e-9; // penalty of the size, so that a fit of subsets of one size has a solution

// Features of a subset: 1, its share of the photos less 1/2, and per photo whether it has the photo, less that share.
// The last are penalised. They do not change when their coefficients grow by the same number, so that the mean of
// these is free, and the penalty pulls them to their own mean.
enum { CONSTANT, SHARE, FIRST_PHOTO };

// A least-squares problem: sums of products over subsets.
struct sums {
    double *gram, *moments; // [feature][feature], of which the lower half counts, and [feature]
};

struct regression {
    const struct vw_subsets *subsets;
    struct vw_outcomes outcomes;
    uint32_t features;
    uint32_t *folds;                                // [subset kept]
    double *rows;                                   // [subset kept][feature]
    struct sums all, of_fold[VW_WORTH_FOLDS], rest; // rest: scratch
    double *factor, *solution;                      // scratch
};

// ---- Least squares ----

static enum vw_status allocate_sums(uint32_t features, struct sums *sums) {
    sums->gram = vw_allocate((size_t)features * (features + 1), sizeof *sums->gram);
    if (!sums->gram) return VW_ERROR_MEMORY;
    sums->moments = sums->gram + (size_t)features * features;
    return VW_OK;
}

static void clear_sums(uint32_t features, struct sums *sums) {
    memset(sums->gram, 0, (size_t)features * (features + 1) * sizeof *sums->gram);
}

static void add_subset(const struct regression *regression, uint32_t kept, double weight, struct sums *sums) {
    uint32_t features = regression->features;
    const double *row = regression->rows + (size_t)kept * features;
    for (uint32_t i = 0; i < features; i++) {
        for (uint32_t j = 0; j <= i; j++) sums->gram[(size_t)i * features + j] += weight * row[i] * row[j];
        sums->moments[i] += weight * row[i] * regression->outcomes.means[kept];
    }
}

static void subtract_sums(uint32_t features, const struct sums *from, struct sums *sums) {
    for (size_t i = 0; i < (size_t)features * (features + 1); i++) sums->gram[i] -= from->gram[i];
}

// Cholesky's factor of the penalised matrix. False where it is singular.
static bool factorise(const struct sums *sums, uint32_t features, double penalty, double *factor) {
    for (uint32_t i = 0; i < features; i++)
        for (uint32_t j = 0; j <= i; j++) {
            double sum = sums->gram[(size_t)i * features + j];
            if (i == j) sum += i >= FIRST_PHOTO ? penalty : i == SHARE ? GUARD * sums->gram[0] : 0;
            for (uint32_t k = 0; k < j; k++) sum -= factor[(size_t)i * features + k] * factor[(size_t)j * features + k];
            if (i == j && !(sum > 0)) return false;
            factor[(size_t)i * features + j] = i == j ? sqrt(sum) : sum / factor[(size_t)j * features + j];
        }
    return true;
}

// The coefficients; all NaN where there is no single solution.
static void solve(struct regression *regression, const struct sums *sums, double penalty) {
    uint32_t features = regression->features;
    double *factor = regression->factor, *solution = regression->solution;
    bool solvable = factorise(sums, features, penalty, factor);
    for (uint32_t i = 0; i < features; i++) {
        double sum = solvable ? sums->moments[i] : NAN;
        for (uint32_t k = 0; k < i; k++) sum -= factor[(size_t)i * features + k] * solution[k];
        solution[i] = sum / factor[(size_t)i * features + i];
    }
    for (uint32_t i = features; i-- > 0;) {
        double sum = solution[i];
        for (uint32_t k = i + 1; k < features; k++) sum -= factor[(size_t)k * features + i] * solution[k];
        solution[i] = sum / factor[(size_t)i * features + i];
    }
}

static double predict(const struct regression *regression, uint32_t kept) {
    const double *row = regression->rows + (size_t)kept * regression->features;
    double sum = 0;
    for (uint32_t i = 0; i < regression->features; i++) sum += row[i] * regression->solution[i];
    return sum;
}

// ---- Cross-validation ----

static double penalty_of(const struct regression *regression, uint32_t place) {
    return LEAST_PENALTY * pow(PENALTY_FACTOR, place) * regression->outcomes.count;
}

// Makes `rest` the sums over all folds but two; equal ones count once, VW_WORTH_FOLDS is none.
static void leave_folds_out(struct regression *regression, uint32_t first, uint32_t second) {
    uint32_t features = regression->features;
    memcpy(regression->rest.gram, regression->all.gram, (size_t)features * (features + 1) * sizeof(double));
    if (first < VW_WORTH_FOLDS) subtract_sums(features, &regression->of_fold[first], &regression->rest);
    if (second < VW_WORTH_FOLDS && second != first)
        subtract_sums(features, &regression->of_fold[second], &regression->rest);
}

static double squared_error(const struct regression *regression, uint32_t fold) {
    double sum = 0;
    for (uint32_t i = 0; i < regression->outcomes.count; i++)
        if (regression->folds[i] == fold) sum += pow(predict(regression, i) - regression->outcomes.means[i], 2);
    return sum;
}

// The penalty of the smallest error on left-out folds; the fold `unseen` takes no part.
static double choose_penalty(struct regression *regression, uint32_t unseen) {
    double errors[PENALTIES] = {0};
    uint32_t best = 0;
    for (uint32_t fold = 0; fold < VW_WORTH_FOLDS; fold++) {
        if (fold == unseen) continue;
        leave_folds_out(regression, fold, unseen);
        for (uint32_t i = 0; i < PENALTIES; i++) {
            solve(regression, &regression->rest, penalty_of(regression, i));
            errors[i] += squared_error(regression, fold);
        }
    }
    for (uint32_t i = 1; i < PENALTIES; i++)
        if (errors[i] < errors[best]) best = i;
    return penalty_of(regression, best);
}

static void predict_left_out(struct regression *regression, struct vw_worths *worths) {
    for (uint32_t fold = 0; fold < VW_WORTH_FOLDS; fold++) {
        double penalty = choose_penalty(regression, fold);
        leave_folds_out(regression, fold, VW_WORTH_FOLDS);
        solve(regression, &regression->rest, penalty);
        for (uint32_t i = 0; i < regression->outcomes.count; i++)
            if (regression->folds[i] == fold) worths->predicted[regression->outcomes.kept[i]] = predict(regression, i);
    }
}

static enum vw_status compare_left_out(const struct regression *regression, struct vw_worths *worths) {
    const struct vw_outcomes *outcomes = &regression->outcomes;
    double *predicted = vw_allocate(outcomes->count, sizeof *predicted), mean = 0, error = 0, total = 0;
    if (!predicted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < outcomes->count; i++) mean += outcomes->means[i] / outcomes->count;
    for (uint32_t i = 0; i < outcomes->count; i++) {
        predicted[i] = worths->predicted[outcomes->kept[i]];
        error += pow(predicted[i] - outcomes->means[i], 2);
        total += pow(outcomes->means[i] - mean, 2);
    }
    worths->pearson = vw_pearson(predicted, outcomes->means, outcomes->count);
    worths->r2 = total > 0 ? 1 - error / total : NAN;
    free(predicted);
    return VW_OK;
}

// ---- Worths ----

// What a photo adds: its own coefficient, against the mean one, and an even part of the size's.
static void take_worths(const struct regression *regression, uint32_t photo_count, double *worths) {
    const double *of_photo = regression->solution + FIRST_PHOTO;
    double mean = 0;
    for (uint32_t i = 0; i < photo_count; i++) mean += of_photo[i] / photo_count;
    for (uint32_t i = 0; i < photo_count; i++)
        worths[i] = regression->solution[SHARE] / photo_count + of_photo[i] - mean;
}

static enum vw_status find_worths(struct regression *regression, struct vw_worths *worths) {
    uint32_t photos = worths->photo_count, count = regression->outcomes.count;
    double penalty = choose_penalty(regression, VW_WORTH_FOLDS), *drawn = vw_allocate(VW_RESAMPLES, sizeof *drawn);
    uint16_t *times = vw_resamples_draw(count);
    enum vw_status status = times && drawn ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t r = 0; !status && r <= VW_RESAMPLES; r++) {
        clear_sums(regression->features, &regression->rest);
        for (uint32_t i = 0; i < count; i++)
            if (times[(size_t)r * count + i])
                add_subset(regression, i, times[(size_t)r * count + i], &regression->rest);
        solve(regression, &regression->rest, penalty);
        take_worths(regression, photos, worths->resampled + (size_t)r * photos);
    }
    for (uint32_t photo = 0; !status && photo < photos; photo++) {
        worths->values[photo] = worths->resampled[photo];
        for (uint32_t r = 0; r < VW_RESAMPLES; r++) drawn[r] = worths->resampled[(size_t)(1 + r) * photos + photo];
        vw_resampling_interval(drawn, &worths->ci_low[photo], &worths->ci_high[photo]);
    }
    free(drawn);
    free(times);
    return status;
}

// ---- All of it ----

static void list_features(struct regression *regression) {
    const struct vw_subsets *subsets = regression->subsets;
    for (uint32_t i = 0; i < regression->outcomes.count; i++) {
        uint32_t subset = regression->outcomes.kept[i], size = vw_subset_size(subsets, subset);
        double *row = regression->rows + (size_t)i * regression->features, share = (double)size / subsets->photo_count;
        row[CONSTANT] = 1;
        row[SHARE] = share - 0.5;
        for (uint32_t photo = 0; photo < subsets->photo_count; photo++) row[FIRST_PHOTO + photo] = -share;
        for (uint32_t j = 0; j < size; j++) row[FIRST_PHOTO + subsets->places[subsets->offsets[subset] + j]] += 1;
    }
}

// Random folds of equal sizes, and the sums over each.
static void divide(struct regression *regression) {
    uint32_t count = regression->outcomes.count;
    vw_random_order(FOLD_SEED, 0, count, regression->folds);
    for (uint32_t i = 0; i < count; i++) {
        regression->folds[i] %= VW_WORTH_FOLDS;
        add_subset(regression, i, 1, &regression->of_fold[regression->folds[i]]);
        add_subset(regression, i, 1, &regression->all);
    }
}

static enum vw_status open_regression(const struct vw_subsets *subsets, enum vw_quality quality,
                                      struct regression *regression) {
    *regression = (struct regression){.subsets = subsets, .features = FIRST_PHOTO + subsets->photo_count};
    uint32_t features = regression->features;
    enum vw_status status =
        vw_outcomes_of_subsets(subsets, (struct vw_subset_range){0, subsets->count}, quality, &regression->outcomes);
    for (uint32_t fold = 0; !status && fold < VW_WORTH_FOLDS; fold++)
        status = allocate_sums(features, &regression->of_fold[fold]);
    if (!status) status = allocate_sums(features, &regression->all);
    if (!status) status = allocate_sums(features, &regression->rest);
    if (status) return status;
    regression->folds = vw_allocate(regression->outcomes.count, sizeof *regression->folds);
    regression->rows = vw_allocate((size_t)regression->outcomes.count * features, sizeof *regression->rows);
    regression->factor = vw_allocate((size_t)features * features, sizeof *regression->factor);
    regression->solution = vw_allocate(features, sizeof *regression->solution);
    bool enough = regression->folds && regression->rows && regression->factor && regression->solution;
    if (!enough) return VW_ERROR_MEMORY;
    list_features(regression);
    divide(regression);
    return VW_OK;
}

static void close_regression(struct regression *regression) {
    vw_outcomes_free(&regression->outcomes);
    for (uint32_t fold = 0; fold < VW_WORTH_FOLDS; fold++) free(regression->of_fold[fold].gram);
    free(regression->all.gram);
    free(regression->rest.gram);
    free(regression->folds);
    free(regression->rows);
    free(regression->factor);
    free(regression->solution);
}

static enum vw_status open_worths(const struct vw_subsets *subsets, struct vw_worths *worths) {
    uint32_t photos = subsets->photo_count;
    size_t resampled = (1 + (size_t)VW_RESAMPLES) * photos;
    *worths = (struct vw_worths){.photo_count = photos, .pearson = NAN, .r2 = NAN};
    worths->values = vw_allocate(photos, 3 * sizeof *worths->values);
    worths->resampled = vw_allocate(resampled, sizeof *worths->resampled);
    worths->predicted = vw_allocate(subsets->count, sizeof *worths->predicted);
    if (!worths->values || !worths->resampled || !worths->predicted) return VW_ERROR_MEMORY;
    worths->ci_low = worths->values + photos;
    worths->ci_high = worths->ci_low + photos;
    for (size_t i = 0; i < 3 * (size_t)photos; i++) worths->values[i] = NAN;
    for (size_t i = 0; i < resampled; i++) worths->resampled[i] = NAN;
    for (uint32_t i = 0; i < subsets->count; i++) worths->predicted[i] = NAN;
    return VW_OK;
}

enum vw_status vw_worths_fit(const struct vw_subsets *subsets, enum vw_quality quality, struct vw_worths *worths) {
    struct regression regression = {0};
    enum vw_status status = open_worths(subsets, worths);
    if (!status) status = open_regression(subsets, quality, &regression);
    if (!status && regression.outcomes.count >= VW_WORTH_FOLDS) {
        worths->count = regression.outcomes.count;
        predict_left_out(&regression, worths);
        status = compare_left_out(&regression, worths);
        if (!status) status = find_worths(&regression, worths);
    }
    close_regression(&regression);
    return status;
}

void vw_worths_free(struct vw_worths *worths) {
    free(worths->values);
    free(worths->resampled);
    free(worths->predicted);
}
