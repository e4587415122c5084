#include "cli/output/run_output.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/output/attribution_output.h"
#include "cli/output/json_output.h"
#include "cli/output/lasting_output.h"
#include "cli/output/plan_output.h"
#include "cli/output/print.h"
#include "cli/output/probe_costs_output.h"
#include "cli/output/profile_output.h"
#include "cli/output/stability_output.h"
#include "cli/output/validation_views_output.h"
#include "detect/effects_text.h"

enum { SHOWN_AT_EACH_END = 5 };

// The scores of vw_value_default_method, and `quality`, best first. Borrowed from the run.
struct ranking {
    const struct vw_ledger_score *scores, *qualities;
    uint32_t count, quality_count;
};

// Returns the quality of a photo, or NAN if it has none.
static double quality_of(const struct ranking *ranking, uint32_t image_id) {
    for (uint32_t i = 0; i < ranking->quality_count; i++)
        if (ranking->qualities[i].image_id == image_id && ranking->qualities[i].visits)
            return ranking->qualities[i].value;
    return NAN;
}

// ---- Text ----------------------------------------------------------------------------------------------------------

// Returns how many photos to show at each end, so that none is shown at both unless it is the only one.
static uint32_t count_shown(const struct ranking *ranking) {
    uint32_t half = ranking->count > 1 ? ranking->count / 2 : ranking->count;
    return half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END;
}

static void print_photo(const struct vw_scene *scene, const struct vw_ledger_score *score, double quality) {
    const struct vw_view *view = &scene->views[score->image_id];
    vw_print("  %+9" VW_SCORE_DIGITS "f ", score->value);
    if (isfinite(score->ci_low) && isfinite(score->ci_high))
        vw_print("[%+9" VW_SCORE_DIGITS "f, %+9" VW_SCORE_DIGITS "f] ", score->ci_low, score->ci_high);
    vw_print("%s", score->unit);
    if (score->rank_ci_low) vw_print("  rank %u-%u", score->rank_ci_low, score->rank_ci_high);
    if (isfinite(quality)) vw_print("  quality %.2f", quality);
    if (isfinite(score->resampling_stderr)) vw_print("  sampling ± %.4f", score->resampling_stderr);
    vw_print("  %s", view->name);
    if (view->ground_truth) vw_print(" (%s)", view->ground_truth);
    vw_print("\n");
}

static void print_ranked(const struct vw_scene *scene, const struct ranking *ranking, uint32_t place) {
    const struct vw_ledger_score *score = &ranking->scores[place];
    print_photo(scene, score, quality_of(ranking, score->image_id));
}

static void print_ranking(const struct vw_scene *scene, const struct ranking *ranking) {
    uint32_t shown = count_shown(ranking);
    if (!shown) return;
    vw_print("highest credit (%s: what the steps on the photo moved; 95 %% intervals of score and rank)\n",
             vw_value_default_method);
    for (uint32_t i = 0; i < shown; i++) print_ranked(scene, ranking, i);
    vw_print("lowest credit\n");
    for (uint32_t i = 0; i < shown; i++) print_ranked(scene, ranking, ranking->count - 1 - i);
}

static void print_noise_floor(const struct vw_noise_floor *floor) {
    vw_print(
        "noise floor  validating once more moves PSNR by %g dB (%" PRIu64
        " times), a step with learning rate 0 by %g dB (%" PRIu64
        " times)\n             other pixels of the same photo move a step's delta by %.2g dB, %.2g of mean absolute "
        "error (%" PRIu64 " resampled steps)\n",
        floor->repeated_db, floor->repeated_count, floor->zero_learning_rate_db, floor->zero_learning_rate_count,
        floor->resampled_db, floor->resampled_l1, floor->resampled_count);
}

static void print_valued(const struct vw_run_results *results, const struct ranking *ranking) {
    const struct vw_noise_floor *floor = &results->scoring.noise_floor;
    print_ranking(results->scene, ranking);
    if (results->lasting.sweep.step_count) vw_lasting_print(&results->lasting);
    vw_attribution_print(&results->attribution);
    if (results->until_stable > 0) vw_stability_print(&results->stability, results->until_stable, results->config);
    if (results->plan.record) vw_plan_print(&results->plan, results->config);
    if (results->config->noise_floor && floor->repeated_count > 0) print_noise_floor(floor);
    else if (results->config->noise_floor) vw_print("noise floor  no step was probed; take more --epochs\n");
    vw_probe_costs_print(&results->probe_costs);
    vw_print("validation PSNR  %.2f dB before training, %.2f dB after %" PRIu64 " steps\n",
             results->statistics.first_val_psnr_db, results->statistics.last_val_psnr_db, results->statistics.steps);
    vw_validation_views_print(&results->validation);
    vw_print("ledger   %s\nscores   %s\nfield    %s\n", results->ledger_path, results->scores_path,
             results->field_path);
    if (results->report_path) vw_print("report   %s\n", results->report_path);
    vw_print("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", results->head);
}

static void print_trained(const struct vw_run_results *results) {
    vw_print("%" PRIu64 " steps taken\nledger   %s\nfield    %s\n", results->statistics.steps, results->ledger_path,
             results->field_path);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *photo_to_json(const struct vw_scene *scene, const struct vw_ledger_score *score, double quality) {
    const struct vw_view *view = &scene->views[score->image_id];
    return json_pack("{s:s, s:s, s:s?, s:s, s:o, s:s, s:o, s:o, s:o, s:I, s:I, s:o, s:I, s:o}", "name", view->name,
                     "provider", view->provider, "ground_truth", view->ground_truth, "method", score->method, "value",
                     vw_json_real(score->value), "unit", score->unit, "stderr", vw_json_real(score->standard_error),
                     "ci_low", vw_json_real(score->ci_low), "ci_high", vw_json_real(score->ci_high), "rank_ci_low",
                     (json_int_t)score->rank_ci_low, "rank_ci_high", (json_int_t)score->rank_ci_high,
                     "resampling_stderr", vw_json_real(score->resampling_stderr), "visits", (json_int_t)score->visits,
                     "quality", vw_json_real(quality));
}

static json_t *photos_to_json(const struct vw_scene *scene, const struct ranking *ranking, bool from_best) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count_shown(ranking); i++) {
        const struct vw_ledger_score *score = &ranking->scores[from_best ? i : ranking->count - 1 - i];
        vw_json_append(&array, photo_to_json(scene, score, quality_of(ranking, score->image_id)));
    }
    return array;
}

static json_t *noise_floor_to_json(const struct vw_noise_floor *floor) {
    return json_pack("{s:I, s:o, s:I, s:o, s:I, s:o, s:o}", "repeated_count", (json_int_t)floor->repeated_count,
                     "repeated_db", vw_json_real(floor->repeated_db), "zero_learning_rate_count",
                     (json_int_t)floor->zero_learning_rate_count, "zero_learning_rate_db",
                     vw_json_real(floor->zero_learning_rate_db), "resampled_count", (json_int_t)floor->resampled_count,
                     "resampled_db", vw_json_real(floor->resampled_db), "resampled_l1",
                     vw_json_real(floor->resampled_l1));
}

static json_t *run_to_json(const struct vw_run_results *results) {
    json_t *profile = results->profile.row_count ? vw_profile_to_json(&results->profile) : NULL;
    return json_pack("{s:s, s:s, s:s, s:s, s:I, s:o, s:s, s:s, s:s, s:o*}", "run_id", results->run_id, "scene",
                     results->scene->path, "device", results->device->name, "driver", results->device->driver, "steps",
                     (json_int_t)results->statistics.steps, "effects",
                     vw_effects_to_json(results->effects, results->effect_count), "ledger", results->ledger_path,
                     "field", results->field_path, "head", results->head, "profile", profile);
}

static json_t *values_to_json(const struct vw_run_results *results, const struct ranking *ranking) {
    const struct vw_probe_costs *costs = &results->probe_costs;
    json_t *noise_floor = results->config->noise_floor ? noise_floor_to_json(&results->scoring.noise_floor) : NULL;
    json_t *stability =
        results->until_stable > 0 ? vw_stability_to_json(&results->stability, results->until_stable) : NULL;
    return json_pack("{s:s, s:s*, s:o, s:o, s:o*, s:o*, s:o*, s:o, s:o}", "scores", results->scores_path, "report",
                     results->report_path, "val_psnr_start_db", vw_json_real(results->statistics.first_val_psnr_db),
                     "val_psnr_end_db", vw_json_real(results->statistics.last_val_psnr_db), "noise_floor", noise_floor,
                     "stability", stability, "same_state", vw_probe_costs_same_state_to_json(costs), "most_valuable",
                     photos_to_json(results->scene, ranking, true), "least_valuable",
                     photos_to_json(results->scene, ranking, false));
}

static bool add_values(const struct vw_run_results *results, const struct ranking *ranking, json_t *root) {
    json_t *values = values_to_json(results, ranking);
    bool added = !json_object_update(root, values) && vw_attribution_add_json(&results->attribution, root) &&
                 vw_validation_views_add_json(&results->validation, root) &&
                 (!results->lasting.sweep.step_count ||
                  !json_object_set_new(root, "lasting", vw_lasting_to_json(&results->lasting))) &&
                 (!results->plan.record || vw_plan_add_json(&results->plan, results->config, root));
    json_decref(values);
    return added;
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_run_print(const struct vw_run *run, bool trained_only, bool json) {
    const struct vw_run_results *results = vw_run_get_results(run);
    struct ranking ranking = {0};
    enum vw_status status = trained_only ? VW_OK : vw_run_scores(run, NULL, &ranking.scores, &ranking.count);
    if (!status && !trained_only) status = vw_run_scores(run, "quality", &ranking.qualities, &ranking.quality_count);
    if (status) return status;
    if (json) {
        json_t *root = run_to_json(results);
        if (root && !trained_only && !add_values(results, &ranking, root)) {
            json_decref(root);
            root = NULL;
        }
        return vw_json_print(root);
    }
    if (trained_only) print_trained(results);
    else print_valued(results, &ranking);
    if (results->profile.row_count) vw_profile_print(&results->profile);
    return VW_OK;
}
