// Looks an image up by its id, for those who hold image rows in the order of their ids.
#ifndef VIEWWORTH_LEDGER_FIND_IMAGE_H
#define VIEWWORTH_LEDGER_FIND_IMAGE_H

#include "viewworth/ledger.h"

// NULL when there is none.
const struct vw_ledger_image *vw_ledger_find_image(const struct vw_ledger_image *images, uint32_t image_count,
                                                   uint32_t image_id);

#endif
