#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands/commands.h"
#include "cli/output/results.h"
#include "cli/params.h"
#include "detect/decide.h"
#include "experiment/experiment.h"
#include "run/outputs/run_outputs.h"
#include "run/session.h"
#include "viewworth/log.h"

// Opens the device. Without one there is neither a pilot run nor an estimate; that fails only if --device asked for
// one.
static enum vw_status open_device(const struct vw_options *options, struct vw_gpu **gpu, struct vw_estimate *estimate) {
    enum vw_status status = *gpu ? VW_OK : vw_open_gpu(options->device, false, gpu);
    if (!status || options->device) return status;
    snprintf(estimate->missing, sizeof estimate->missing, "%.*s", (int)sizeof estimate->missing - 1,
             vw_error_message());
    return VW_OK;
}

enum vw_status vw_command_info(const struct vw_options *options) {
    struct vw_config config;
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    struct vw_scene_info info = {0};
    struct vw_scene_params params;
    struct vw_photo_finding *findings = NULL;
    char *scene_options = NULL;
    enum vw_status status = vw_params_settle(options, options->device, &params, &config);
    if (!status) status = vw_params_open_scene(&params, NULL, options->device, &gpu, &scene); // pixels are evidence
    if (!status && scene->missing) vw_log_warning("%s: %s", scene->path, scene->missing);
    if (!status && !(scene_options = vw_scene_options_to_json(&params))) status = VW_ERROR_MEMORY;
    if (!status) status = vw_run_check_photos(scene, scene_options, gpu, &findings); // as value does
    if (!status) status = open_device(options, &gpu, &info.estimate);
    if (!status) status = vw_effects_decide_cached(gpu, scene, &config, info.effects, &info.effect_count);
    if (!status) vw_estimate_run(&config, scene, gpu, info.effects, info.effect_count, &info.estimate);
    if (!status && !*info.estimate.missing)
        status = vw_prices_estimate(&config, vw_params_explicit_fields(options), scene, gpu, info.effects,
                                    info.effect_count, info.prices);
    info.scene = scene;
    info.findings = findings;
    if (!status) status = vw_scene_info_print(&info, options->json);
    free(findings);
    free(scene_options);
    vw_scene_close(&scene);
    (void)vw_gpu_close(&gpu);
    return status;
}
