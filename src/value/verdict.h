// The verdict on a reconstruction: whether photos can be ranked by it.
#ifndef VIEWWORTH_VALUE_VERDICT_H
#define VIEWWORTH_VALUE_VERDICT_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "value/ranking_agreement.h"

// Validation photos beside their renders at the end of a run; PSNR and SSIM are means over photos. NaN: unknown.
struct vw_reconstruction {
    uint32_t view_count;
    uint64_t pixel_count; // all these photos together: the middle of each
    double psnr_db, ssim; // SSIM: Wang et al. 2004, windows of 11 x 11 pixels (image/image.h)
    // PSNR of trivial predictions of the same pixels: the photo's own mean colour there, and the nearest train photo.
    double mean_colour_db, nearest_photo_db;
};

// Returns an object: "views", "pixels" and the numbers above by their names, null where unknown.
json_t *vw_reconstruction_to_json(const struct vw_reconstruction *reconstruction);
// Returns NULL, or the key that is missing or not what it should be.
const char *vw_reconstruction_from_json(const json_t *json, struct vw_reconstruction *reconstruction);

enum vw_verdict { VW_VERDICT_UNKNOWN, VW_VERDICT_TOO_COARSE, VW_VERDICT_USABLE, VW_VERDICT_GOOD };

// Judges a run: too coarse if PSNR is less than 3 dB above the better of the trivial predictions, good from 6 dB and
// SSIM 0.7 on. VW_VERDICT_UNKNOWN where PSNR or both predictions are unknown.
enum vw_verdict vw_verdict_judge(const struct vw_reconstruction *reconstruction);
extern const struct vw_reconstruction vw_reconstruction_unknown;
// Returns {"verdict": word, "reconstruction": as above, "ranking": {"epochs", "views", "epoch_halves",
// "better_training", "view_halves"}}, null where unknown.
json_t *vw_verdict_to_json(const struct vw_reconstruction *reconstruction,
                           const struct vw_ranking_agreement *agreement);
// Returns "good", "usable" or "too coarse to rank photos by"; "unknown". Static.
const char *vw_verdict_word(enum vw_verdict verdict);

#endif
