#include "value/evaluation/score_tables.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"

struct vw_value_input vw_value_input_truncate(const struct vw_value_input *run, uint32_t epochs) {
    struct vw_value_input first = *run;
    first.record_count = 0;
    while (first.record_count < run->record_count && run->records[first.record_count].epoch < epochs)
        first.record_count++;
    return first;
}

// ---- Photos --------------------------------------------------------------------------------------------------------

static bool same_photos(const struct vw_value_input *a, const struct vw_value_input *b) {
    if (a->image_count != b->image_count) return false;
    for (uint32_t i = 0; i < a->image_count; i++)
        if (a->images[i].image_id != b->images[i].image_id || strcmp(a->images[i].name, b->images[i].name) != 0 ||
            strcmp(a->images[i].split, b->images[i].split) != 0)
            return false;
    return true;
}

static enum vw_status list_photos(const struct vw_value_input *run, struct vw_score_tables *tables) {
    bool ground_truth_known = false;
    tables->photos = vw_allocate(run->image_count, sizeof *tables->photos);
    tables->clean = vw_allocate(run->image_count, sizeof *tables->clean);
    tables->photo_of_image = vw_allocate(run->image_count, sizeof *tables->photo_of_image);
    if (!tables->photos || !tables->clean || !tables->photo_of_image) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < run->image_count; i++) {
        const struct vw_ledger_image *image = &run->images[i];
        bool trained = strcmp(image->split, "train") == 0;
        tables->photo_of_image[i] = trained ? tables->photo_count : UINT32_MAX;
        if (!trained) continue;
        ground_truth_known |= image->ground_truth != NULL;
        tables->clean[tables->photo_count] = image->ground_truth && strcmp(image->ground_truth, "clean") == 0;
        tables->photos[tables->photo_count++] = i;
    }
    if (ground_truth_known) return VW_OK;
    free(tables->clean);
    tables->clean = NULL;
    return VW_OK;
}

// ---- Scores --------------------------------------------------------------------------------------------------------

static struct vw_score_table *find(const struct vw_score_tables *tables, const char *method) {
    for (uint32_t i = 0; i < tables->count; i++)
        if (strcmp(tables->tables[i].method, method) == 0) return &tables->tables[i];
    return NULL;
}

const struct vw_score_table *vw_score_tables_find(const struct vw_score_tables *tables, const char *method) {
    return find(tables, method);
}

struct vw_score_table *vw_score_tables_add(struct vw_score_tables *tables, const struct vw_score_table *table) {
    size_t value_count = (size_t)tables->run_count * tables->photo_count, needed = tables->count + (size_t)1;
    if (vw_grow((void **)&tables->tables, &tables->capacity, needed, sizeof *tables->tables)) return NULL;
    struct vw_score_table *added = &tables->tables[tables->count];
    *added = *table;
    added->values = vw_allocate(value_count, 3 * sizeof(double));
    if (!added->values) return NULL;
    for (size_t i = 0; i < 3 * value_count; i++) added->values[i] = NAN;
    added->ci_low = added->values + value_count;
    added->ci_high = added->ci_low + value_count;
    tables->count++;
    return added;
}

static enum vw_status add_table(struct vw_score_tables *tables, const struct vw_ledger_score *score) {
    const struct vw_value_method *about = vw_value_method_find(score->method);
    const struct vw_score_table table = {score->method, score->unit, .has_zero = !about || about->has_zero};
    return vw_score_tables_add(tables, &table) ? VW_OK : VW_ERROR_MEMORY;
}

static void place(const struct vw_value_input *run, uint32_t run_index, const struct vw_ledger_score *score,
                  const struct vw_score_tables *tables, struct vw_score_table *table) {
    const struct vw_ledger_image *image = vw_ledger_find_image(run->images, run->image_count, score->image_id);
    uint32_t photo = image ? tables->photo_of_image[image - run->images] : UINT32_MAX;
    size_t entry = (size_t)run_index * tables->photo_count + photo;
    if (photo >= tables->photo_count || !score->visits) return;
    table->values[entry] = score->value;
    table->ci_low[entry] = score->ci_low;
    table->ci_high[entry] = score->ci_high;
}

static enum vw_status add_run(const struct vw_value_input *run, uint32_t run_index, struct vw_score_tables *tables) {
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    enum vw_status status = vw_value_score(run, &scores, &score_count);
    for (uint32_t i = 0; i < score_count && !status; i++) {
        if (!find(tables, scores[i].method)) status = add_table(tables, &scores[i]);
        if (!status) place(run, run_index, &scores[i], tables, find(tables, scores[i].method));
    }
    free(scores);
    return status;
}

enum vw_status vw_score_tables_make(const struct vw_value_input *runs, uint32_t run_count, uint32_t epochs,
                                    struct vw_score_tables *tables) {
    *tables = (struct vw_score_tables){.run_count = run_count};
    enum vw_status status = run_count ? list_photos(&runs[0], tables) : VW_OK;
    for (uint32_t i = 0; i < run_count && !status; i++) {
        struct vw_value_input first = vw_value_input_truncate(&runs[i], epochs);
        if (!same_photos(&runs[0], &runs[i]))
            status = vw_fail(VW_ERROR_INPUT, "run %u is not on the photos of the first one; compare runs of one scene",
                             i + 1);
        else status = add_run(&first, i, tables);
    }
    return status;
}

void vw_score_tables_free(struct vw_score_tables *tables) {
    for (uint32_t i = 0; i < tables->count; i++) free(tables->tables[i].values);
    free(tables->tables);
    free(tables->photos);
    free(tables->photo_of_image);
    free(tables->clean);
}
