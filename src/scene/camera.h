// Fits cameras to photos of another size.
#ifndef VIEWWORTH_SCENE_CAMERA_H
#define VIEWWORTH_SCENE_CAMERA_H

#include "viewworth/scene.h"

// Scales the camera to photos of this size: each axis by its ratio of pixel counts, so that the photo's edges stay in
// place.
void vw_camera_resize(uint32_t width_px, uint32_t height_px, struct vw_camera *camera);
// Fits the camera to the photo, for a scene file. VW_ERROR_INPUT if the photo has another shape; `where` begins the
// message. Sets `*rescaled` if the sizes differ, and leaves it unchanged otherwise.
enum vw_status vw_camera_fit(const char *where, uint32_t width_px, uint32_t height_px, struct vw_camera *camera,
                             bool *rescaled);

#endif
