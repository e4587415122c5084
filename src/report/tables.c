#include "report/tables.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "ledger/find_image.h"

// The rows of a table, and what else it takes to print them.
struct table {
    const void *rows;
    uint32_t count;
    const double *standard_errors;
    const struct vw_ledger_image *images;
    uint32_t image_count;
};

void vw_amount_to_text(uint64_t cents, char text[VW_AMOUNT_BYTES]) {
    snprintf(text, VW_AMOUNT_BYTES, "%" PRIu64 ".%02" PRIu64, cents / 100, cents % 100);
}

static void print_providers(FILE *stream, const void *context) {
    const struct table *table = context;
    const struct vw_provider_score *groups = table->rows;
    uint32_t rank = 0;
    fputs("provider,method,value,unit,stderr,photos,rank\n", stream);
    for (uint32_t i = 0; i < table->count; i++) {
        rank = i > 0 && strcmp(groups[i].method, groups[i - 1].method) == 0 ? rank + 1 : 1;
        vw_csv_print(stream, "t,t,r,t,r,u,u\n", groups[i].provider, groups[i].method, groups[i].value, groups[i].unit,
                     groups[i].standard_error, groups[i].photo_count, rank);
    }
}

enum vw_status vw_table_make_providers(const char *path, const struct vw_provider_score *groups, uint32_t count,
                                       struct vw_csv_text *made) {
    return vw_csv_make_text(path, print_providers, &(struct table){.rows = groups, .count = count}, made);
}

void vw_amount_range_to_text(struct vw_payout_interval interval, char low[VW_AMOUNT_BYTES],
                             char high[VW_AMOUNT_BYTES]) {
    low[0] = high[0] = 0;
    if (!isfinite(interval.low_cents) || !isfinite(interval.high_cents)) return;
    snprintf(low, VW_AMOUNT_BYTES, "%.2f", interval.low_cents / 100);
    snprintf(high, VW_AMOUNT_BYTES, "%.2f", interval.high_cents / 100);
}

static void print_amounts(FILE *stream, double share, uint64_t cents, struct vw_payout_interval interval) {
    char amount[VW_AMOUNT_BYTES], low[VW_AMOUNT_BYTES], high[VW_AMOUNT_BYTES];
    vw_amount_to_text(cents, amount);
    vw_amount_range_to_text(interval, low, high);
    vw_csv_print(stream, "r,t,t,t", share, amount, low, high);
}

static void print_payout(FILE *stream, const void *context) {
    const struct vw_payouts *payouts = context;
    const struct vw_ledger_score *score = payouts->photos[0].score; // there is one at least
    fputs("provider,method,value,unit,photos,share,amount,ci_low,ci_high,overlaps,validating,tests,unscored\n", stream);
    for (uint32_t i = 0; i < payouts->provider_count; i++) {
        const struct vw_payout *payout = &payouts->providers[i];
        vw_csv_print(stream, "t,t,r,t,u,", payout->provider, score->method, payout->value, score->unit,
                     payout->photo_count);
        print_amounts(stream, payout->share, payout->cents, payout->interval);
        vw_csv_print(stream, ",u,u,u,u\n", payout->alike_count, payout->validating_count, payout->test_count,
                     payout->unscored_count);
    }
}

enum vw_status vw_table_make_payout(const char *path, const struct vw_payouts *payouts, struct vw_csv_text *made) {
    return vw_csv_make_text(path, print_payout, payouts, made);
}

static void print_payout_photos(FILE *stream, const void *context) {
    const struct vw_payouts *payouts = context;
    fputs("name,provider,method,value,unit,share,amount,ci_low,ci_high\n", stream);
    for (uint32_t i = 0; i < payouts->photo_count; i++) {
        const struct vw_photo_payout *photo = &payouts->photos[i];
        vw_csv_print(stream, "t,t,t,r,t,", photo->image->name, photo->image->provider, photo->score->method,
                     photo->score->value, photo->score->unit);
        print_amounts(stream, photo->share, photo->cents, photo->interval);
        fputc('\n', stream);
    }
}

enum vw_status vw_table_make_payout_photos(const char *path, const struct vw_payouts *payouts,
                                           struct vw_csv_text *made) {
    return vw_csv_make_text(path, print_payout_photos, payouts, made);
}

static void print_duplicates(FILE *stream, const void *context) {
    const struct table *table = context;
    const struct vw_duplicate_score *rows = table->rows;
    fputs("group,name,split,provider,similarity,method,value,unit,stderr,group_value\n", stream);
    for (uint32_t i = 0; i < table->count; i++) {
        const struct vw_ledger_score *score = rows[i].score;
        vw_csv_print(stream, "u,t,t,t,r,", rows[i].group, rows[i].image->name, rows[i].image->split,
                     rows[i].image->provider, rows[i].similarity);
        if (score) vw_csv_print(stream, "t,r,t,r,", score->method, score->value, score->unit, score->standard_error);
        else fputs(",,,,", stream);
        vw_csv_print(stream, "r\n", rows[i].group_value);
    }
}

enum vw_status vw_table_make_duplicates(const char *path, const struct vw_duplicate_score *rows, uint32_t count,
                                        struct vw_csv_text *made) {
    return vw_csv_make_text(path, print_duplicates, &(struct table){.rows = rows, .count = count}, made);
}

// ---- The matrix ----------------------------------------------------------------------------------------------------

// Averages a row by the weights of the views; over folds, a photo has no entry for the views that validated while it
// did.
static double mean_of(const struct vw_matrix *matrix, const double *row) {
    double mean = 0, known = 0;
    for (uint32_t i = 0; i < matrix->view_count; i++) known += isnan(row[i]) ? 0 : vw_matrix_weight(matrix, i);
    for (uint32_t i = 0; i < matrix->view_count; i++)
        mean += isnan(row[i]) ? 0 : vw_matrix_weight(matrix, i) * row[i] / known;
    return known > 0 ? mean : NAN;
}

static void print_matrix_row(FILE *stream, const struct vw_ledger_image *photo, const char *measure, const char *unit,
                             const double *row, uint32_t view_count, double mean, double standard_error) {
    vw_csv_print(stream, "t,t,t,t,r,r", photo->name, photo->provider, measure, unit, mean, standard_error);
    for (uint32_t v = 0; v < view_count; v++) vw_csv_print(stream, ",r", row[v]);
    fputc('\n', stream);
}

static void print_matrix(FILE *stream, const void *context) {
    const struct table *table = context;
    const struct vw_matrix *matrix = table->rows;
    fputs("name,provider,measure,unit,mean,jackknife_stderr", stream);
    for (uint32_t v = 0; v < matrix->view_count; v++)
        vw_csv_print(stream, ",t", vw_ledger_find_image(table->images, table->image_count, matrix->views[v])->name);
    fputc('\n', stream);
    for (uint32_t p = 0; p < matrix->photo_count; p++) {
        const struct vw_ledger_image *photo =
            vw_ledger_find_image(table->images, table->image_count, matrix->photos[p]);
        size_t first = (size_t)p * matrix->view_count;
        print_matrix_row(stream, photo, "dv_psnr", "dB", &matrix->psnr[first], matrix->view_count,
                         mean_of(matrix, &matrix->psnr[first]), table->standard_errors[p]);
        print_matrix_row(stream, photo, "dv_loss", "mean absolute error", &matrix->l1[first], matrix->view_count, NAN,
                         NAN);
        if (matrix->lasting)
            print_matrix_row(stream, photo, "lasting_psnr", "dB", &matrix->lasting[first], matrix->view_count,
                             mean_of(matrix, &matrix->lasting[first]), NAN);
    }
}

static enum vw_status require_all(const struct vw_ledger_image *images, uint32_t image_count, const uint32_t *image_ids,
                                  uint32_t count) {
    const struct vw_ledger_image *image = NULL;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < count; i++)
        status = vw_ledger_require_image(images, image_count, image_ids[i], &image);
    return status;
}

enum vw_status vw_table_make_matrix(const char *path, const struct vw_matrix *matrix, const double *standard_errors,
                                    const struct vw_ledger_image *images, uint32_t image_count,
                                    struct vw_csv_text *made) {
    enum vw_status status = require_all(images, image_count, matrix->photos, matrix->photo_count);
    if (!status) status = require_all(images, image_count, matrix->views, matrix->view_count);
    if (status) return vw_fail_context(status, "%s", path);
    return vw_csv_make_text(path, print_matrix, &(struct table){matrix, 0, standard_errors, images, image_count}, made);
}

enum vw_status vw_table_write_matrix(const char *path, const struct vw_matrix *matrix, const double *standard_errors,
                                     const struct vw_ledger_image *images, uint32_t image_count) {
    struct vw_csv_text text = {0};
    enum vw_status status = vw_table_make_matrix(path, matrix, standard_errors, images, image_count, &text);
    if (!status) status = vw_file_write(path, text.text, text.size_bytes);
    free(text.text);
    return status;
}
