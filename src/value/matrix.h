// The matrix of train photos and validation views: what each photo did for each view, and how much the ranking depends
// on the choice of the views.
#ifndef VIEWWORTH_VALUE_MATRIX_H
#define VIEWWORTH_VALUE_MATRIX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_value_input; // value.h

enum { VW_MATRIX_BLOCKS = 8 }; // blocks of neighbouring epochs after burn-in, of the same length but for rounding

// Rows are train photos, columns validation views, both in image order; entry (photo, view) is at photo * view_count +
// view. Owned arrays.
struct vw_matrix {
    uint32_t *photos, *views; // image_ids
    uint32_t photo_count, view_count;
    double *psnr;    // dB: sum of the step deltas of the view's PSNR (its MSE floored as usual); the weighted mean of a
                     // row is the photo's dv_psnr
    double *l1;      // mean absolute error removed from the view; the mean of a row, weighted by the views' pixels and
                     // weights, is the photo's dv_loss
    double *lasting; // dB: what the photo's steps leave of the view's PSNR at the end; the weighted mean of a row is
                     // the photo's lasting_psnr, but for rounding. NULL: the run has no such pass
    double *end_psnr;     // dB: PSNR of each view after the last validated step
    uint32_t visit_count; // steps that count, over all photos
    double *weights;      // the views' weights in the means of rows; NULL: all 1
    double *blocks;       // dB: psnr of one block of epochs after another; NULL: fewer records than photos
    uint32_t visits_of_block[VW_MATRIX_BLOCKS];
};

static inline double vw_matrix_weight(const struct vw_matrix *matrix, uint32_t view) {
    return matrix->weights ? matrix->weights[view] : 1;
}

// Returns the entries of a block, as those of psnr.
static inline const double *vw_matrix_block(const struct vw_matrix *matrix, uint32_t block) {
    return matrix->blocks + (size_t)block * matrix->photo_count * matrix->view_count;
}

// Computes the matrix from the table view, as scores are computed: deltas from the last step with values, summed over
// the steps after burn-in. A run without view rows (imported, or not validated) has 0 views; a run without a step after
// burn-in has zeros and visit_count 0. Lasting credit counts the steps of burn-in as well. Clear the matrix also after
// a failure.
enum vw_status vw_value_matrix(struct vw_ledger *ledger, const struct vw_value_input *input, struct vw_matrix *matrix);
void vw_matrix_clear(struct vw_matrix *matrix);

// The evidence of the matrix about one validation view.
struct vw_view_evidence {
    uint32_t image_id;
    double end_psnr;
    double
        agreement;  // Spearman's correlation, over the photos, of its column with the mean of the others; NaN: unknown
    double without; // Spearman's correlation of the ranking without this view with the ranking with it; NaN: unknown
    bool disagrees; // its column differs from the others, far more than they differ from each other, and its PSNR ends
                    // below theirs: it looks corrupted
    bool lone;      // its column differs, but its PSNR is ordinary: it sees what no other view sees
    bool stays_low; // its PSNR stays far below that of the others: it looks corrupted
};

// Computes the jackknife over validation views, from the PSNR columns. `views` has one entry per column.
// `standard_errors` (dB) has one per row: the error of the photo's mean, from leaving out one view at a time; NaN with
// fewer than two views. The caller owns both arrays, which have the matrix's sizes. VW_ERROR_MEMORY.
//
// A column differs if its agreement is below 0.3, below the median agreement by at least 4 robust spreads and 0.3, and
// if its PSNR is below the median: a view with a high PSNR may rank the photos in its own way, but shows the scene. The
// only view of a region does that, too. So a view disagrees only if its PSNR is also below the median by at least 3
// robust spreads and 3 dB (twice the squared error); else it is a lone view. A view stays low, whatever its column, if
// its PSNR is below the median by at least 4 robust spreads and 6 dB (four times the squared error). All need at least
// 4 views whose agreement or PSNR is known, because there is no outlier among fewer, and 5 visits per photo, because
// fewer say more about the steps than about the photos.
enum vw_status vw_matrix_jackknife(const struct vw_matrix *matrix, struct vw_view_evidence *views,
                                   double *standard_errors);

#endif
