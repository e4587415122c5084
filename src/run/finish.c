#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "run/lasting/lasting.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/reconstruction.h"
#include "run/outputs/run_outputs.h"
#include "run/run_private.h"
#include "value/methods.h"
#include "viewworth/log.h"
#include "viewworth/value.h"

// ---- Scores and field ----------------------------------------------------------------------------------------------

// Ranks the scores of each method, which are neighbours.
static enum vw_status rank(struct vw_run *run) {
    const struct vw_scoring *scoring = &run->results.scoring;
    free(run->ranked);
    run->ranked = vw_allocate(scoring->score_count, sizeof *run->ranked);
    if (!run->ranked) return VW_ERROR_MEMORY;
    if (scoring->score_count) memcpy(run->ranked, scoring->scores, scoring->score_count * sizeof *run->ranked);
    for (uint32_t first = 0, last; first < scoring->score_count; first = last) {
        for (last = first + 1; last < scoring->score_count;)
            if (strcmp(run->ranked[last].method, run->ranked[first].method) != 0) break;
            else last++;
        qsort(&run->ranked[first], last - first, sizeof *run->ranked, vw_score_compare);
    }
    return VW_OK;
}

// Loads the field that the ledger names into the trainer; fails for any other file.
static enum vw_status load_field(struct vw_run *run) {
    struct vw_ledger_run row;
    enum vw_status status = vw_ledger_get_run(run->ledger, &row);
    if (!status) status = vw_checksums_check_field(run->out, row.field_sha256);
    return status ? status : vw_trainer_load_field(run->trainer, run->results.field_path);
}

// Removes all derived files and writes scores.csv, unless the run is one of `train`.
static enum vw_status write_scores(struct vw_run *run) {
    bool pays = run->payout_cents > 0;
    enum vw_status status = run->validate ? vw_run_scores_write(run->out, &run->results.scoring, pays)
                                          : vw_run_remove_derived(run->out, pays);
    run->written = !status;
    return status;
}

// ---- Ending --------------------------------------------------------------------------------------------------------

static void log_statistics(const struct vw_run *run) {
    const struct vw_step_statistics *statistics = &run->results.statistics;
    if (statistics->nonfinite > 0)
        vw_log_warning("%" PRIu64
                       " steps were not finite and carry no value (step.nonfinite in the ledger); %s may help",
                       statistics->nonfinite, vw_run_remedy(run));
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

// Refuses to end a run without a finite step; a short run may get here without being aborted.
static enum vw_status check_finite(const struct vw_run *run) {
    if (!vw_step_statistics_are_void(&run->results.statistics)) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "no step was finite, so that there is no result; %s keeps them; try %s",
                   run->results.ledger_path, vw_run_remedy(run));
}

// Saves the field; the ledger's end has its hash.
static enum vw_status save_field(struct vw_run *run) {
    char sha256[VW_HASH_HEX_BYTES];
    enum vw_status status = vw_trainer_save_field(run->trainer, run->results.field_path);
    if (!status) status = vw_checksums_hash(run->out, VW_FIELD_FILE, sha256);
    return status ? status : vw_ledger_set_field(run->ledger, sha256);
}

// Writes the outputs before the end of the ledger, so that a finished run has them, and none of an earlier end.
static enum vw_status end(struct vw_run *run) {
    if (run->complete) return load_field(run); // the trainer is not at its last step
    if (run->ended) return VW_OK;
    const struct vw_scoring *scoring = &run->results.scoring;
    enum vw_status status = check_finite(run);
    if (!status) status = vw_run_remove_outdated(run->out, run->payout_cents > 0);
    if (!status) status = save_field(run);
    if (!status) status = write_scores(run);
    char finished_utc[VW_UTC_BYTES];
    vw_utc_now(finished_utc);
    if (!status)
        status = vw_ledger_finish(run->ledger, "finished", finished_utc, scoring->scores, scoring->score_count);
    if (status) vw_run_end_early(run, status);
    else vw_run_save_checkpoint(run); // when the run ends before its last step
    if (!status) log_statistics(run);
    if (!status) status = log_corrections(run);
    run->ended = !status;
    return status;
}

// ---- Scores --------------------------------------------------------------------------------------------------------

static enum vw_status score(struct vw_run *run) {
    if (run->scored || !run->validate) return VW_OK;
    enum vw_status status = vw_scoring_make(run->ledger, &run->config, &run->results.scoring);
    if (!status && run->complete) // the ledger stays as it is, and is listed again
        status = vw_scoring_compare(&run->results.scoring, run->ledger, run->results.ledger_path);
    if (!status) status = rank(run);
    run->scored = !status;
    return status;
}

// ---- Lasting credit -------------------------------------------------------------------------------------------------

static enum vw_status record(struct vw_run *run, struct vw_lasting_pass *pass) {
    struct vw_scoring *scoring = &run->results.scoring;
    vw_lasting_pass_free(&scoring->input.lasting);
    scoring->input.lasting = *pass; // the scoring owns it now
    *pass = (struct vw_lasting_pass){0};
    enum vw_status status = vw_scoring_repeat(scoring);
    if (!status) status = rank(run);
    if (!status) status = write_scores(run);
    if (!status)
        status = vw_ledger_set_lasting(run->ledger, &scoring->input.lasting, scoring->scores, scoring->score_count);
    return status ? status : vw_file_remove(run->out, VW_LASTING_PASS_FILE);
}

// Sets the epochs that the run took: fewer than planned where it stopped early.
static enum vw_status take_epochs(struct vw_run *run) {
    uint64_t photos = vw_trainer_epoch_end(run->trainer, 1), steps = run->results.scoring.input.record_count - 1;
    if (steps == 0 || steps % photos != 0)
        return vw_fail(VW_ERROR_USAGE,
                       "%s: ends within an epoch, after step %" PRIu64 "; finish it by viewworth value --resume, then "
                       "run viewworth lasting",
                       run->results.ledger_path, steps);
    run->config.epochs = (uint32_t)(steps / photos);
    return VW_OK;
}

static enum vw_status make_of_run(struct vw_run *run, struct vw_lasting_pass *pass) {
    const struct vw_value_input *input = &run->results.scoring.input;
    const struct vw_trainer_params training = {.gpu = run->gpu,
                                               .scene = run->scene,
                                               .config = &run->config,
                                               .effects = run->effects,
                                               .effect_count = run->effect_count,
                                               .validate = true};
    const struct vw_backward_params params = {
        .training = &training,
        .recorded = {run->results.ledger_path, input->records, input->record_count},
        .options = run->lasting,
        .out = run->out,
        .progress = run->progress,
        .context = run->context};
    return vw_backward_make(&params, pass);
}

// Makes the pass over a run that has ended and is scored, unless its ledger has the result; scores it again and writes
// scores.csv. After an interruption the next pass continues from there.
static enum vw_status follow_back(struct vw_run *run) {
    struct vw_lasting_pass pass = {0};
    if (vw_lasting_is_there(&run->lasting, &run->config, &run->results.scoring.input.lasting)) {
        vw_log_info("lasting  %s has this result already", run->out);
        return VW_OK;
    }
    enum vw_status status = vw_lasting_check_config(&run->config);
    if (!status) status = take_epochs(run);
    if (!status) status = make_of_run(run, &pass);
    // The pictures of the report show the recorded field, in whatever state the pass left the trainer.
    if (!status) status = load_field(run);
    if (!status) status = record(run, &pass);
    vw_lasting_pass_free(&pass);
    return status;
}

// ---- Ending with scores --------------------------------------------------------------------------------------------

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
    if (!status && run->lasting.wanted) status = follow_back(run);
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

static enum vw_status make_outputs(struct vw_run *run) {
    const struct vw_run_outputs_params params = {.out = run->out,
                                                 .scene = run->scene,
                                                 .scene_options_json = run->scene_options_json,
                                                 .gpu = run->gpu,
                                                 .ledger = run->ledger,
                                                 .scoring = &run->results.scoring,
                                                 .trainer = run->trainer,
                                                 .config = &run->config,
                                                 .effects = run->effects,
                                                 .effect_count = run->effect_count,
                                                 .payout_cents = run->payout_cents,
                                                 .findings = run->findings,
                                                 .report = {.scene = run->scene, .options = run->report}};
    return vw_run_outputs_make(&params, &run->results.outputs);
}

// Makes what a run without validation has.
static enum vw_status make_outputs_of_training(struct vw_run *run) {
    struct vw_run_outputs *outputs = &run->results.outputs;
    const struct vw_reconstruction_params seen = {
        .scene = run->scene, .scene_options_json = run->scene_options_json, .gpu = run->gpu, .trainer = run->trainer};
    enum vw_status status = vw_run_splits_write(run->scene, run->out);
    if (!status) status = vw_run_splats_write(run->trainer, run->report.ply_degree, run->out, &outputs->has_splats);
    return status ? status : vw_reconstruction_measure(&seen, &outputs->results.reconstruction);
}

enum vw_status vw_run_finish(struct vw_run *run) {
    if (!run) return vw_fail(VW_ERROR_USAGE, "vw_run_finish: run is NULL; open one by vw_run_open");
    if (run->finished) return VW_OK;
    enum vw_status status = score_and_end(run);
    if (!status && !run->written) status = write_scores(run);
    if (!status) status = run->validate ? make_outputs(run) : make_outputs_of_training(run);
    if (!status) status = name_end(run); // a payout changes the head
    if (!status) status = vw_checksums_write(run->out, run->ledger);
    run->finished = !status;
    run->failed |= status && status != VW_ERROR_INTERRUPTED && run->ledger;
    return status;
}

// ---- Results -------------------------------------------------------------------------------------------------------

const struct vw_run_results *vw_run_get_results(const struct vw_run *run) { return &run->results; }

static bool is_of_method(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0;
}

enum vw_status vw_run_scores(const struct vw_run *run, const char *method, const struct vw_ledger_score **scores,
                             uint32_t *count) {
    if (!run || !run->finished)
        return vw_fail(VW_ERROR_USAGE, "vw_run_scores: the run has no scores yet; call vw_run_finish first");
    const char *wanted = method ? method : vw_value_main_method(run->ranked, run->results.scoring.score_count);
    uint32_t first = 0, end;
    while (first < run->results.scoring.score_count && !is_of_method(&run->ranked[first], wanted)) first++;
    for (end = first; end < run->results.scoring.score_count && is_of_method(&run->ranked[end], wanted);) end++;
    *scores = &run->ranked[first];
    *count = end - first;
    return VW_OK;
}

enum vw_status vw_run_images(const struct vw_run *run, const struct vw_ledger_image **images, uint32_t *count) {
    if (!run || !run->ledger)
        return vw_fail(VW_ERROR_USAGE, "vw_run_images: the run has no ledger yet; call vw_run_advance first");
    return vw_ledger_get_images(run->ledger, images, count);
}
