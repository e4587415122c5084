#include "cli/training_run.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "cli/effects_table.h"
#include "cli/interrupt.h"
#include "cli/json_output.h"
#include "cli/open.h"
#include "cli/out_folder.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/report.h"

enum { UTC_BYTES = 21 }; // "2026-11-21T03:04:05Z"

static void format_utc_now(char text[UTC_BYTES]) {
    time_t now = time(NULL);
    struct tm parts;
    gmtime_r(&now, &parts);
    strftime(text, UTC_BYTES, "%Y-%m-%dT%H:%M:%SZ", &parts);
}

// ---- Opening ----------------------------------------------------------------------------------------------------------

static enum vw_status name_outputs(struct vw_training_run *run) {
    const char *out = run->options->out;
    run->ledger_path = vw_path_join(out, "ledger.db");
    run->scores_path = vw_path_join(out, "scores.csv");
    run->field_path = vw_path_join(out, "field.vwf");
    if (!run->ledger_path || !run->scores_path || !run->field_path) return VW_ERROR_MEMORY;
    if (vw_file_exists(out)) return vw_fail(VW_ERROR_USAGE, "--out %s: is a file; name a folder", out);
    if (vw_file_exists(run->ledger_path)) return vw_fail(VW_ERROR_USAGE, "--out %s: holds a run already; name another folder", out);
    return vw_out_check(out);
}

static void say_scene(const struct vw_scene *scene) {
    vw_log_info("scene    %s (%s): %u photos to train on, %u to validate, %u for tests, %u excluded", scene->path, scene->format,
                scene->split_count[VW_SPLIT_TRAIN], scene->split_count[VW_SPLIT_VAL], scene->split_count[VW_SPLIT_TEST],
                scene->split_count[VW_SPLIT_EXCLUDED]);
    for (uint32_t i = 0; i < scene->note_count; i++) vw_log_info("         %s", scene->notes[i]);
}

static void say_effects(const struct vw_training_run *run) {
    vw_log_info("%s", vw_effects_heading);
    for (uint32_t i = 0; i < run->effect_count; i++) {
        char line[VW_EFFECT_LINE_BYTES];
        vw_effect_to_line(&run->effects[i], line);
        vw_log_info("%s", line);
    }
}

static void say_field(const struct vw_trainer *trainer) {
    struct vw_trainer_stats stats;
    vw_trainer_get_stats(trainer, &stats);
    vw_log_info("field    %" PRIu64 " params, %.1f MiB on the device; %" PRIu64 " steps", stats.param_count,
                (double)stats.device_bytes / 0x1p20, vw_trainer_total_steps(trainer));
}

enum vw_status vw_training_open(const struct vw_options *options, bool validate, struct vw_training_run *run) {
    *run = (struct vw_training_run){.options = options, .first_val_psnr_db = NAN, .last_val_psnr_db = NAN};
    enum vw_status status = name_outputs(run);
    if (!status) status = vw_open_gpu(options, &run->gpu);
    if (!status) status = vw_open_scene(options, options->operand, run->gpu, false, &run->scene);
    if (status) return status;
    say_scene(run->scene);
    status = vw_effects_decide(run->scene, options->config.effects, run->effects, &run->effect_count);
    if (status) return status;
    say_effects(run);
    const struct vw_trainer_params params = {.gpu = run->gpu, .scene = run->scene, .config = &options->config, .validate = validate};
    status = vw_trainer_create(&params, &run->trainer);
    if (!status) say_field(run->trainer);
    return status;
}

void vw_training_close(struct vw_training_run *run) {
    vw_ledger_close(&run->ledger);
    vw_trainer_destroy(&run->trainer);
    vw_scene_close(&run->scene);
    (void)vw_gpu_close(&run->gpu); // reports only what validation layers said, which are off here
    free(run->ledger_path);
    free(run->scores_path);
    free(run->field_path);
}

// ---- The ledger -------------------------------------------------------------------------------------------------------

static enum vw_status list_images(const struct vw_scene *scene, struct vw_ledger_image **images, char (**hashes)[VW_HASH_HEX_BYTES]) {
    *images = vw_allocate(scene->view_count, sizeof **images);
    *hashes = vw_allocate(scene->view_count, sizeof **hashes);
    if (!*images || !*hashes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_view *view = &scene->views[i];
        vw_hash_to_hex(view->sha256, (*hashes)[i]);
        (*images)[i] = (struct vw_ledger_image){
            .image_id = i,
            .name = view->name,
            .split = vw_split_name(view->split),
            .provider = view->provider,
            .sha256 = (*hashes)[i],
            .truth = view->truth,
        };
    }
    return VW_OK;
}

static enum vw_status write_first_rows(struct vw_training_run *run, const struct vw_ledger_image *images) {
    const struct vw_gpu_info *device = vw_gpu_get_info(run->gpu);
    uint8_t run_id[32], subset[32], shaders[32];
    char run_id_hex[VW_HASH_HEX_BYTES], subset_hex[VW_HASH_HEX_BYTES], shaders_hex[VW_HASH_HEX_BYTES], scene_hex[VW_HASH_HEX_BYTES];
    char started_utc[UTC_BYTES];
    enum vw_status status = vw_trainer_run_id(run->trainer, run_id);
    if (status) return status;
    vw_trainer_subset_hash(run->trainer, subset);
    vw_shader_hash(shaders);
    vw_hash_to_hex(run_id, run_id_hex);
    vw_hash_to_hex(subset, subset_hex);
    vw_hash_to_hex(shaders, shaders_hex);
    vw_hash_to_hex(run->scene->hash, scene_hex);
    format_utc_now(started_utc);
    char *config_json = vw_config_to_json(&run->options->config, false);
    char *scene_options_json = vw_scene_options_to_json(run->options);
    const struct vw_ledger_run row = {
        .run_id = run_id_hex,
        .scene_hash = scene_hex,
        .scene_path = run->scene->path,
        .seed = (int64_t)run->options->config.seed,
        .config_json = config_json,
        .subset_hash = subset_hex,
        .device = device->name,
        .driver = device->driver,
        .shader_hash = shaders_hex,
        .version = vw_version(),
        .started_utc = started_utc,
        .scene_options_json = scene_options_json,
    };
    if (!config_json || !scene_options_json) status = VW_ERROR_MEMORY;
    else status = vw_ledger_create(run->ledger_path, &row, images, run->scene->view_count, &run->ledger);
    free(scene_options_json);
    free(config_json);
    return status;
}

static enum vw_status create_ledger(struct vw_training_run *run) {
    struct vw_ledger_image *images = NULL;
    char(*hashes)[VW_HASH_HEX_BYTES] = NULL;
    bool existed = vw_folder_exists(run->options->out);
    enum vw_status status = list_images(run->scene, &images, &hashes);
    if (!status) status = vw_folder_create(run->options->out);
    if (!status) status = write_first_rows(run, images);
    if (status && !existed) rmdir(run->options->out); // leaves it when something else came to be in it
    free(images);
    free(hashes);
    return status;
}

// Closes the books on a run that stops early; the message of what stopped it stays.
static void finish_early(struct vw_training_run *run, enum vw_status status) {
    char finished_utc[UTC_BYTES];
    format_utc_now(finished_utc);
    char *message = vw_copy_text(vw_error_message());
    const char *outcome = status == VW_ERROR_INTERRUPTED ? "interrupted" : "failed";
    if (vw_ledger_finish(run->ledger, outcome, finished_utc, NULL, 0)) vw_log_warning("%s", vw_error_message());
    if (message) vw_fail(status, "%s", message);
    free(message);
}

// ---- The steps --------------------------------------------------------------------------------------------------------

// Notes what a recorded batch says of the run so far, for the progress display and the end.
static void follow(struct vw_training_run *run, const struct vw_step_record *records, uint32_t count, struct vw_progress *progress) {
    if (records[0].step == 0) run->first_val_psnr_db = records[0].val_psnr;
    const struct vw_step_record *last = &records[count - 1];
    run->done_steps = last->step;
    for (uint32_t i = 0; i < count; i++)
        if (isfinite(records[i].val_psnr)) run->last_val_psnr_db = records[i].val_psnr;
    progress->done_steps = last->step;
    progress->epoch = last->epoch;
    progress->val_psnr_db = run->last_val_psnr_db;
    vw_progress_update(progress);
}

static enum vw_status check_interrupt(const struct vw_training_run *run) {
    if (!vw_interrupt_requested()) return VW_OK;
    return vw_fail(VW_ERROR_INTERRUPTED, "interrupted after step %" PRIu64 "; %s keeps the steps so far", run->done_steps,
                   run->ledger_path);
}

enum vw_status vw_training_take_steps(struct vw_training_run *run) {
    uint32_t validation_count = 0, count = 0;
    const uint32_t *validation_views = vw_trainer_validation_views(run->trainer, &validation_count);
    const struct vw_step_record *records = NULL;
    struct vw_progress progress = {
        .total_steps = vw_trainer_total_steps(run->trainer),
        .epochs = run->options->config.epochs,
        .val_psnr_db = NAN,
    };
    vw_interrupt_watch();
    vw_progress_begin(&progress);
    enum vw_status status = vw_trainer_advance(run->trainer, &records, &count);
    if (!status) status = create_ledger(run);
    if (status) return status;
    while (!status && count > 0) {
        status = vw_ledger_append(run->ledger, records, count, validation_views);
        if (!status) follow(run, records, count, &progress);
        if (!status) status = check_interrupt(run);
        if (!status) status = vw_trainer_advance(run->trainer, &records, &count);
    }
    vw_progress_end(&progress);
    if (status) finish_early(run, status);
    return status;
}

static void say_oddities(const struct vw_trainer *trainer) {
    struct vw_trainer_stats stats;
    vw_trainer_get_stats(trainer, &stats);
    if (stats.nonfinite_steps > 0)
        vw_log_warning("%" PRIu64 " steps were not finite and carry no value (step.nonfinite in the ledger); a lower --lr may help",
                       stats.nonfinite_steps);
    if (stats.floored_steps > 0)
        vw_log_info("%" PRIu64 " steps have validation photos matched beyond 100 dB, where PSNR is cut (step.floored in the ledger)",
                    stats.floored_steps);
    if (stats.clamped_count > 0)
        vw_log_info("%" PRIu64 " gradient contributions were clamped to the fixed-point range (step.clamped in the ledger)",
                    stats.clamped_count);
}

// The outputs come first: a run that the ledger calls finished has them.
enum vw_status vw_training_finish(struct vw_training_run *run, const struct vw_ledger_score *scores, uint32_t score_count,
                                  const struct vw_ledger_image *images, uint32_t image_count) {
    char finished_utc[UTC_BYTES];
    format_utc_now(finished_utc);
    enum vw_status status = vw_trainer_save_field(run->trainer, run->field_path);
    if (!status && images) status = vw_report_write_csv(run->scores_path, scores, score_count, images, image_count);
    if (!status) status = vw_ledger_finish(run->ledger, "finished", finished_utc, scores, score_count);
    if (status) finish_early(run, status);
    else say_oddities(run->trainer);
    return status;
}

json_t *vw_training_to_json(const struct vw_training_run *run) {
    uint8_t run_id[32];
    char run_id_hex[VW_HASH_HEX_BYTES];
    if (vw_trainer_run_id(run->trainer, run_id)) return NULL; // short of memory
    vw_hash_to_hex(run_id, run_id_hex);
    const struct vw_gpu_info *device = vw_gpu_get_info(run->gpu);
    return json_pack("{s:s, s:s, s:s, s:s, s:I, s:o, s:s, s:s}", "run_id", run_id_hex, "scene", run->scene->path, "device", device->name,
                     "driver", device->driver, "steps", (json_int_t)run->done_steps, "effects",
                     vw_effects_to_json(run->effects, run->effect_count), "ledger", run->ledger_path, "field", run->field_path);
}
