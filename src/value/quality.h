// quality: how well a train photo fits. value.h has its formula and its interval.
#ifndef VIEWWORTH_VALUE_QUALITY_H
#define VIEWWORTH_VALUE_QUALITY_H

#include "viewworth/value.h"

// Appends a score per train image, in image order; nothing if no train image has both a delta of val_l1 and a late
// training loss. An image without both gets the value 0 with 0 visits, as by the other methods. `scores` must have room
// for image_count more. VW_ERROR_INPUT for a step on an image that is not in `images`, VW_ERROR_MEMORY.
enum vw_status vw_quality_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                 uint32_t *score_count);

#endif
