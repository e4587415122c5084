#include "cli/open.h"

#include "viewworth/log.h"

enum vw_status vw_open_gpu(const struct vw_options *options, struct vw_gpu **gpu) {
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.device = options->device}, gpu);
    if (status) return status;
    const struct vw_gpu_info *info = vw_gpu_get_info(*gpu);
    vw_log_info("device   %u: %s (%s)", info->index, info->name, info->driver);
    return VW_OK;
}

enum vw_status vw_open_scene(const struct vw_options *options, const char *path, struct vw_gpu *gpu, bool headers_only,
                             struct vw_scene **scene) {
    const struct vw_scene_params params = {
        .path = path,
        .format = options->format,
        .pool = options->pool,
        .train_list = options->train_list,
        .val_list = options->val_list,
        .test_list = options->test_list,
        .providers = options->providers,
        .downscale = options->downscale,
        .headers_only = headers_only,
        .gpu = gpu,
    };
    return vw_scene_open(&params, scene);
}
