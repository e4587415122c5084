#include "ledger/find_image.h"

#include <string.h>

#include "viewworth/status.h"

const struct vw_ledger_image *vw_ledger_find_image(const struct vw_ledger_image *images, uint32_t image_count,
                                                   uint32_t image_id) {
    uint32_t first = 0, end = image_count; // the image, if any, is in [first, end)
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (images[middle].image_id == image_id) return &images[middle];
        if (images[middle].image_id < image_id) first = middle + 1;
        else end = middle;
    }
    return NULL;
}

bool vw_images_have_weights(const struct vw_ledger_image *images, uint32_t image_count) {
    for (uint32_t i = 0; i < image_count; i++)
        if (strcmp(images[i].split, "val") == 0 && images[i].weight != 1) return true;
    return false;
}

enum vw_status vw_ledger_require_image(const struct vw_ledger_image *images, uint32_t image_count, uint32_t image_id,
                                       const struct vw_ledger_image **image) {
    *image = vw_ledger_find_image(images, image_count, image_id);
    return *image ? VW_OK
                  : vw_fail(VW_ERROR_INPUT,
                            "image %u is not in the image table; check the ledger with viewworth verify", image_id);
}
