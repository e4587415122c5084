// The verdict on the reconstruction of a run, and its JSON together with what the ranking deserves.
#ifndef VIEWWORTH_VALUE_VERDICT_H
#define VIEWWORTH_VALUE_VERDICT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "value/agreement.h"

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
// "better_training", "other_views", "other_views_low", "other_views_high", "low"}}, null where unknown.
json_t *vw_verdict_to_json(const struct vw_reconstruction *reconstruction,
                           const struct vw_ranking_agreement *agreement);
// Returns "good", "usable" or "too coarse to rank photos by"; "unknown". Static.
const char *vw_verdict_word(enum vw_verdict verdict);

#endif
