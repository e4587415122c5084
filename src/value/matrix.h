// Which photo helped which validation view: the score of every photo taken apart, and what the ranking owes to the
// choice of those views.
#ifndef VIEWWORTH_MATRIX_H
#define VIEWWORTH_MATRIX_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_value_input; // value.h

// Rows are train photos, columns validation views, both in image order; entry (photo, view) is at photo * view_count +
// view. Owned arrays.
struct vw_matrix {
    uint32_t *photos, *views; // image_ids
    uint32_t photo_count, view_count;
    double *psnr; // dB: sum of the step deltas of that view's PSNR, MSE floored as PSNR is; a row's mean is the photo's
                  // dv_psnr
    double *l1;   // mean absolute error removed of that view; a row's mean weighted by the views' pixels is the photo's
                  // dv_loss
    double *end_psnr;     // dB, of each view after the last step that was validated
    uint32_t visit_count; // steps that count, of all photos
};

// From table view, as scores are made: deltas from the last step with values, summed over the steps from burn-in on. A
// run without such rows (imported, or not validated) gives 0 views, one without a step after burn-in gives zeros and
// visit_count 0. Clear it also after a failure.
enum vw_status vw_value_matrix(struct vw_ledger *ledger, const struct vw_value_input *input, struct vw_matrix *matrix);
void vw_matrix_clear(struct vw_matrix *matrix);

// What is known of one validation view from the matrix alone.
struct vw_view_evidence {
    uint32_t image_id;
    double end_psnr;
    double agreement; // Spearman's correlation over the photos of its column with the mean of the others; NaN where
                      // there is none
    double without;   // Spearman's correlation of the ranking without it to the ranking with it; NaN likewise
    bool disagrees;   // its column says other than the others do, far more than they do among each other
    bool stays_low;   // its PSNR stays far below the others'
};

// The jackknife over validation views, by the PSNR columns. `views` has one entry per column, `standard_errors` (dB)
// one per row: that of a photo's mean, from leaving out one view at a time; NaN with fewer than two. Both are the
// caller's, of the matrix's sizes. VW_ERROR_MEMORY.
//
// A view disagrees when its agreement lies below 0.3 and below the views' median by 4 robust spreads and 0.3 at least,
// and its PSNR below their median: a view that the field matches well may rank the photos in its own way, but shows the
// scene. It stays low when its PSNR lies below their median by 4 robust spreads and 6 dB at least, four times the
// squared error. Both need at least 4 views of which agreement or PSNR is known, for among fewer nobody can say which
// one is odd, and 5 visits per photo, for fewer say more of the steps than of the photos.
enum vw_status vw_matrix_jackknife(const struct vw_matrix *matrix, struct vw_view_evidence *views,
                                   double *standard_errors);

#endif
