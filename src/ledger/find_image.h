// Finds an image by its id in an array of image rows that is sorted by id.
#ifndef VIEWWORTH_LEDGER_FIND_IMAGE_H
#define VIEWWORTH_LEDGER_FIND_IMAGE_H

#include "viewworth/ledger.h"

// Finds an image by its id; NULL if it does not exist.
const struct vw_ledger_image *vw_ledger_find_image(const struct vw_ledger_image *images, uint32_t image_count,
                                                   uint32_t image_id);
// Returns whether a validation photo has another weight than 1.
bool vw_images_have_weights(const struct vw_ledger_image *images, uint32_t image_count);
// Finds an image that must exist. VW_ERROR_INPUT names its id; the caller adds what refers to it.
enum vw_status vw_ledger_require_image(const struct vw_ledger_image *images, uint32_t image_count, uint32_t image_id,
                                       const struct vw_ledger_image **image);

#endif
