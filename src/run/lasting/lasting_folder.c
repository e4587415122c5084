#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/lasting/lasting.h"
#include "run/recorded/recorded_run.h"
#include "run/run.h"
#include "run/session.h"

static enum vw_status run_backward(const struct vw_run_params *params, const struct vw_recorded_run *recorded) {
    json_t *texts = NULL;
    struct vw_run *run = NULL;
    struct vw_run_params of_run = *params;
    of_run.config = &recorded->config;
    if (!of_run.device) of_run.device = recorded->row.device;
    of_run.resume = true;
    of_run.explicit_fields = UINT64_MAX;
    enum vw_status status = vw_scene_options_from_json(recorded->row.scene_options_json, &texts, &of_run.scene);
    if (status) return status;
    of_run.scene.path = recorded->row.scene_path;
    status = vw_run_open(&of_run, &run);
    if (!status) status = vw_run_finish(run);
    vw_run_close(&run);
    json_decref(texts);
    return status;
}

enum vw_status vw_lasting_of_folder(const struct vw_run_params *params) {
    struct vw_recorded_run recorded = {0};
    struct vw_lasting_pass found = {0};
    enum vw_status status = vw_recorded_open_unverified(params->out, &recorded); // run_backward() verifies
    if (!status) status = vw_ledger_get_lasting(recorded.ledger, &found);
    if (!status && !vw_lasting_is_there(&params->lasting, &recorded.config, &found)) {
        status = vw_recorded_check_replay(&recorded); // before the device is opened
        if (!status) status = run_backward(params, &recorded);
    }
    vw_lasting_pass_free(&found);
    vw_recorded_close(&recorded);
    return status;
}
