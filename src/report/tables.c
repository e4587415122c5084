#include "report/tables.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/rows.h"
#include "ledger/find_image.h"

// ---- Scores --------------------------------------------------------------------------------------------------------

// A score with its image, and what sorts it.
struct score_row {
    const struct vw_ledger_score *score;
    const struct vw_ledger_image *image;
    uint32_t method_order; // the place of the method's first score
    uint32_t rank;
};

#define OF_IMAGE(name, kind, member)                                                                                   \
    { VW_CELL_VIA(name, struct score_row, image, kind, struct vw_ledger_image, member) }
#define OF_SCORE(name, kind, member)                                                                                   \
    { VW_CELL_VIA(name, struct score_row, score, kind, struct vw_ledger_score, member) }
static const struct vw_column score_columns[] = {
    OF_IMAGE("name", TEXT, name),
    OF_IMAGE("provider", TEXT, provider),
    OF_SCORE("method", TEXT, method),
    OF_SCORE("value", REAL_OR_NULL, value),
    OF_SCORE("unit", TEXT, unit),
    OF_SCORE("stderr", REAL_OR_NULL, standard_error),
    OF_SCORE("visits", COUNT, visits),
    {VW_CELL("rank", struct score_row, COUNT, rank)},
    OF_SCORE("ci_low", REAL_OR_NULL, ci_low),
    OF_SCORE("ci_high", REAL_OR_NULL, ci_high),
    OF_SCORE("rank_ci_low", RANK, rank_ci_low),
    OF_SCORE("rank_ci_high", RANK, rank_ci_high),
};

static int compare_rows(const void *left, const void *right) {
    const struct score_row *a = left, *b = right;
    if (a->method_order != b->method_order) return a->method_order < b->method_order ? -1 : 1;
    if (a->score->value != b->score->value) return a->score->value > b->score->value ? -1 : 1;
    return strcmp(a->image->name, b->image->name);
}

// Sorts the rows, which the caller owns, also after a failure.
static enum vw_status sort_scores(const char *path, const struct vw_ledger_score *scores, uint32_t count,
                                  const struct vw_ledger_image *images, uint32_t image_count, struct vw_rows *rows) {
    struct score_row *sorted = vw_allocate(count, sizeof *sorted);
    *rows = VW_ROWS(score_columns, sorted, count);
    if (!sorted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) {
        enum vw_status status = vw_ledger_require_image(images, image_count, scores[i].image_id, &sorted[i].image);
        if (status) return vw_fail_context(status, "%s: scores", path);
        bool goes_on = i > 0 && strcmp(scores[i].method, scores[i - 1].method) == 0;
        sorted[i].score = &scores[i];
        sorted[i].method_order = goes_on ? sorted[i - 1].method_order : i;
    }
    qsort(sorted, count, sizeof *sorted, compare_rows);
    for (uint32_t i = 0; i < count; i++) sorted[i].rank = i - sorted[i].method_order + 1;
    return VW_OK;
}

enum vw_status vw_report_make_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_csv_text *made) {
    struct vw_rows rows;
    enum vw_status status = sort_scores(path, scores, score_count, images, image_count, &rows);
    if (!status) status = vw_rows_make_csv(path, &rows, made);
    free((void *)rows.rows);
    return status;
}

void vw_report_print_csv_header(FILE *stream) {
    vw_rows_print_header(stream, &VW_ROWS(score_columns, (const struct score_row *)NULL, 0));
}

enum vw_status vw_report_print_csv_rows(FILE *stream, const char *path, const char *before,
                                        const struct vw_ledger_score *scores, uint32_t score_count,
                                        const struct vw_ledger_image *images, uint32_t image_count) {
    struct vw_rows rows;
    enum vw_status status = sort_scores(path, scores, score_count, images, image_count, &rows);
    if (!status) vw_rows_print(stream, &rows, before);
    free((void *)rows.rows);
    return status;
}

// ---- Providers, duplicates -----------------------------------------------------------------------------------------

static const struct vw_column provider_columns[] = {
    {VW_CELL("provider", struct vw_provider_score, TEXT, provider)},
    {VW_CELL("method", struct vw_provider_score, TEXT, method)},
    {VW_CELL("value", struct vw_provider_score, REAL_OR_NULL, value)},
    {VW_CELL("unit", struct vw_provider_score, TEXT, unit)},
    {VW_CELL("stderr", struct vw_provider_score, REAL_OR_NULL, standard_error)},
    {VW_CELL("photos", struct vw_provider_score, COUNT, photo_count)},
    {VW_CELL("rank", struct vw_provider_score, COUNT, rank), .left_out = VW_NOT_IN_JSON},
};

struct vw_rows vw_provider_rows(const struct vw_provider_score *groups, uint32_t count) {
    return VW_ROWS(provider_columns, groups, count);
}

#define OF_COPY(name, kind, member)                                                                                    \
    { VW_CELL(name, struct vw_duplicate_score, kind, member) }
#define OF_COPY_IMAGE(name, kind, member)                                                                              \
    { VW_CELL_VIA(name, struct vw_duplicate_score, image, kind, struct vw_ledger_image, member) }
#define OF_COPY_SCORE(name, kind, member, left)                                                                        \
    { VW_CELL_VIA(name, struct vw_duplicate_score, score, kind, struct vw_ledger_score, member), .left_out = left }
static const struct vw_column duplicate_columns[] = {
    OF_COPY("group", COUNT, group),
    OF_COPY_IMAGE("name", TEXT, name),
    OF_COPY_IMAGE("split", TEXT, split),
    OF_COPY_IMAGE("provider", TEXT, provider),
    OF_COPY("similarity", REAL_OR_NULL, similarity),
    OF_COPY_SCORE("method", TEXT, method, VW_NOT_IN_JSON),
    OF_COPY_SCORE("value", REAL_OR_NULL, value, 0),
    OF_COPY_SCORE("unit", TEXT, unit, VW_NOT_IN_JSON),
    OF_COPY_SCORE("stderr", REAL_OR_NULL, standard_error, VW_NOT_IN_JSON),
    OF_COPY("group_value", REAL_OR_NULL, group_value),
    {VW_CELL("providers", struct vw_duplicate_score, COUNT, provider_count), .left_out = VW_NOT_IN_CSV},
};

struct vw_rows vw_duplicate_rows(const struct vw_duplicate_score *duplicates, uint32_t count) {
    return VW_ROWS(duplicate_columns, duplicates, count);
}

// ---- Accuracy of worth ---------------------------------------------------------------------------------------------

#define OF_CLAIM(name, kind, member, heading)                                                                          \
    { VW_CELL(name, struct vw_worth_claim, kind, member), .title = heading, .digits = 2, .has_sign = true }
static const struct vw_column claim_columns[] = {
    OF_CLAIM("spearman", REAL_OR_NULL, accuracy.spearman, "Spearman"),
    OF_CLAIM("ci_low", REAL_OR_NULL, accuracy.ci_low, "95 % from"),
    OF_CLAIM("ci_high", REAL_OR_NULL, accuracy.ci_high, "to"),
    OF_CLAIM("r2", REAL_OR_NULL, accuracy.r2, "R^2"),
    OF_CLAIM("retrainings", COUNT, accuracy.count, NULL),
    OF_CLAIM("method", TEXT, method, "method"),
};

struct vw_rows vw_claim_rows(const struct vw_worth_summary *summary) {
    return VW_ROWS(claim_columns, summary->claims, summary->claim_count);
}

// ---- Payouts -------------------------------------------------------------------------------------------------------

#define OF_SHARE(row)                                                                                                  \
    {VW_CELL("share", row, REAL_OR_NULL, share)}, {VW_CELL("amount", row, CENTS, cents), .title = "payout"},           \
        {VW_CELL("cents", row, COUNT64, cents), .left_out = VW_NOT_IN_CSV},                                            \
        {VW_CELL("ci_low", row, CENTS_OR_NULL, interval.low_cents), .left_out = VW_NOT_IN_JSON, .title = "90 % from"}, \
        {VW_CELL("ci_high", row, CENTS_OR_NULL, interval.high_cents), .left_out = VW_NOT_IN_JSON, .title = "to"},      \
        {VW_CELL("ci_low_cents", row, REAL_OR_NULL, interval.low_cents), .left_out = VW_NOT_IN_CSV}, {                 \
        VW_CELL("ci_high_cents", row, REAL_OR_NULL, interval.high_cents), .left_out = VW_NOT_IN_CSV                    \
    }

static const struct vw_column payout_columns[] = {
    {VW_CELL("provider", struct vw_payout, TEXT, provider), .title = "provider"},
    {VW_CELL("value", struct vw_payout, REAL, value), .title = "worth, dB", .digits = 2},
    {VW_CELL("photos", struct vw_payout, COUNT, photo_count), .title = "photos"},
    OF_SHARE(struct vw_payout),
    {VW_CELL("unvalued", struct vw_payout, COUNT, unvalued_count), .title = "unvalued"},
};

struct vw_rows vw_payout_rows(const struct vw_payouts *payouts) {
    return VW_ROWS(payout_columns, payouts->providers, payouts->provider_count);
}

#define OF_PAID(name, pointer, kind, to, member)                                                                       \
    { VW_CELL_VIA(name, struct vw_photo_payout, pointer, kind, to, member) }
static const struct vw_column photo_payout_columns[] = {
    OF_PAID("name", image, TEXT, struct vw_ledger_image, name),
    OF_PAID("provider", image, TEXT, struct vw_ledger_image, provider),
    OF_PAID("value", score, REAL, struct vw_ledger_score, value),
    OF_SHARE(struct vw_photo_payout),
};

struct vw_rows vw_photo_payout_rows(const struct vw_payouts *payouts) {
    return VW_ROWS(photo_payout_columns, payouts->photos, payouts->photo_count);
}

// ---- The matrix ----------------------------------------------------------------------------------------------------

// Averages the known entries of a row by the weights of the views.
static double mean_of(const struct vw_matrix *matrix, const double *row) {
    double mean = 0, known = 0;
    for (uint32_t i = 0; i < matrix->view_count; i++) known += isnan(row[i]) ? 0 : vw_matrix_weight(matrix, i);
    for (uint32_t i = 0; i < matrix->view_count; i++)
        mean += isnan(row[i]) ? 0 : vw_matrix_weight(matrix, i) * row[i] / known;
    return known > 0 ? mean : NAN;
}

struct matrix_table {
    const struct vw_matrix *matrix;
    const double *standard_errors;
    const struct vw_ledger_image *images;
    uint32_t image_count;
};

static void print_matrix_row(FILE *stream, const struct vw_ledger_image *photo, const char *measure, const char *unit,
                             const double *row, uint32_t view_count, double mean, double standard_error) {
    vw_csv_print(stream, "t,t,t,t,r,r", photo->name, photo->provider, measure, unit, mean, standard_error);
    for (uint32_t v = 0; v < view_count; v++) vw_csv_print(stream, ",r", row[v]);
    fputc('\n', stream);
}

static void print_matrix(FILE *stream, const void *context) {
    const struct matrix_table *table = context;
    const struct vw_matrix *matrix = table->matrix;
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
    return vw_csv_make_text(path, print_matrix, &(struct matrix_table){matrix, standard_errors, images, image_count},
                            made);
}
