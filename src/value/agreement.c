#include "value/agreement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "value/series.h"

struct pair {
    double *first, *second; // owned, in one allocation
    uint32_t count;
};

static enum vw_status create_pair(uint32_t count, struct pair *pair) {
    *pair = (struct pair){.first = vw_allocate(count, 2 * sizeof *pair->first), .count = count};
    if (!pair->first) return VW_ERROR_MEMORY;
    pair->second = pair->first + count;
    return VW_OK;
}

// ---- Epochs --------------------------------------------------------------------------------------------------------

// Adds each visit to the half of its epoch, and computes the correlation over the train photos.
static enum vw_status compare_epochs(const struct vw_value_input *input, const struct vw_series *series,
                                     struct pair *halves, struct vw_ranking_agreement *agreement) {
    uint32_t photos = 0, half = series->epoch_count / 2;
    for (uint64_t i = 0; i < series->count; i++) {
        const struct vw_visit *visit = &series->visits[i];
        if (isfinite(visit->delta))
            (visit->epoch < half ? halves->first : halves->second)[visit->image] += visit->delta;
    }
    for (uint32_t i = 0; i < input->image_count; i++) {
        if (strcmp(input->images[i].split, "train") != 0) continue;
        halves->first[photos] = halves->first[i];
        halves->second[photos++] = halves->second[i];
    }
    return vw_spearman(halves->first, halves->second, photos, &agreement->epoch_halves);
}

static enum vw_status measure_epochs(const struct vw_value_input *input, struct vw_ranking_agreement *agreement) {
    struct vw_series series = {0};
    struct pair halves = {0};
    enum vw_status status = vw_series_make(input, VW_MEASURE_PSNR, VW_FORM_STEP, &series);
    agreement->epochs = series.epoch_count;
    if (!status && series.epoch_count >= VW_AGREEMENT_EPOCHS_MIN) {
        status = create_pair(input->image_count, &halves);
        if (!status) status = compare_epochs(input, &series, &halves, agreement);
    }
    free(halves.first);
    vw_series_free(&series);
    return status;
}

// ---- Other validation photos ---------------------------------------------------------------------------------------

static const double LOW_AGREEMENT = 0.3;

// Entries of the matrix, times the weights of their views, which are those with a weight.
struct entries {
    double *values;  // owned; photo by view, the mean of every view taken off
    double *sums;    // owned; of each photo
    double *squares; // owned; sum of each view
    double all_squares;
    uint32_t photo_count, view_count;
};

static enum vw_status create_entries(const struct vw_matrix *matrix, struct entries *entries) {
    *entries = (struct entries){.photo_count = matrix->photo_count};
    for (uint32_t v = 0; v < matrix->view_count; v++) entries->view_count += vw_matrix_weight(matrix, v) > 0;
    entries->values = vw_allocate((size_t)entries->photo_count * entries->view_count, sizeof *entries->values);
    entries->sums = vw_allocate(entries->photo_count, sizeof *entries->sums);
    entries->squares = vw_allocate(entries->view_count, sizeof *entries->squares);
    return entries->values && entries->sums && entries->squares ? VW_OK : VW_ERROR_MEMORY;
}

static void free_entries(struct entries *entries) {
    free(entries->values);
    free(entries->sums);
    free(entries->squares);
}

static void centre(struct entries *entries, uint32_t view) {
    double mean = 0, *column = entries->values + view;
    for (uint32_t p = 0; p < entries->photo_count; p++) mean += column[(size_t)p * entries->view_count];
    mean /= entries->photo_count;
    entries->squares[view] = 0;
    for (uint32_t p = 0; p < entries->photo_count; p++) {
        double *value = &column[(size_t)p * entries->view_count];
        *value -= mean;
        entries->sums[p] += *value;
        entries->squares[view] += *value * *value;
    }
    entries->all_squares += entries->squares[view];
}

// Takes the entries of all blocks of epochs but one; `left_out` of VW_MATRIX_BLOCKS leaves out none.
static void take_entries(const struct vw_matrix *matrix, uint32_t left_out, struct entries *entries) {
    const double *without = left_out < VW_MATRIX_BLOCKS ? vw_matrix_block(matrix, left_out) : NULL;
    entries->all_squares = 0;
    memset(entries->sums, 0, entries->photo_count * sizeof *entries->sums);
    for (uint32_t v = 0, place = 0; v < matrix->view_count; v++) {
        double weight = vw_matrix_weight(matrix, v);
        if (!(weight > 0)) continue;
        for (uint32_t p = 0; p < entries->photo_count; p++) {
            size_t entry = (size_t)p * matrix->view_count + v;
            entries->values[(size_t)p * entries->view_count + place] =
                weight * (matrix->psnr[entry] - (without ? without[entry] : 0));
        }
        centre(entries, place++);
    }
}

// Returns the logarithm of the mean square of the rest over that between photos, without one view; `left_out` of
// view_count leaves out none. Rounding leaves a rest of views that agree in full.
static double log_ratio(const struct entries *entries, uint32_t left_out) {
    static const double ROUNDING = 1e-12;
    bool all = left_out == entries->view_count;
    uint32_t views = entries->view_count - !all;
    double between = 0, squares = entries->all_squares - (all ? 0 : entries->squares[left_out]);
    for (uint32_t p = 0; p < entries->photo_count; p++) {
        double sum = entries->sums[p] - (all ? 0 : entries->values[(size_t)p * entries->view_count + left_out]);
        between += sum * sum / views;
    }
    return log(fmax(squares - between, ROUNDING * squares) / (views - 1) / between);
}

static double correlation_of(double log_ratio) {
    static const double PI = 3.14159265358979323846;
    return 6 / PI * asin(fmax(0, 1 - exp(log_ratio)) / 2);
}

// Returns the jackknife's variance: (n - 1) / n times the sum of squares around the mean.
static double jackknife_variance(const struct vw_spread *spread) {
    double count = (double)spread->count;
    return count < 2 ? 0 : (count - 1) * (count - 1) / count * vw_spread_variance(spread);
}

// Returns the variance of the logarithm over validation photos and over blocks of epochs. Fewer than three views leave
// one alone, which has no rest: their variance is infinite.
static double variance_of(const struct vw_matrix *matrix, struct entries *entries) {
    struct vw_spread by_view = {0}, by_block = {0};
    if (entries->view_count < 3) return INFINITY;
    for (uint32_t v = 0; v < entries->view_count; v++) vw_spread_add(&by_view, log_ratio(entries, v));
    for (uint32_t block = 0; block < VW_MATRIX_BLOCKS; block++) {
        if (!matrix->blocks || !matrix->visits_of_block[block]) continue;
        take_entries(matrix, block, entries);
        vw_spread_add(&by_block, log_ratio(entries, entries->view_count));
    }
    return jackknife_variance(&by_view) + jackknife_variance(&by_block);
}

// Predicts with at least three photos that train: two always agree, or never do.
static void predict_other_views(const struct vw_matrix *matrix, struct entries *entries,
                                struct vw_ranking_agreement *agreement) {
    agreement->other_views_low = 0;
    agreement->other_views_high = 1;
    if (entries->view_count < 2 || entries->photo_count < 3) return;
    take_entries(matrix, VW_MATRIX_BLOCKS, entries);
    double middle = log_ratio(entries, entries->view_count), variance = variance_of(matrix, entries);
    double reach = sqrt(variance) * vw_student_quantile_95(entries->view_count - 1);
    if (isnan(middle + reach) || isnan(middle - reach)) return; // no photo differs from another
    agreement->other_views = correlation_of(middle);
    agreement->other_views_low = correlation_of(middle + reach);
    agreement->other_views_high = correlation_of(middle - reach);
}

static enum vw_status measure_views(const struct vw_matrix *matrix, struct vw_ranking_agreement *agreement) {
    struct entries entries;
    enum vw_status status = create_entries(matrix, &entries);
    if (!status) predict_other_views(matrix, &entries, agreement);
    free_entries(&entries);
    return status;
}

bool vw_ranking_agreement_is_low(const struct vw_ranking_agreement *agreement) {
    return agreement->view_count && agreement->other_views_low < LOW_AGREEMENT;
}

// ---- A better training ---------------------------------------------------------------------------------------------

// The agreement that was measured, over the reliability.
static const double BETTER_TRAINING_SHARE = 0.85;

double vw_ranking_agreement_predict(const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_spread spread = {0};
    double squared_errors = 0;
    for (uint32_t i = 0; i < score_count; i++) {
        const struct vw_ledger_score *score = &scores[i];
        if (strcmp(score->method, vw_value_default_method) != 0 || !isfinite(score->standard_error)) continue;
        vw_spread_add(&spread, score->value);
        squared_errors += score->standard_error * score->standard_error;
    }
    if (spread.count < 3) return NAN;
    return BETTER_TRAINING_SHARE * fmax(0, 1 - squared_errors / spread.count / vw_spread_variance(&spread));
}

enum vw_status vw_ranking_agreement_measure(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                            const struct vw_ledger_score *scores, uint32_t score_count,
                                            struct vw_ranking_agreement *agreement) {
    *agreement = (struct vw_ranking_agreement){.epoch_halves = NAN,
                                               .better_training = vw_ranking_agreement_predict(scores, score_count),
                                               .other_views = NAN,
                                               .other_views_low = NAN,
                                               .other_views_high = NAN};
    for (uint32_t v = 0; v < matrix->view_count; v++) agreement->view_count += vw_matrix_weight(matrix, v) > 0;
    enum vw_status status = measure_epochs(input, agreement);
    return status || !matrix->visit_count ? status : measure_views(matrix, agreement);
}
