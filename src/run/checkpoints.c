#include "run/checkpoints.h"

#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/file.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static const double FIRST_INTERVAL_S = 1.0, INTERVAL_S = 30.0, TIMES_COST = 20.0;

enum vw_status vw_checkpoints_open(const char *out, struct vw_checkpoints *checkpoints) {
    *checkpoints = (struct vw_checkpoints){
        .paths = {vw_path_join(out, "checkpoint_0.vwc"), vw_path_join(out, "checkpoint_1.vwc")},
    };
    return checkpoints->paths[0] && checkpoints->paths[1] ? VW_OK : VW_ERROR_MEMORY;
}

void vw_checkpoints_close(struct vw_checkpoints *checkpoints) {
    for (int i = 0; i < 2; i++) free(checkpoints->paths[i]);
}

enum vw_status vw_checkpoints_load(struct vw_checkpoints *checkpoints, struct vw_trainer *trainer, uint64_t last_step,
                                   bool *found, uint64_t *step) {
    int newest = -1;
    uint64_t steps[2] = {0};
    for (int i = 0; i < 2; i++) {
        if (!vw_file_exists(checkpoints->paths[i])) continue;
        enum vw_status status = vw_trainer_load_checkpoint(trainer, checkpoints->paths[i], last_step, &steps[i]);
        if (status == VW_ERROR_INPUT || status == VW_ERROR_IO) vw_log_warning("%s", vw_error_message());
        else if (status && status != VW_ERROR_USAGE) return status; // a checkpoint that is too new is expected
        else if (!status && (newest < 0 || steps[i] > steps[newest])) newest = i;
    }
    *found = newest >= 0;
    *step = *found ? steps[newest] : 0;
    if (!*found) return VW_OK;
    checkpoints->next = 1 - newest;
    return vw_trainer_load_checkpoint(trainer, checkpoints->paths[newest], last_step,
                                      step); // the other may have been loaded last
}

void vw_checkpoints_begin(struct vw_checkpoints *checkpoints) {
    checkpoints->interval_s = FIRST_INTERVAL_S;
    checkpoints->due_s = vw_now_s() + FIRST_INTERVAL_S;
}

bool vw_checkpoints_due(const struct vw_checkpoints *checkpoints) { return vw_now_s() >= checkpoints->due_s; }

void vw_checkpoints_save(struct vw_checkpoints *checkpoints, struct vw_trainer *trainer) {
    double started_s = vw_now_s();
    if (vw_trainer_save_checkpoint(trainer, checkpoints->paths[checkpoints->next]))
        vw_log_warning("%s", vw_error_message());
    else checkpoints->next = 1 - checkpoints->next;
    double ended_s = vw_now_s();
    checkpoints->interval_s = fmin(2 * checkpoints->interval_s, INTERVAL_S);
    checkpoints->due_s = ended_s + fmax(checkpoints->interval_s, TIMES_COST * (ended_s - started_s));
}
