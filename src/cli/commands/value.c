#include "viewworth/value.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "run/plan/plan.h"
#include "cli/commands/commands.h"
#include "cli/output/json_output.h"
#include "run/probe_costs.h"
#include "run/outputs/report_folder.h"
#include "run/scoring.h"
#include "run/outputs/attribution.h"
#include "run/training_run.h"
#include "run/until_stable.h"
#include "run/outputs/validation_views.h"
#include "viewworth/log.h"
#include "base/memory.h"

enum { SHOWN_AT_EACH_END = 5 };

// The scores of vw_value_default_method, best first.
struct ranking {
    const struct vw_ledger_score **scores; // owned array
    uint32_t count;
};

// What the run says beyond its scores.
struct findings {
    const struct vw_noise_floor *noise_floor;
    struct vw_probe_costs probe_costs;
    struct vw_attribution attribution;
    struct vw_validation_report validation;
    char *report_path; // owned; NULL: none was written
};

static int compare_scores(const void *left, const void *right) {
    const struct vw_ledger_score *a = *(const struct vw_ledger_score *const *)left,
                                 *b = *(const struct vw_ledger_score *const *)right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

static enum vw_status rank(const struct vw_ledger_score *scores, uint32_t score_count, struct ranking *ranking) {
    ranking->scores = vw_allocate(score_count, sizeof *ranking->scores);
    if (!ranking->scores) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, vw_value_default_method) == 0) ranking->scores[ranking->count++] = &scores[i];
    qsort(ranking->scores, ranking->count, sizeof *ranking->scores, compare_scores);
    return VW_OK;
}

// How many photos to show at each end, so that none is shown at both unless it is the only one.
static uint32_t count_shown(const struct ranking *ranking) {
    uint32_t half = ranking->count > 1 ? ranking->count / 2 : ranking->count;
    return half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END;
}

static void print_photo(const struct vw_scene *scene, const struct vw_ledger_score *score) {
    const struct vw_view *view = &scene->views[score->image_id];
    printf("  %+9.4f ", score->value);
    if (isfinite(score->ci_low) && isfinite(score->ci_high)) printf("[%+9.4f, %+9.4f] ", score->ci_low, score->ci_high);
    printf("%s", score->unit);
    if (score->rank_ci_low) printf("  rank %u-%u", score->rank_ci_low, score->rank_ci_high);
    if (isfinite(score->resampling_stderr)) printf("  sampling ± %.4f", score->resampling_stderr);
    printf("  %s", view->name);
    if (view->ground_truth) printf(" (%s)", view->ground_truth);
    putchar('\n');
}

static void print_ranking(const struct vw_scene *scene, const struct ranking *ranking) {
    uint32_t shown = count_shown(ranking);
    if (!shown) return;
    printf("most valuable photos (%s, positive = helps; 95 %% intervals of score and rank)\n", vw_value_default_method);
    for (uint32_t i = 0; i < shown; i++) print_photo(scene, ranking->scores[i]);
    printf("least valuable photos\n");
    for (uint32_t i = 0; i < shown; i++) print_photo(scene, ranking->scores[ranking->count - 1 - i]);
}

static void print_noise_floor(const struct vw_noise_floor *floor) {
    printf("noise floor  validating once more moves PSNR by %g dB (%" PRIu64
           " times), a step with learning rate 0 by %g dB (%" PRIu64
           " times)\n             other pixels of the same photo move a step's delta by %.2g dB, %.2g of mean absolute "
           "error (%" PRIu64 " redraws)\n",
           floor->repeated_db, floor->repeated_count, floor->zero_learning_rate_db, floor->zero_learning_rate_count,
           floor->resampled_db, floor->resampled_l1, floor->resampled_count);
}

static void print_head(const struct vw_ledger *ledger) {
    char head[VW_HASH_HEX_BYTES];
    vw_ledger_chain_head(ledger, head);
    printf("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", head);
}

static void print_text(const struct vw_training_run *run, const struct ranking *ranking,
                       const struct findings *findings) {
    const struct vw_noise_floor *floor = findings->noise_floor;
    print_ranking(run->scene, ranking);
    vw_attribution_print(&findings->attribution);
    vw_until_stable_print(run);
    vw_plan_print(run->options);
    if (run->options->config.noise_floor && floor->repeated_count > 0) print_noise_floor(floor);
    else if (run->options->config.noise_floor) printf("noise floor  no step was probed; take more --epochs\n");
    vw_probe_costs_print(&findings->probe_costs);
    printf("validation PSNR  %.2f dB before training, %.2f dB after %" PRIu64 " steps\n",
           run->statistics.first_val_psnr_db, run->statistics.last_val_psnr_db, run->statistics.steps);
    vw_validation_report_print(&findings->validation);
    printf("ledger   %s\nscores   %s\nfield    %s\n", run->ledger_path, run->scores_path, run->field_path);
    if (findings->report_path) printf("report   %s\n", findings->report_path);
    print_head(run->ledger);
    vw_profile_print(&run->profile);
}

static json_t *photo_to_json(const struct vw_scene *scene, const struct vw_ledger_score *score) {
    const struct vw_view *view = &scene->views[score->image_id];
    return json_pack("{s:s, s:s, s:s?, s:s, s:o, s:s, s:o, s:o, s:o, s:I, s:I, s:o, s:I}", "name", view->name,
                     "provider", view->provider, "ground_truth", view->ground_truth, "method", score->method, "value",
                     vw_json_real(score->value), "unit", score->unit, "stderr", vw_json_real(score->standard_error),
                     "ci_low", vw_json_real(score->ci_low), "ci_high", vw_json_real(score->ci_high), "rank_ci_low",
                     (json_int_t)score->rank_ci_low, "rank_ci_high", (json_int_t)score->rank_ci_high,
                     "resampling_stderr", vw_json_real(score->resampling_stderr), "visits", (json_int_t)score->visits);
}

static json_t *photos_to_json(const struct vw_scene *scene, const struct ranking *ranking, bool from_best) {
    json_t *array = json_array();
    for (uint32_t i = 0; array && i < count_shown(ranking); i++) {
        json_t *photo = photo_to_json(scene, ranking->scores[from_best ? i : ranking->count - 1 - i]);
        if (json_array_append_new(array, photo)) {
            json_decref(array);
            array = NULL;
        }
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

static enum vw_status print_json(const struct vw_training_run *run, const struct ranking *ranking,
                                 const struct findings *findings) {
    const struct vw_probe_costs *costs = &findings->probe_costs;
    json_t *root = vw_training_to_json(run);
    json_t *values =
        json_pack("{s:s, s:s*, s:o, s:o, s:o*, s:o*, s:o*, s:o*, s:o, s:o}", "scores", run->scores_path, "report",
                  findings->report_path, "val_psnr_start_db", vw_json_real(run->statistics.first_val_psnr_db),
                  "val_psnr_end_db", vw_json_real(run->statistics.last_val_psnr_db), "noise_floor",
                  run->options->config.noise_floor ? noise_floor_to_json(findings->noise_floor) : NULL, "stability",
                  vw_until_stable_to_json(run), "same_state", vw_probe_costs_same_state_to_json(costs), "first_order",
                  vw_probe_costs_first_order_to_json(costs), "most_valuable", photos_to_json(run->scene, ranking, true),
                  "least_valuable", photos_to_json(run->scene, ranking, false));
    bool failed = !root || json_object_update(root, values) || !vw_attribution_add_json(&findings->attribution, root) ||
                  !vw_validation_report_add_json(&findings->validation, root) || !vw_plan_add_json(run->options, root);
    json_decref(values);
    if (!failed) return vw_json_print(root);
    json_decref(root);
    return vw_json_print(NULL);
}

static char *write_report(const struct vw_training_run *run) {
    return vw_report_folder_finish(
        run->options->out,
        &(struct vw_report_options){.scene = run->scene, .no_thumbnails = run->options->no_thumbnails});
}

// Keeps the scores, and writes and prints the outputs.
static enum vw_status finish(struct vw_training_run *run) {
    struct vw_scoring scoring;
    struct ranking ranking = {0};
    enum vw_status status = vw_training_score_and_finish(run, &scoring);
    struct findings findings = {.noise_floor = &scoring.noise_floor,
                                .probe_costs =
                                    vw_probe_costs_count(&scoring.input, run->trainer, vw_now_s() - run->opened_s)};
    if (!status) status = rank(scoring.scores, scoring.score_count, &ranking);
    if (!status) status = vw_attribution_make(run, &scoring, vw_value_default_method, &findings.attribution);
    if (!status) status = vw_validation_report_make(run, &scoring, &findings.validation);
    if (!status) findings.report_path = write_report(run);
    if (!status && run->options->json) status = print_json(run, &ranking, &findings);
    else if (!status) print_text(run, &ranking, &findings);
    free(findings.report_path);
    vw_validation_report_free(&findings.validation);
    vw_attribution_free(&findings.attribution);
    free(ranking.scores);
    vw_scoring_free(&scoring);
    return status;
}

static enum vw_status make_run(const struct vw_options *options, struct vw_session *session) {
    struct vw_training_run run;
    uint32_t epochs = vw_plan_epochs_most(options), burn_in = options->config.burn_in_epochs;
    if (epochs <= burn_in)
        vw_log_warning(
            "--epochs %u leaves no epoch after --burn-in %u: steps are recorded, but there will be no scores", epochs,
            burn_in);
    enum vw_status status = vw_training_open(options, true, session, &run);
    if (!status) status = vw_attribution_check_scene(options, run.scene);
    if (!status) status = vw_training_take_steps(&run);
    if (!status) status = finish(&run);
    vw_training_close(&run);
    return status;
}

enum vw_status vw_command_value(const struct vw_options *options) {
    struct vw_options chosen = *options; // with what --accuracy and --budget choose
    struct vw_plan choice = {.started_s = vw_now_s()};
    struct vw_session session = {0};
    enum vw_status status = vw_attribution_check_options(options);
    if (!status) status = vw_until_stable_check_option(options);
    if (!status) status = vw_plan_make(&chosen, &session, &choice);
    if (!status) status = make_run(&chosen, &session);
    vw_session_close(&session);
    vw_plan_free(&choice);
    return status;
}
