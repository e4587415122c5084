#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "report/page.h"
#include "run/lasting/lasting.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/report_folder.h"
#include "run/outputs/residuals.h"
#include "run/outputs/scene_map.h"
#include "run/run_private.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

// ---- Ending --------------------------------------------------------------------------------------------------------

static void log_statistics(const struct vw_step_statistics *statistics) {
    if (statistics->nonfinite > 0)
        vw_log_warning(
            "%" PRIu64
            " steps were not finite and carry no value (step.nonfinite in the ledger); a lower --lr may help",
            statistics->nonfinite);
    if (statistics->floored > 0)
        vw_log_info("%" PRIu64 " steps have validation photos matched beyond 100 dB, where PSNR is cut (step.floored "
                    "in the ledger)",
                    statistics->floored);
    if (statistics->clamped > 0)
        vw_log_info("%" PRIu64
                    " gradient contributions were clamped to the fixed-point range (step.clamped in the ledger)",
                    statistics->clamped);
}

static enum vw_status log_corrections(const struct vw_run *run) {
    struct vw_camera_corrections by;
    if (!vw_effects_is_on(run->effects, run->effect_count, "pose")) return VW_OK;
    enum vw_status status = vw_trainer_camera_corrections(run->trainer, &by);
    if (!status)
        vw_log_info(
            "pose     cameras are turned by %.2f degrees on average, at most %.2f; moved by %.2g of a box edge, "
            "at most %.2g",
            by.mean_deg, by.largest_deg, by.mean_edges, by.largest_edges);
    return status;
}

// Refuses to end a run that has come to nothing, which may be too short to be given up on its way.
static enum vw_status check_finite(const struct vw_run *run) {
    if (!vw_step_statistics_are_void(&run->results.statistics)) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "no step was finite, so that there is no result; %s keeps them; try a lower --lr",
                   run->results.ledger_path);
}

// Writes the outputs before the end of the ledger, so that a finished run has them, and none of an earlier end.
static enum vw_status end(struct vw_run *run) {
    if (run->complete || run->ended) return VW_OK;
    const struct vw_scoring *scoring = &run->results.scoring;
    enum vw_status status = check_finite(run);
    if (!status) status = vw_run_remove_outdated(run->out);
    if (!status) status = vw_trainer_save_field(run->trainer, run->results.field_path); // the ledger's end has its hash
    if (!status && run->validate)
        status = vw_report_write_csv(run->results.scores_path, scoring->scores, scoring->score_count,
                                     scoring->input.images, scoring->input.image_count);
    char finished_utc[VW_UTC_BYTES];
    vw_utc_now(finished_utc);
    if (!status)
        status = vw_ledger_finish(run->ledger, "finished", finished_utc, scoring->scores, scoring->score_count);
    if (status) vw_run_end_early(run, status);
    else vw_run_save_checkpoint(run); // when the run ends before its last step
    if (!status) log_statistics(&run->results.statistics);
    if (!status) status = log_corrections(run);
    run->ended = !status;
    return status;
}

// ---- Scores --------------------------------------------------------------------------------------------------------

static enum vw_status score(struct vw_run *run) {
    if (run->scored || !run->validate) return VW_OK;
    enum vw_status status = vw_scoring_make(run->ledger, &run->config, &run->results.scoring);
    if (!status) status = vw_run_rank(run);
    run->scored = !status;
    return status;
}

static enum vw_status check_order(struct vw_run *run) {
    if (run->failed) return vw_fail(VW_ERROR_USAGE, "vw_run_finish: the run has failed; close it and resume it");
    if (!run->ledger) return vw_fail(VW_ERROR_USAGE, "vw_run_finish: no step is recorded; call vw_run_advance first");
    return VW_OK;
}

static enum vw_status name_end(struct vw_run *run) {
    struct vw_ledger_run row;
    enum vw_status status = vw_ledger_get_run(run->ledger, &row);
    if (status) return status;
    snprintf(run->results.run_id, sizeof run->results.run_id, "%s", row.run_id);
    vw_ledger_chain_head(run->ledger, run->results.head);
    return VW_OK;
}

static enum vw_status score_and_end(struct vw_run *run) {
    enum vw_status status = check_order(run);
    if (!status) status = vw_run_catch_up(run);
    if (!status) status = score(run);
    if (!status) status = end(run);
    if (!status && run->lasting.wanted) status = vw_run_backward(run);
    if (!status && run->validate) status = vw_lasting_summary_make(run->ledger, &run->results.lasting);
    if (!status) status = name_end(run);
    run->failed |= status && status != VW_ERROR_INTERRUPTED && run->ledger;
    return status;
}

enum vw_status vw_run_score(struct vw_run *run) {
    if (run->complete && !run->lasting.wanted) return VW_OK;
    enum vw_status status = score_and_end(run);
    run->finished |= !status;
    return status;
}

// ---- Tables and report ---------------------------------------------------------------------------------------------

// Writes the residuals. For a run that was complete, whose trainer is not at its last step, only if they are missing.
static enum vw_status write_residuals(struct vw_run *run, const struct vw_residuals_params *params) {
    if (run->report.no_thumbnails) return VW_OK;
    if (!run->complete) return vw_residuals_write(params);
    char *path = vw_path_join(run->out, VW_RESIDUALS_FILE);
    bool held = path && vw_file_exists(path);
    free(path);
    if (held) return VW_OK;
    enum vw_status status = vw_trainer_load_field(run->trainer, run->results.field_path);
    return status ? status : vw_residuals_write(params);
}

// Writes pictures of the scene and the field, so that the report can be made again without them.
static void write_pictures(struct vw_run *run) {
    const struct vw_residuals_params params = {
        .scene = run->scene,
        .trainer = run->trainer,
        .scoring = &run->results.scoring,
        .config = &run->config,
        .on_background = vw_effects_is_on(run->effects, run->effect_count, "background"),
        .fitted = vw_effects_fit_views(run->effects, run->effect_count),
        .out = run->out,
    };
    enum vw_status status = vw_scene_map_write(run->scene, run->out);
    if (!status) status = write_residuals(run, &params);
    if (status) vw_log_warning("the report lacks its map or renders: %s", vw_error_message());
}

static enum vw_status write_tables(struct vw_run *run) {
    enum vw_status status =
        vw_attribution_make(run->scene, &run->results.scoring, run->out, &run->payout, &run->results.attribution);
    if (!status)
        status = vw_validation_views_make(run->scene, run->ledger, &run->results.scoring, run->out,
                                          &run->results.validation);
    if (!status) write_pictures(run);
    const struct vw_report_params report = {.scene = run->scene, .options = run->report};
    if (!status) run->results.report_path = vw_report_folder_finish(run->out, &report);
    return status;
}

static enum vw_status write_checksums(const struct vw_run *run) {
    char head[VW_HASH_HEX_BYTES];
    vw_ledger_chain_head(run->ledger, head);
    return vw_checksums_write(run->out, head);
}

enum vw_status vw_run_finish(struct vw_run *run) {
    if (!run) return vw_fail(VW_ERROR_USAGE, "vw_run_finish: run is NULL; open one by vw_run_open");
    if (run->finished) return VW_OK;
    enum vw_status status = score_and_end(run);
    if (!status && run->validate) status = write_tables(run);
    if (!status) status = write_checksums(run);
    run->finished = !status;
    run->failed |= status && status != VW_ERROR_INTERRUPTED && run->ledger;
    return status;
}
