#include "report/page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "ledger/find_image.h"

// A score with its image, and what sorts it.
struct row {
    const struct vw_ledger_score *score;
    const struct vw_ledger_image *image;
    uint32_t method_order; // the place of the method's first score
};

static int compare_rows(const void *left, const void *right) {
    const struct row *a = left, *b = right;
    if (a->method_order != b->method_order) return a->method_order < b->method_order ? -1 : 1;
    if (a->score->value != b->score->value) return a->score->value > b->score->value ? -1 : 1;
    return strcmp(a->image->name, b->image->name);
}

static enum vw_status collect_rows(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count, struct row *rows) {
    for (uint32_t i = 0; i < score_count; i++) {
        const struct vw_ledger_image *image = NULL;
        enum vw_status status = vw_ledger_require_image(images, image_count, scores[i].image_id, &image);
        if (status) return vw_fail_context(status, "%s: scores", path);
        uint32_t first = i > 0 && strcmp(scores[i].method, scores[i - 1].method) == 0 ? rows[i - 1].method_order : i;
        rows[i] = (struct row){.score = &scores[i], .image = image, .method_order = first};
    }
    return VW_OK;
}

// Prints a further field; an empty one for 0.
static void print_rank(FILE *stream, uint32_t rank) { vw_csv_print(stream, rank ? ",u" : ",", rank); }

static void print_row(FILE *stream, const struct row *row, uint32_t rank) {
    const struct vw_ledger_score *score = row->score;
    vw_csv_print(stream, "t,t,t,r,t,r,u,u,r,r", row->image->name, row->image->provider, score->method, score->value,
                 score->unit, score->standard_error, score->visits, rank, score->ci_low, score->ci_high);
    print_rank(stream, score->rank_ci_low);
    print_rank(stream, score->rank_ci_high);
    fputc('\n', stream);
}

struct table {
    const struct row *rows;
    uint32_t count;
    const char *before; // fields that every row begins with, each with its comma
};

const char vw_report_csv_header[] = "name,provider,method,value,unit,stderr,visits,rank,ci_low,ci_high,rank_ci_low,"
                                    "rank_ci_high\n";

static void print_rows(FILE *stream, const struct table *table) {
    for (uint32_t i = 0; i < table->count; i++) {
        fputs(table->before, stream);
        print_row(stream, &table->rows[i], i - table->rows[i].method_order + 1);
    }
}

static void print_table(FILE *stream, const void *context) {
    fputs(vw_report_csv_header, stream);
    print_rows(stream, context);
}

// Sorts the rows; `*rows` is owned by the caller.
static enum vw_status sort_rows(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                const struct vw_ledger_image *images, uint32_t image_count, struct row **rows) {
    struct row *sorted = vw_allocate(score_count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    enum vw_status status = collect_rows(path, scores, score_count, images, image_count, sorted);
    if (status) {
        free(sorted);
        return status;
    }
    qsort(sorted, score_count, sizeof *sorted, compare_rows);
    *rows = sorted;
    return VW_OK;
}

enum vw_status vw_report_make_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count,
                                  struct vw_csv_text *made) {
    struct row *rows = NULL;
    enum vw_status status = sort_rows(path, scores, score_count, images, image_count, &rows);
    if (!status) status = vw_csv_make_text(path, print_table, &(struct table){rows, score_count, ""}, made);
    free(rows);
    return status;
}

enum vw_status vw_report_print_csv_rows(FILE *stream, const char *path, const char *before,
                                        const struct vw_ledger_score *scores, uint32_t score_count,
                                        const struct vw_ledger_image *images, uint32_t image_count) {
    struct row *rows = NULL;
    enum vw_status status = sort_rows(path, scores, score_count, images, image_count, &rows);
    if (!status) print_rows(stream, &(struct table){rows, score_count, before});
    free(rows);
    return status;
}

enum vw_status vw_report_write_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count) {
    struct vw_csv_text text = {0};
    enum vw_status status = vw_report_make_csv(path, scores, score_count, images, image_count, &text);
    if (!status) status = vw_file_write(path, text.text, text.size_bytes);
    free(text.text);
    return status;
}
