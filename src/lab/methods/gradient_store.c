#include "lab/methods/gradient_store.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/csv.h"
#include "base/file.h"
#include "base/memory.h"
#include "viewworth/log.h"

enum { RUN_ID, STEPS, METHOD, IMAGE_ID, SCORE, CPU_SECONDS, COLUMNS };
static const char *const columns[COLUMNS] = {"run_id", "steps", "method", "image_id", "score", "cpu_seconds"};
static const size_t BYTES_MAX = 1 << 24;

static bool read_real(const char *text, double *value) {
    char *end;
    *value = *text ? strtod(text, &end) : (double)NAN;
    return !*text || (!*end && end != text && isfinite(*value));
}

static bool is_number(const char *text, uint64_t number) {
    char expected[24];
    snprintf(expected, sizeof expected, "%" PRIu64, number);
    return strcmp(text, expected) == 0;
}

// Reads a row. `found` counts the photos of each method: they are in order, each once.
static enum vw_status read_row(const struct vw_csv *csv, struct vw_gradient_store *store,
                               uint32_t found[VW_GRADIENT_METHODS]) {
    double score, seconds;
    uint32_t method = 0;
    if (csv->field_count != COLUMNS || !read_real(csv->fields[SCORE], &score) ||
        !read_real(csv->fields[CPU_SECONDS], &seconds))
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: is not a row of scores; remove the file, and the scores are computed again", store->path,
                       csv->line);
    while (method < VW_GRADIENT_METHODS && strcmp(vw_gradient_methods[method].name, csv->fields[METHOD]) != 0) method++;
    bool of_run = strcmp(csv->fields[RUN_ID], store->run_id) == 0 && is_number(csv->fields[STEPS], store->steps);
    if (method == VW_GRADIENT_METHODS || !of_run) return VW_OK; // another version's, or another run's
    if (found[method] == store->photo_count || !is_number(csv->fields[IMAGE_ID], store->photos[found[method]]))
        return vw_fail(VW_ERROR_INPUT,
                       "%s:%u: is not the row of the next photo; remove the file, and the scores are computed again",
                       store->path, csv->line);
    store->scores[method][found[method]++] = score;
    store->seconds[method] = seconds;
    return VW_OK;
}

static enum vw_status read_rows(struct vw_csv *csv, struct vw_gradient_store *store) {
    uint32_t found[VW_GRADIENT_METHODS] = {0};
    bool more = false;
    enum vw_status status = vw_csv_next(csv, &more);
    bool same = !status && more && csv->field_count == COLUMNS;
    for (uint32_t i = 0; i < COLUMNS && same; i++) same = strcmp(csv->fields[i], columns[i]) == 0;
    if (!status && !same)
        status = vw_fail(VW_ERROR_INPUT, "%s: is not a table of scores from gradients; remove the file", store->path);
    while (!status && !(status = vw_csv_next(csv, &more)) && more) status = read_row(csv, store, found);
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS && !status; m++) store->known[m] = found[m] == store->photo_count;
    return status;
}

enum vw_status vw_gradient_store_open(struct vw_gradient_store *store) {
    struct vw_csv csv = {0};
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++) {
        store->known[m] = false;
        store->seconds[m] = NAN;
        store->scores[m] = vw_allocate(store->photo_count, sizeof *store->scores[m]);
        if (!store->scores[m]) return VW_ERROR_MEMORY;
    }
    if (!store->path || !vw_file_exists(store->path)) return VW_OK;
    enum vw_status status = vw_csv_open(store->path, BYTES_MAX, &csv);
    if (!status) status = read_rows(&csv, store);
    vw_csv_close(&csv);
    if (status != VW_ERROR_INPUT) return status;
    vw_log_warning("%s", vw_error_message());
    return VW_OK;
}

static void print_rows(FILE *stream, const void *context) {
    const struct vw_gradient_store *store = context;
    for (uint32_t i = 0; i < COLUMNS; i++) fprintf(stream, "%s%s", i ? "," : "", columns[i]);
    fputc('\n', stream);
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++)
        for (uint32_t i = 0; i < store->photo_count && store->known[m]; i++) {
            fprintf(stream, "%s,%" PRIu64 ",%s,%u,", store->run_id, store->steps, vw_gradient_methods[m].name,
                    store->photos[i]);
            vw_csv_write_real(stream, store->scores[m][i]);
            fputc(',', stream);
            vw_csv_write_real(stream, store->seconds[m]);
            fputc('\n', stream);
        }
}

enum vw_status vw_gradient_store_save(const struct vw_gradient_store *store) {
    return store->path ? vw_csv_write_file(store->path, print_rows, store) : VW_OK;
}

void vw_gradient_store_free(struct vw_gradient_store *store) {
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++) {
        free(store->scores[m]);
        store->scores[m] = NULL;
    }
}
