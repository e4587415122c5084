// Cameras given for another size of the photo.
#ifndef VIEWWORTH_CAMERA_FIT_H
#define VIEWWORTH_CAMERA_FIT_H

#include "viewworth/scene.h"

// Makes the camera one for photos of this size. The photo's edges stay where they are, so each axis is scaled by its
// ratio of pixel counts.
void vw_camera_resize(uint32_t width_px, uint32_t height_px, struct vw_camera *camera);
// The same for the photo that a scene file's camera belongs to: refuses one of another shape, in a message that begins
// with `where`.
// `*rescaled` becomes true when the sizes differ and is left alone otherwise.
enum vw_status vw_camera_fit(const char *where, uint32_t width_px, uint32_t height_px, struct vw_camera *camera,
                             bool *rescaled);

#endif
