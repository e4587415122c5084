// The scores of several runs on the same photos side by side, method by method, from the first epochs of their ledgers.
#ifndef VIEWWORTH_VALUE_EVALUATION_SCORE_TABLES_H
#define VIEWWORTH_VALUE_EVALUATION_SCORE_TABLES_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/value.h"

struct vw_score_table {
    const char *method, *unit; // borrowed
    bool has_zero;             // the sign of a value has a meaning
    double *values; // owned; [run * photo_count + photo]; NaN where the run has no such score, or no visit that counts
                    // into it
    double *ci_low, *ci_high; // within the allocation of values; 95 % intervals, NaN where unknown
};

struct vw_score_tables {
    uint32_t run_count, photo_count;
    uint32_t *photos;              // owned: the train photos, as indices in the images of every run, ascending
    uint32_t *photo_of_image;      // owned: the other way round; UINT32_MAX for one that is not trained on
    bool *clean;                   // owned: by photo; NULL without ground-truth labels
    struct vw_score_table *tables; // owned: the methods that any run has, in the order in which they are found
    uint32_t count;
    size_t capacity; // room for tables
};

// Scores the first `epochs` epochs of every run (burn-in among them), as if the runs had ended there. VW_ERROR_INPUT
// when the runs are not on the same photos. Free it also after a failure.
enum vw_status vw_score_tables_make(const struct vw_value_input *runs, uint32_t run_count, uint32_t epochs,
                                    struct vw_score_tables *tables);
// Adds one of these names and has_zero, with all values NaN; NULL when memory is short.
struct vw_score_table *vw_score_tables_add(struct vw_score_tables *tables, const struct vw_score_table *table);
void vw_score_tables_free(struct vw_score_tables *tables);
// Returns NULL when no run has that method.
const struct vw_score_table *vw_score_tables_find(const struct vw_score_tables *tables, const char *method);

// Returns the run as it was after its first `epochs` epochs.
struct vw_value_input vw_value_input_truncate(const struct vw_value_input *run, uint32_t epochs);

#endif
