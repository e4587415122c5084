#include "value/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"
#include "viewworth/value.h"

enum { NOT_IN_MATRIX = UINT32_MAX };
enum { ENTRIES_FREE = 65536 }; // for a matrix that may have more entries than table view has rows

// ---- From the ledger's rows ----

struct summing {
    const struct vw_value_input *input;
    struct vw_matrix *matrix;
    uint32_t *places;            // owned; row or column of each image, by its index in the images
    double *last_psnr, *last_l1; // owned; of each view; NaN before the first value
    uint32_t last_epoch;         // the largest; epochs need not ascend in a ledger from elsewhere
    uint64_t step;               // its rows are read
    bool counted;                // whether that step is a visit
    uint64_t row_count;          // in table view
};

static uint32_t place_of(const struct summing *summing, uint32_t image_id, const char *split) {
    const struct vw_value_input *input = summing->input;
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, image_id);
    if (!image || strcmp(image->split, split) != 0) return NOT_IN_MATRIX;
    return summing->places[image - input->images];
}

static uint32_t row_of(const struct summing *summing, uint64_t step) {
    const struct vw_value_input *input = summing->input;
    const struct vw_step_record *record = step < input->record_count ? &input->records[step] : NULL;
    if (!record || record->step != step || record->view == VW_RECORD_UNTRAINED || record->epoch < input->burn_in_epochs)
        return NOT_IN_MATRIX;
    return place_of(summing, record->view, "train");
}

static uint32_t block_of(const struct summing *summing, uint64_t step) {
    uint32_t burn_in = summing->input->burn_in_epochs, epoch = summing->input->records[step].epoch - burn_in;
    return (uint32_t)((uint64_t)epoch * VW_MATRIX_BLOCKS / ((uint64_t)summing->last_epoch - burn_in + 1));
}

static void take_view(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error) {
    struct summing *summing = context;
    struct vw_matrix *matrix = summing->matrix;
    summing->row_count++;
    uint32_t row = row_of(summing, step), column = place_of(summing, image_id, "val");
    if (column == NOT_IN_MATRIX) return; // the image is unknown or not a validation photo: verify reports it
    double psnr = vw_psnr_db(error->mse), gain_psnr = psnr - summing->last_psnr[column],
           gain_l1 = summing->last_l1[column] - error->l1;
    summing->last_psnr[column] = psnr;
    summing->last_l1[column] = error->l1;
    if (row == NOT_IN_MATRIX || isnan(gain_psnr) || isnan(gain_l1)) return;
    size_t entry = (size_t)row * matrix->view_count + column;
    uint32_t block = block_of(summing, step);
    matrix->psnr[entry] += gain_psnr;
    if (matrix->blocks) matrix->blocks[(size_t)block * matrix->photo_count * matrix->view_count + entry] += gain_psnr;
    matrix->l1[entry] += gain_l1;
    bool first = !summing->counted || summing->step != step;
    matrix->visit_count += first;
    matrix->visits_of_block[block] += first;
    summing->counted = true;
    summing->step = step;
}

static void number_images(struct summing *summing) {
    const struct vw_value_input *input = summing->input;
    for (uint64_t i = 0; i < input->record_count; i++)
        if (input->records[i].epoch > summing->last_epoch) summing->last_epoch = input->records[i].epoch;
    struct vw_matrix *matrix = summing->matrix;
    for (uint32_t i = 0; i < input->image_count; i++) {
        bool photo = strcmp(input->images[i].split, "train") == 0, view = strcmp(input->images[i].split, "val") == 0;
        summing->places[i] = photo ? matrix->photo_count : view ? matrix->view_count : (uint32_t)NOT_IN_MATRIX;
        if (photo) matrix->photos[matrix->photo_count++] = input->images[i].image_id;
        if (view) matrix->weights[matrix->view_count] = input->images[i].weight;
        if (view) matrix->views[matrix->view_count++] = input->images[i].image_id;
    }
}

static enum vw_status allocate(struct summing *summing) {
    struct vw_matrix *matrix = summing->matrix;
    uint32_t image_count = summing->input->image_count;
    matrix->photos = vw_allocate(image_count, sizeof *matrix->photos);
    matrix->views = vw_allocate(image_count, sizeof *matrix->views);
    summing->places = vw_allocate(image_count, sizeof *summing->places);
    matrix->weights = vw_allocate(image_count, sizeof *matrix->weights);
    if (!matrix->photos || !matrix->views || !matrix->weights || !summing->places) return VW_ERROR_MEMORY;
    number_images(summing);
    matrix->psnr = vw_allocate((size_t)matrix->photo_count * matrix->view_count, sizeof *matrix->psnr);
    bool each_visited = matrix->photo_count <= summing->input->record_count; // else a ledger from elsewhere
    size_t block_bytes = VW_MATRIX_BLOCKS * sizeof *matrix->blocks;
    if (each_visited) matrix->blocks = vw_allocate((size_t)matrix->photo_count * matrix->view_count, block_bytes);
    matrix->l1 = vw_allocate((size_t)matrix->photo_count * matrix->view_count, sizeof *matrix->l1);
    matrix->end_psnr = summing->last_psnr = vw_allocate(matrix->view_count, sizeof *summing->last_psnr);
    summing->last_l1 = vw_allocate(matrix->view_count, sizeof *summing->last_l1);
    if (!matrix->psnr || (each_visited && !matrix->blocks) || !matrix->l1 || !summing->last_psnr || !summing->last_l1)
        return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < matrix->view_count; v++) summing->last_psnr[v] = summing->last_l1[v] = NAN;
    return VW_OK;
}

// Returns whether the table view had any rows, and not too few for so large a matrix. An epoch leaves a row for every
// entry. A ledger from elsewhere may name so many photos and views that only a matrix of zeros could be made in time.
static bool has_values(const struct vw_matrix *matrix, uint64_t row_count) {
    uint64_t entries = (uint64_t)matrix->photo_count * matrix->view_count;
    bool some = false;
    if (entries > ENTRIES_FREE && entries > row_count) return false;
    for (uint32_t v = 0; v < matrix->view_count; v++) some = some || !isnan(matrix->end_psnr[v]);
    return some;
}

static enum vw_status sum_lasting(const struct summing *summing) {
    const struct vw_value_input *input = summing->input;
    const struct vw_lasting_pass *pass = &input->lasting;
    struct vw_matrix *matrix = summing->matrix;
    if (!pass->view_count || pass->step_count + 1 != input->record_count) return VW_OK;
    matrix->lasting = vw_allocate((size_t)matrix->photo_count * matrix->view_count, sizeof *matrix->lasting);
    if (!matrix->lasting) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < pass->view_count; v++) {
        uint32_t column = place_of(summing, pass->views[v], "val");
        for (uint64_t i = 0; i < pass->step_count && column != NOT_IN_MATRIX; i++) {
            uint32_t row = place_of(summing, input->records[i + 1].view, "train");
            if (row != NOT_IN_MATRIX)
                matrix->lasting[(size_t)row * matrix->view_count + column] += pass->view_psnr[i * pass->view_count + v];
        }
    }
    return VW_OK;
}

enum vw_status vw_value_matrix(struct vw_ledger *ledger, const struct vw_value_input *input, struct vw_matrix *matrix) {
    *matrix = (struct vw_matrix){0};
    struct summing summing = {.input = input, .matrix = matrix};
    enum vw_status status = allocate(&summing);
    if (!status) status = vw_ledger_each_view(ledger, take_view, &summing);
    if (!status && !has_values(matrix, summing.row_count)) {
        matrix->view_count = 0;
        matrix->visit_count = 0;
    }
    if (!status && matrix->view_count) status = sum_lasting(&summing);
    free(summing.places);
    free(summing.last_l1);
    return status;
}

void vw_matrix_clear(struct vw_matrix *matrix) {
    free(matrix->photos);
    free(matrix->views);
    free(matrix->psnr);
    free(matrix->blocks);
    free(matrix->l1);
    free(matrix->lasting);
    free(matrix->end_psnr);
    free(matrix->weights);
    *matrix = (struct vw_matrix){0};
}

// ---- The jackknife over validation views ---------------------------------------------------------------------------

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
