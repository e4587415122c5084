#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "value/matrix.h"

enum { VIEWS_LEAST = 4 };        // with fewer views, none can be called an outlier
enum { VISITS_LEAST = 5 };       // per photo on average: with fewer, deltas depend more on the steps than on the photos
static const double SPREADS = 4; // a normal value is farther from the mean once in 16,000 times
static const double AGREEMENT_MOST = 0.3; // largest agreement of a view that disagrees
static const double AGREEMENT_GAP =
    0.3; // least distance to the median agreement: no view stands out if all agree only a little
static const double PSNR_GAP_DB = 6;                 // four times the squared error
static const double ODD_SPREADS = 3, ODD_GAP_DB = 3; // the same of a view that also disagrees: twice the squared error

// A photo's score with all views, and without one of them.
struct columns {
    double *all, *rest, *own; // one per photo
    double *before;           // per photo: the sum of the views before this one
    double *behind;           // per photo and view: the sum of the views after it
};

static enum vw_status create_columns(const struct vw_matrix *matrix, struct columns *columns) {
    size_t photos = matrix->photo_count, views = matrix->view_count;
    double *memory = vw_allocate(photos * (4 + views), sizeof *memory);
    if (!memory) return VW_ERROR_MEMORY;
    *columns = (struct columns){memory, memory + photos, memory + 2 * photos, memory + 3 * photos, memory + 4 * photos};
    for (size_t p = 0; p < photos; p++)
        for (size_t v = views; v-- > 1;)
            columns->behind[p * views + v - 1] =
                columns->behind[p * views + v] + vw_matrix_weight(matrix, (uint32_t)v) * matrix->psnr[p * views + v];
    return VW_OK;
}

// Adds the columns of a view; call it with the views in order. Ranks alone matter, so that sums of weighted entries are
// divided by counts. It uses sums on both sides, not a difference from the whole sum, which would cancel if one view
// outweighs all others.
static void take_columns(const struct vw_matrix *matrix, uint32_t view, struct columns *columns) {
    uint32_t count = matrix->view_count;
    for (uint32_t p = 0; p < matrix->photo_count; p++) {
        size_t entry = (size_t)p * count + view;
        double own = vw_matrix_weight(matrix, view) * matrix->psnr[entry],
               others = columns->before[p] + columns->behind[entry];
        columns->all[p] = (columns->before[p] + own + columns->behind[entry]) / count;
        columns->rest[p] = others / (count - 1);
        columns->own[p] = matrix->psnr[entry];
        columns->before[p] += own;
    }
}

static enum vw_status evaluate_columns(const struct vw_matrix *matrix, struct vw_view_evidence *views) {
    struct columns columns;
    enum vw_status status = create_columns(matrix, &columns);
    if (status) return status;
    for (uint32_t v = 0; !status && v < matrix->view_count; v++) {
        views[v] = (struct vw_view_evidence){
            .image_id = matrix->views[v], .end_psnr = matrix->end_psnr[v], .agreement = NAN, .without = NAN};
        if (matrix->view_count < 2) continue;
        take_columns(matrix, v, &columns);
        status = vw_spearman(columns.own, columns.rest, matrix->photo_count, &views[v].agreement);
        if (!status) status = vw_spearman(columns.rest, columns.all, matrix->photo_count, &views[v].without);
    }
    free(columns.all); // the whole memory
    return status;
}

// The median and the robust spread of the values that are not NaN; -INFINITY and 0 if there are too few.
struct usual {
    double middle, spread;
};

// Moves the values that are not NaN to the front.
static struct usual find_usual(double *values, uint32_t count) {
    uint32_t known = 0;
    for (uint32_t i = 0; i < count; i++)
        if (!isnan(values[i])) values[known++] = values[i];
    if (known < VIEWS_LEAST) return (struct usual){-INFINITY, 0};
    return (struct usual){vw_median(values, known), vw_robust_spread(values, known)};
}

// Returns the limit below which a value is an outlier; it is at least `gap` below the median.
static double lower_limit(struct usual usual, double spreads, double gap) {
    return usual.middle - fmax(spreads * usual.spread, gap);
}

static enum vw_status evaluate_oddities(uint32_t count, struct vw_view_evidence *views) {
    double *values = vw_allocate(count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < count; v++) values[v] = views[v].agreement;
    double least_agreement = fmin(lower_limit(find_usual(values, count), SPREADS, AGREEMENT_GAP), AGREEMENT_MOST);
    for (uint32_t v = 0; v < count; v++) values[v] = views[v].end_psnr;
    const struct usual psnr = find_usual(values, count);
    free(values);
    for (uint32_t v = 0; v < count; v++) {
        bool disagrees = views[v].agreement < least_agreement && views[v].end_psnr < psnr.middle;
        views[v].disagrees = disagrees && views[v].end_psnr < lower_limit(psnr, ODD_SPREADS, ODD_GAP_DB);
        views[v].lone = disagrees && !views[v].disagrees;
        views[v].stays_low = views[v].end_psnr < lower_limit(psnr, SPREADS, PSNR_GAP_DB);
    }
    return VW_OK;
}

// Returns the delete-one jackknife of a row's weighted mean: its standard error over the views with a weight. Without
// a view the mean changes by its entry's distance times weight / (sum - weight).
static double standard_error_of(const struct vw_matrix *matrix, const double *row) {
    double mean = 0, squares = 0, sum = 0;
    uint32_t count = 0;
    for (uint32_t v = 0; v < matrix->view_count; v++) {
        sum += vw_matrix_weight(matrix, v);
        count += vw_matrix_weight(matrix, v) > 0;
    }
    if (count < 2) return NAN;
    for (uint32_t v = 0; v < matrix->view_count; v++) mean += vw_matrix_weight(matrix, v) * row[v] / sum;
    for (uint32_t v = 0; v < matrix->view_count; v++) {
        double weight = vw_matrix_weight(matrix, v), share = weight * (count - 1) / (sum - weight);
        squares += (row[v] - mean) * share * ((row[v] - mean) * share);
    }
    return sqrt(squares / count / (count - 1));
}

enum vw_status vw_matrix_jackknife(const struct vw_matrix *matrix, struct vw_view_evidence *views,
                                   double *standard_errors) {
    enum vw_status status = evaluate_columns(matrix, views);
    bool trained = matrix->visit_count >= VISITS_LEAST * (uint64_t)matrix->photo_count;
    if (!status && trained && matrix->view_count >= VIEWS_LEAST) status = evaluate_oddities(matrix->view_count, views);
    for (uint32_t p = 0; !status && p < matrix->photo_count; p++)
        standard_errors[p] = standard_error_of(matrix, &matrix->psnr[(size_t)p * matrix->view_count]);
    return status;
}
