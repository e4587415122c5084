#include "scene/camera_fit.h"

void vw_camera_resize(uint32_t width_px, uint32_t height_px, struct vw_camera *camera) {
    double scale_x = (double)width_px / camera->width_px, scale_y = (double)height_px / camera->height_px;
    camera->focal_x_px *= scale_x;
    camera->centre_x_px *= scale_x;
    camera->focal_y_px *= scale_y;
    camera->centre_y_px *= scale_y;
    camera->width_px = width_px;
    camera->height_px = height_px;
}

enum vw_status vw_camera_fit(const char *where, uint32_t width_px, uint32_t height_px, struct vw_camera *camera,
                             bool *rescaled) {
    if ((uint64_t)camera->width_px * height_px != (uint64_t)camera->height_px * width_px)
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: the camera is for %u x %u pixels but the photo has %u x %u; give photos of the camera's shape", where,
            camera->width_px, camera->height_px, width_px, height_px);
    if (camera->width_px == width_px) return VW_OK;
    vw_camera_resize(width_px, height_px, camera);
    *rescaled = true;
    return VW_OK;
}
