#include "run/lasting_folder.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/imported.h"
#include "run/open.h"
#include "run/recorded_run.h"
#include "run/run.h"

enum { ALL_EXPLICIT = (VW_EXPLICIT_EPOCHS << 1) - 1 };

static enum vw_status count_epochs(struct vw_recorded_run *run) {
    const struct vw_ledger_image *images = NULL;
    uint32_t image_count = 0, photos = 0;
    uint64_t steps = vw_ledger_next_step(run->ledger);
    enum vw_status status = vw_ledger_get_images(run->ledger, &images, &image_count);
    for (uint32_t i = 0; !status && i < image_count; i++) photos += strcmp(images[i].split, "train") == 0;
    if (!status && photos && steps > photos && (steps - 1) % photos == 0)
        status = vw_lasting_set_epochs(run->ledger_path, (uint32_t)((steps - 1) / photos), &run->config);
    else if (!status)
        status = vw_fail(VW_ERROR_USAGE,
                         "%s: the run has no whole epochs; finish it by viewworth value SCENE --out %s --resume",
                         run->ledger_path, run->out);
    return status;
}

// What cannot be swept is refused before the device is opened.
static enum vw_status check(struct vw_recorded_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    if (vw_is_imported(&run->row))
        return vw_fail(VW_ERROR_USAGE,
                       "%s: was imported, and its steps cannot be taken again as lasting credit needs it; value the "
                       "scene with viewworth value",
                       run->ledger_path);
    if (strcmp(run->row.status, "finished") != 0)
        return vw_fail(VW_ERROR_USAGE,
                       "%s: the run is not finished but %s; finish it by viewworth value SCENE --out %s --resume",
                       run->ledger_path, run->row.status, run->out);
    enum vw_status status = vw_lasting_check_config(&run->config);
    if (!status) status = vw_ledger_get_steps(run->ledger, &records, &count);
    if (!status && (count == 0 || !(records[0].validated || records[0].nonfinite)))
        status = vw_fail(VW_ERROR_USAGE,
                         "%s: is a run without validation (train), which lasting credit follows back; value the scene "
                         "with viewworth value",
                         run->ledger_path);
    free(records);
    return status ? vw_fail_context(status, "lasting") : count_epochs(run);
}

static enum vw_status sweep(const struct vw_lasting_folder_params *params, const struct vw_recorded_run *recorded) {
    json_t *texts = NULL;
    struct vw_run *run = NULL;
    struct vw_run_params of_run = {.config = &recorded->config,
                                   .device = params->device ? params->device : recorded->row.device,
                                   .out = params->out,
                                   .resume = true,
                                   .explicit_fields = ALL_EXPLICIT,
                                   .lasting = true,
                                   .lasting_rays = params->wanted.rays,
                                   .no_gate = params->wanted.no_gate,
                                   .lasting_matrix = params->wanted.matrix,
                                   .no_thumbnails = params->no_thumbnails,
                                   .progress = params->progress,
                                   .context = params->context};
    enum vw_status status = vw_scene_options_from_json(recorded->row.scene_options_json, &texts, &of_run.scene);
    if (status) return status;
    of_run.scene.path = recorded->row.scene_path;
    status = vw_run_open(&of_run, &run);
    if (!status) status = vw_run_finish(run);
    vw_run_close(&run);
    json_decref(texts);
    return status;
}

enum vw_status vw_lasting_of_folder(const struct vw_lasting_folder_params *params) {
    struct vw_recorded_run recorded = {0};
    struct vw_lasting_sweep found = {0};
    enum vw_status status = vw_recorded_open(params->out, &recorded);
    if (!status) status = vw_ledger_get_lasting(recorded.ledger, &found);
    if (!status && !vw_lasting_is_there(&params->wanted, &recorded.config, &found)) {
        status = check(&recorded);
        if (!status) status = sweep(params, &recorded);
    }
    vw_lasting_sweep_free(&found);
    vw_recorded_close(&recorded);
    return status;
}
