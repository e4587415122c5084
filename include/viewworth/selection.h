// Selection: which train photos to keep, by their scores, from the rows of a ledger alone (no GPU).
#ifndef VIEWWORTH_SELECTION_H
#define VIEWWORTH_SELECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

// The rules. A score is a robust outlier if z < VW_SELECTION_OUTLIER_Z, where z = (score - median) / spread over the
// train photos that have the score; the spread is 1.4826 times the median absolute deviation (Huber, Robust Statistics,
// 1981).
#define VW_SELECTION_OUTLIER_Z (-3.0)
// A score may be low because the photo alone sees a region, so without a method a photo is an outlier only by evidence
// of its own, train_fit, together with low credit:
// - train_fit is a robust outlier, and dv_psnr or dv_loss is below its median; or
// - train_fit has z < -0.5, and both dv_psnr and dv_loss have z < -4.
// A photo whose credits both have z < -4 and whose train_fit is ordinary is a lone view, and kept. These limits were
// chosen by measurement (src/lab/results/quality.md of the source tree).
#define VW_SELECTION_LOW_FIT_Z (-0.5)
#define VW_SELECTION_LOW_CREDIT_Z (-4.0)
enum vw_selection_rule {
    VW_SELECT_OUTLIERS, // all train photos but the robust outliers by the method; without one, as above: a run without
                        // train_fit has no outlier. Keeps photos without a score. No photo is an outlier among
                        // fewer than 5, or if the spread is 0
    VW_SELECT_POSITIVE, // value above zero
    VW_SELECT_SIGNIFICANT, // lower end of the interval above zero; drops scores without an interval
    VW_SELECT_NOT_HARMFUL, // upper end of the interval not below zero; keeps scores without an interval
    VW_SELECT_TOP,         // the best `amount`
    VW_SELECT_DROP,        // all but the worst `amount`
};

struct vw_selection_params {
    const char *method; // NULL: vw_value_main_method, vw_value_default_method for a rule that compares with zero, which
                        // the former may lack, or several methods for VW_SELECT_OUTLIERS
    enum vw_selection_rule rule;
    double amount; // for VW_SELECT_TOP and VW_SELECT_DROP: a number of photos (whole, at least 1), or a percentage in
                   // (0,100] if `percent`
    bool percent;  // relative to the photos that have a score, rounded to whole photos; at least 1 is kept
};

// A train photo that VW_SELECT_OUTLIERS leaves out because of a method's score, or keeps as a lone view.
struct vw_selection_outlier {
    uint32_t image_id;
    const char *method; // static, or that of the params
    double z;
    bool lone; // kept: it probably sees what no other photo sees
};

struct vw_selection {
    uint32_t *image_ids;                   // owned: the train photos kept, best first, ties by image_id
    uint32_t count;                        // length of image_ids, at least 1
    uint32_t scored_count;                 // train photos that have a score
    struct vw_selection_outlier *outliers; // owned: by the method, worst first; without one, three rows per photo
    uint32_t outlier_count;
    const char *method; // that was used; NULL: several
};

// Reads a rule in words into rule, amount and percent: without-outliers, positive, significant, not-harmful, top:K,
// top:P%, drop:K or drop:P%. Returns false for another text; vw_selection_make checks the range of an amount.
bool vw_selection_read_rule(const char *words, struct vw_selection_params *params);
#define VW_SELECTION_RULES "without-outliers, positive, significant, not-harmful, top:K, top:P%, drop:K, drop:P%"

// Selects photos. No other rule keeps a train photo without a score of the method (NaN, or no visit that counts). Free
// the selection with vw_selection_free. VW_ERROR_USAGE for a method without scores (the message names those with
// scores), for a rule that compares with zero by a method without one (vw_value_method.has_zero), and for an amount out
// of range; VW_ERROR_INPUT if there are no scores at all, if a score's image is not in `images`, and if no photo would
// be kept.
enum vw_status vw_selection_make(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count,
                                 const struct vw_selection_params *params, struct vw_selection *selection);
void vw_selection_free(struct vw_selection *selection);

VW_PUBLIC_END

#endif
