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

// A matrix while its entries are summed.
struct summing {
    const struct vw_value_input *input;
    struct vw_matrix *matrix;
    uint32_t *places;            // owned; row or column of each image, by its index in the images
    double *last_psnr, *last_l1; // owned; of each view; NaN before the first value
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

// Returns the row of the photo that a step trained on.
static uint32_t row_of(const struct summing *summing, uint64_t step) {
    const struct vw_value_input *input = summing->input;
    const struct vw_step_record *record = step < input->record_count ? &input->records[step] : NULL;
    if (!record || record->step != step || record->view == VW_RECORD_UNTRAINED || record->epoch < input->burn_in_epochs)
        return NOT_IN_MATRIX;
    return place_of(summing, record->view, "train");
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
    matrix->psnr[entry] += gain_psnr;
    matrix->l1[entry] += gain_l1;
    matrix->visit_count += !summing->counted || summing->step != step;
    summing->counted = true;
    summing->step = step;
}

static void number_images(struct summing *summing) {
    const struct vw_value_input *input = summing->input;
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
    matrix->l1 = vw_allocate((size_t)matrix->photo_count * matrix->view_count, sizeof *matrix->l1);
    matrix->end_psnr = summing->last_psnr = vw_allocate(matrix->view_count, sizeof *summing->last_psnr);
    summing->last_l1 = vw_allocate(matrix->view_count, sizeof *summing->last_l1);
    if (!matrix->psnr || !matrix->l1 || !summing->last_psnr || !summing->last_l1) return VW_ERROR_MEMORY;
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
    free(matrix->l1);
    free(matrix->lasting);
    free(matrix->end_psnr);
    free(matrix->weights);
    *matrix = (struct vw_matrix){0};
}
