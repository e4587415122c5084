#include "run/outputs/run_outputs.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/out_files.h"
#include "run/outputs/photo_reasons.h"
#include "run/outputs/reconstruction.h"
#include "run/outputs/report_folder.h"
#include "run/outputs/residuals.h"
#include "run/outputs/scene_map.h"
#include "scene/splits_file.h"

enum vw_status vw_run_splits_write(const struct vw_scene *scene, const char *out, struct vw_checksums *made) {
    char *text = NULL;
    enum vw_status status = vw_splits_file_make(scene, &text);
    if (!status) status = vw_result_write(out, VW_SPLITS_FILE, text, strlen(text), made);
    free(text);
    return status;
}

enum vw_status vw_run_splats_write(struct vw_trainer *trainer, const char *out, struct vw_checksums *made,
                                   bool *written) {
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_trainer_make_splats(trainer, &data, &size_bytes);
    *written = !status && data;
    if (*written) status = vw_result_write(out, VW_SPLATS_FILE, data, size_bytes, made);
    free(data);
    return status;
}

static enum vw_status measure_reconstruction(const struct vw_run_outputs_params *params, struct vw_checksums *made,
                                             struct vw_reconstruction *reconstruction) {
    const struct vw_reconstruction_params of_scene = {
        .scene = params->scene,
        .trainer = params->trainer,
        .rays = vw_residuals_rays(params->scoring, params->config),
        .out = params->out,
    };
    return vw_reconstruction_write(&of_scene, made, reconstruction);
}

// Writes pictures of the scene and the field, so that the report can be made again without them.
static enum vw_status write_pictures(const struct vw_run_outputs_params *params, struct vw_checksums *made) {
    const struct vw_residuals_params residuals = {
        .panes = {.scene = params->scene,
                  .trainer = params->trainer,
                  .on_background = vw_effects_is_on(params->effects, params->effect_count, "background"),
                  .fitted = vw_effects_fit_views(params->effects, params->effect_count)},
        .scoring = params->scoring,
        .config = params->config,
        .out = params->out,
    };
    const char **reasons = vw_allocate(params->scene->view_count, sizeof *reasons);
    enum vw_status status = reasons ? vw_photo_reasons_find(&residuals, reasons) : VW_ERROR_MEMORY;
    if (!status) status = vw_scene_map_write(params->scene, reasons, params->out, made);
    free(reasons);
    return status || params->report.options.no_thumbnails ? status : vw_residuals_write(&residuals, made);
}

enum vw_status vw_run_outputs_make(const struct vw_run_outputs_params *params, struct vw_checksums *made,
                                   struct vw_run_outputs *outputs) {
    enum vw_status status = vw_attribution_make(params->scene, params->ledger, params->scoring, params->out,
                                                params->payout, made, &outputs->attribution);
    if (!status)
        status = vw_validation_views_make(params->scene, params->ledger, params->scoring, params->out, made,
                                          &outputs->validation);
    if (!status) status = vw_run_splits_write(params->scene, params->out, made);
    if (!status) status = measure_reconstruction(params, made, &outputs->reconstruction);
    if (!status) status = write_pictures(params, made);
    if (!status) status = vw_run_splats_write(params->trainer, params->out, made, &outputs->has_splats);
    if (status) return status;
    vw_checksums_note_rest_absent(made);
    if (!vw_report_folder_make(params->out, &params->report, made, &outputs->report_path)) return VW_OK;
    return vw_fail(VW_ERROR_IO, "no report: %s; correct this, then repeat the command", vw_error_message());
}

void vw_run_outputs_free(struct vw_run_outputs *outputs) {
    vw_attribution_free(&outputs->attribution);
    vw_validation_views_free(&outputs->validation);
    free(outputs->report_path);
}
