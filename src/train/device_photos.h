// Photos that are kept on the device, so that the pixels of steps are drawn there, with the bits that pixels.h gives
// them. Trainers that step together share them.
#ifndef VIEWWORTH_TRAIN_DEVICE_PHOTOS_H
#define VIEWWORTH_TRAIN_DEVICE_PHOTOS_H

#include "gpu/compute.h"
#include "train/pixels.h"

struct vw_device_photos {
    const struct vw_scene *scene; // borrowed
    // Words of each photo: its pixels as they are on the host, then, if some are left out, a byte per pixel: whether
    // it counts where mask files are obeyed, and where they are not.
    struct vw_buffer *buffer;
    uint64_t *first_words; // owned; of each view
    bool *kept;            // owned; of each view: whether it is there
};

// Makes room for all views that a training may have. VW_ERROR_DEVICE where the device has none: a quarter of its
// free memory, and one binding; or where a photo has a side of more than 65,535 pixels.
enum vw_status vw_device_photos_create(struct vw_gpu *gpu, const struct vw_scene *scene,
                                       struct vw_device_photos **photos);
void vw_device_photos_destroy(struct vw_device_photos **photos);

// Brings decoded photos to the device that are not there yet. Waits for what was submitted before.
enum vw_status vw_device_photos_keep(struct vw_device_photos *photos, const uint32_t *views, uint32_t count);

// Returns what draw_pixels is told to draw `count` pixels of a photo that is kept.
struct vw_push_draw vw_device_photos_push(const struct vw_device_photos *photos, uint32_t view,
                                          const struct vw_pixel_draw *draw, uint32_t first_pixel, uint32_t count);

#endif
