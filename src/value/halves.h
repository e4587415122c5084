// Cross-fitting over validation photos: they are split into two halves, so that scores of one half select photos and
// the other half judges the selection. A selection that is judged by the photos that made it looks better than it is.
#ifndef VIEWWORTH_VALUE_HALVES_H
#define VIEWWORTH_VALUE_HALVES_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

enum { VW_HALF_A, VW_HALF_B, VW_HALVES, VW_HALF_NONE = VW_HALVES };

// Fills the half of every image: VW_HALF_NONE for those that do not validate. Validation photos are ordered by a hash
// of the seed and their name, and belong to A and B in turn. `sizes` counts the photos of each half; A has one more if
// their number is odd. VW_ERROR_MEMORY.
enum vw_status vw_halves_split(const struct vw_ledger_image *images, uint32_t image_count, uint64_t seed,
                               uint8_t *halves, uint32_t sizes[VW_HALVES]);

// Computes the scores that the run would have with only the validation photos of one half, from the table view, as
// vw_value_score() does. The measures of a step are then means over the half's photos, each with the same weight; so is
// lasting_psnr, if the backward pass was by validation photo. lasting_loss is left out. A step that lacks a photo's row
// has no value. `*scores` is owned by the caller (free).
enum vw_status vw_halves_score(struct vw_ledger *ledger, const struct vw_value_input *input, const uint8_t *halves,
                               uint8_t half, struct vw_ledger_score **scores, uint32_t *score_count);

#endif
