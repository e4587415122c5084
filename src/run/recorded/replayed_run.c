#include "run/recorded/replayed_run.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run/imported/imported_run.h"
#include "run/lasting/lasting_summary.h"
#include "run/run_row.h"
#include "train/trainer.h"

static enum vw_status count_epochs(struct vw_recorded_run *run) {
    const struct vw_ledger_image *images = NULL;
    uint32_t image_count = 0, photos = 0;
    uint64_t steps = vw_ledger_next_step(run->ledger);
    enum vw_status status = vw_ledger_get_images(run->ledger, &images, &image_count);
    for (uint32_t i = 0; !status && i < image_count; i++) photos += strcmp(images[i].split, "train") == 0;
    if (!status && photos && steps > photos && (steps - 1) % photos == 0)
        run->config.epochs = (uint32_t)((steps - 1) / photos); // fewer than planned where the run stopped early
    else if (!status)
        status = vw_fail(VW_ERROR_USAGE,
                         "%s: the run has no whole epochs; finish it by viewworth value SCENE --out %s --resume",
                         run->ledger_path, run->out);
    return status;
}

enum vw_status vw_recorded_check_replay(struct vw_recorded_run *run) {
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    if (vw_is_imported(&run->row))
        return vw_fail(VW_ERROR_USAGE,
                       "%s: was imported, and its steps cannot be repeated; value the scene with viewworth value",
                       run->ledger_path);
    if (strcmp(run->row.status, "finished") != 0)
        return vw_fail(VW_ERROR_USAGE,
                       "%s: the run is %s, not finished; finish it by viewworth value SCENE --out %s --resume",
                       run->ledger_path, run->row.status, run->out);
    enum vw_status status = vw_lasting_check_config(&run->config);
    if (!status) status = vw_ledger_get_steps(run->ledger, &records, &count);
    if (!status && (count == 0 || !(records[0].validated || records[0].nonfinite)))
        status = vw_fail(VW_ERROR_USAGE,
                         "%s: is a run without validation (train), so that nothing tells what a step gains; value the "
                         "scene with viewworth value",
                         run->ledger_path);
    free(records);
    return status ? status : count_epochs(run);
}

static enum vw_status check_same_run(const struct vw_recorded_run *run, const struct vw_trainer *trainer) {
    struct vw_run_row ours;
    enum vw_status status = vw_run_row_make(trainer, run->gpu, run->scene, &run->config, &ours);
    if (!status) status = vw_run_row_check_same(&ours, &run->row, run->out);
    vw_run_row_free(&ours);
    return status;
}

enum vw_status vw_recorded_create_trainer(const struct vw_recorded_run *run, bool validated,
                                          struct vw_trainer **trainer) {
    const struct vw_trainer_params params = {.gpu = run->gpu,
                                             .scene = run->scene,
                                             .config = &run->config,
                                             .effects = run->effects,
                                             .effect_count = run->effect_count,
                                             .validate = validated};
    enum vw_status status = vw_trainer_create(&params, trainer);
    return status ? status : check_same_run(run, *trainer);
}

// Compares a step; ignores a flag of its validation, which is not replayed.
enum vw_status vw_recorded_steps_compare(void *context, const struct vw_step_record *replayed) {
    const struct vw_recorded_steps *steps = context;
    const struct vw_step_record *recorded =
        replayed->step < steps->record_count ? &steps->records[replayed->step] : NULL;
    bool same = recorded && recorded->view == replayed->view &&
                (recorded->nonfinite || (!replayed->nonfinite && recorded->train_loss == replayed->train_loss));
    if (same) return VW_OK;
    return vw_fail(VW_ERROR_MISMATCH,
                   "%s: step %" PRIu64 ", trained again, has training loss %.9g, not the recorded %.9g; check whether "
                   "the ledger was edited (viewworth verify) or device, driver or CPU changed",
                   steps->ledger_path, replayed->step, replayed->train_loss,
                   recorded ? recorded->train_loss : (double)NAN);
}
