#include "run/recorded/recorded_run.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/inside.h"
#include "base/memory.h"
#include "detect/effects_text.h"
#include "run/imported/imported_run.h"
#include "run/lasting/lasting_summary.h"
#include "run/out_folder.h"
#include "run/run_row.h"
#include "run/scoring.h"
#include "run/session.h"
#include "train/trainer.h"
#include "viewworth/log.h"

enum vw_status vw_recorded_open(const char *out, struct vw_recorded_run *run) {
    enum vw_status status = vw_recorded_open_unverified(out, run);
    return status ? status : vw_recorded_warn_unverified(run, true);
}

enum vw_status vw_recorded_check_scores(struct vw_recorded_run *run) {
    struct vw_scoring scoring = {0};
    if (!strcmp(run->row.status, "running")) return VW_OK;
    enum vw_status status = vw_scoring_make(run->ledger, &run->config, &scoring);
    if (!status) status = vw_scoring_compare(&scoring, run->ledger, run->ledger_path);
    vw_scoring_free(&scoring);
    return status;
}

enum vw_status vw_recorded_warn_unverified(struct vw_recorded_run *run, bool scores) {
    enum vw_status status = vw_ledger_verify(run->ledger);
    if (!status && scores) status = vw_recorded_check_scores(run);
    if (status != VW_ERROR_MISMATCH) return status;
    vw_log_warning("%s; the ledger was edited, and so may be what follows from it", vw_error_message());
    return VW_OK;
}

enum vw_status vw_recorded_open_unverified(const char *out, struct vw_recorded_run *run) {
    *run = (struct vw_recorded_run){.out = out, .ledger_path = vw_path_join(out, VW_LEDGER_FILE)};
    if (!run->ledger_path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_file_check_inside(out, VW_LEDGER_FILE);
    if (!status) status = vw_ledger_open(run->ledger_path, &run->ledger);
    if (!status) status = vw_ledger_get_run(run->ledger, &run->row);
    if (status) return status;
    status = vw_is_imported(&run->row) ? vw_imported_config_from_json(run->row.config_json, &run->config)
                                       : vw_config_from_json(run->row.config_json, &run->config);
    if (!status) status = vw_effects_from_json(run->row.effects_json, run->effects, &run->effect_count);
    return status ? vw_fail_context(status, "%s", run->ledger_path) : VW_OK;
}

enum vw_status vw_recorded_open_scene(struct vw_recorded_run *run, const char *device) {
    if (vw_is_imported(&run->row))
        return vw_fail(VW_ERROR_USAGE, "%s: was imported from %s: it has steps and scores, but no scene and no field",
                       run->ledger_path, run->row.scene_path);
    enum vw_status status = vw_open_gpu(device, false, &run->gpu);
    if (!status) status = vw_reopen_scene(run->row.scene_path, run->row.scene_options_json, run->gpu, &run->scene);
    if (status) return status;
    char hash[VW_HASH_HEX_BYTES];
    vw_hash_to_hex(run->scene->hash, hash);
    if (strcmp(hash, run->row.scene_hash) == 0) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: no longer the scene that %s was trained on; restore it and the files of its lists",
                   run->row.scene_path, run->out);
}

// Compares the image rows with the scene's photos, which run_id covers by the hash of the scene.
enum vw_status vw_recorded_check_images(struct vw_recorded_run *run) {
    const struct vw_ledger_image *images = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_ledger_get_images(run->ledger, &images, &count);
    bool same = count == run->scene->view_count;
    for (uint32_t i = 0; i < count && same && !status; i++) {
        const struct vw_view *view = &run->scene->views[i];
        char sha256[VW_HASH_HEX_BYTES];
        vw_hash_to_hex(view->sha256, sha256);
        same = images[i].image_id == i && images[i].weight == view->weight && strcmp(view->name, images[i].name) == 0 &&
               strcmp(vw_split_name(view->split), images[i].split) == 0 && images[i].sha256 &&
               strcmp(sha256, images[i].sha256) == 0;
    }
    if (status || same) return status;
    return vw_fail(VW_ERROR_MISMATCH, "%s: its image rows are not the photos of %s: an image row was edited",
                   run->ledger_path, run->row.scene_path);
}

// Refuses a run without a field that has not ended.
static enum vw_status check_ended(const struct vw_recorded_run *run, const char *field_path) {
    if (!strcmp(run->row.status, "finished") || vw_file_exists(field_path)) return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: is missing, as the run is %s; go on by the command that began it, with --resume", field_path,
                   run->row.status);
}

struct vw_trainer_params vw_recorded_trainer_params(const struct vw_recorded_run *run) {
    return (struct vw_trainer_params){.gpu = run->gpu,
                                      .scene = run->scene,
                                      .config = &run->config,
                                      .effects = run->effects,
                                      .effect_count = run->effect_count};
}

enum vw_status vw_recorded_load_field(const struct vw_recorded_run *run, struct vw_trainer **trainer) {
    struct vw_trainer_params params = vw_recorded_trainer_params(run);
    params.awaits_field = true;
    char *path = vw_path_join(run->out, VW_FIELD_FILE);
    if (!path) return VW_ERROR_MEMORY;
    enum vw_status status = check_ended(run, path);
    if (!status) status = vw_trainer_create(&params, trainer);
    if (!status) status = vw_trainer_load_field(*trainer, path);
    free(path);
    return status;
}

void vw_recorded_close(struct vw_recorded_run *run) {
    vw_scene_close(&run->scene);
    (void)vw_gpu_close(&run->gpu); // reports only what validation layers said, which are off here
    vw_ledger_close(&run->ledger);
    free(run->ledger_path);
}

// ---- Steps that are taken again ------------------------------------------------------------------------------------

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
    struct vw_trainer_params params = vw_recorded_trainer_params(run);
    params.validate = validated;
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
