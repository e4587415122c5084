// The trust that the ranking of a run by dv_psnr deserves: whether it stood still while the training went on, whether
// the validation photos agree on it, and the verdict on the reconstruction.
#ifndef VIEWWORTH_VALUE_VERDICT_H
#define VIEWWORTH_VALUE_VERDICT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "value/matrix.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

enum {
    VW_AGREEMENT_EPOCHS_MIN = 4, // epochs that count: halves of fewer say too little
    VW_AGREEMENT_VIEWS_MIN = 4,  // validation photos: with fewer, one of them may decide the ranking
    VW_AGREEMENT_DIVISIONS = 20, // divisions of the validation photos, over which the mean is taken
};

struct vw_ranking_agreement {
    uint32_t epochs, view_count; // epochs that count; validation photos
    // Spearman's correlations over the train photos; NaN where they are unknown.
    double epoch_halves;    // scores by the first half of the epochs with those by the second
    double better_training; // predicted: with the scores of a training of about ten times the cost
    // Scores by one half of the validation photos with those by the other: the mean over the divisions, of a
    // random half each (vw_halves_split), r, corrected to the length of all photos (Spearman 1910, Brown 1910): 2 r /
    // (1 + r); r itself where it is negative. It predicts the correlation with the scores by as many other photos of
    // the same kind.
    double view_halves;
};

// Measures a run. `matrix` and `scores` are those of the same input. VW_ERROR_MEMORY, VW_ERROR_INPUT as
// vw_value_score().
enum vw_status vw_ranking_agreement_measure(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                            const struct vw_ledger_score *scores, uint32_t score_count,
                                            struct vw_ranking_agreement *agreement);

// Returns what a training of about ten times the cost agrees with the scores by: a share of their reliability, which is
// 1 less the ratio of the mean squared standard error to the variance over photos, and 0 below 0 (classical test
// theory). Why this share: src/lab/results/agreement.md. NaN for fewer than three scores with a standard error.
double vw_ranking_agreement_predict(const struct vw_ledger_score *scores, uint32_t score_count);

// Photos that were not trained on beside their renders at the end of a run, whole and at a size that does not depend on
// the size of training (run/outputs/reconstruction.h). Numbers are medians over photos. NaN: unknown.
struct vw_reconstruction {
    uint32_t view_count;                    // photos that were measured
    bool of_test;                           // they are test photos; else validation photos
    uint32_t trained_px[2], measured_px[2]; // width and height of the last of them
    double psnr_db, ssim;                   // SSIM: Wang et al. 2004, windows of 11 x 11 pixels (image/image.h)
    // PSNR of trivial predictions of the same pixels: the photo's own mean colour there, and the nearest train photo.
    double mean_colour_db, nearest_photo_db;
};

// Returns an object: "views", "split" ("test" or "val"), "trained_px", "measured_px" and the numbers above by their
// names, null where unknown.
json_t *vw_reconstruction_to_json(const struct vw_reconstruction *reconstruction);
// Returns NULL, or the key that is missing or not what it should be.
const char *vw_reconstruction_from_json(const json_t *json, struct vw_reconstruction *reconstruction);

enum vw_verdict { VW_VERDICT_UNKNOWN, VW_VERDICT_TOO_COARSE, VW_VERDICT_USABLE, VW_VERDICT_GOOD };

// Judges a run: good if PSNR is at least 6 dB above the better of the trivial predictions and SSIM at least 0.7, too
// coarse below 3 dB or 0.5. VW_VERDICT_UNKNOWN where PSNR, SSIM or both predictions are unknown.
enum vw_verdict vw_verdict_judge(const struct vw_reconstruction *reconstruction);
extern const struct vw_reconstruction vw_reconstruction_unknown;
// Returns {"verdict": word, "reconstruction": as above, "ranking": {"epochs", "views", "epoch_halves",
// "better_training", "view_halves"}}, null where unknown.
json_t *vw_verdict_to_json(const struct vw_reconstruction *reconstruction,
                           const struct vw_ranking_agreement *agreement);
// Returns "good", "usable" or "too coarse to rank photos by"; "unknown". Static.
const char *vw_verdict_word(enum vw_verdict verdict);

#endif
