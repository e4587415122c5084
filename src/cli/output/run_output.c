#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/clock.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "detect/effects_text.h"
#include "report/advice.h"
#include "run/plan/accuracy_levels.h"
#include "scene/splits_file.h"

// ---- Parts of a run -------------------------------------------------------------------------------------------------

static void print_plan(const struct vw_plan *plan, const struct vw_config *config) {
    char text[VW_ACCURACY_TEXT_BYTES];
    vw_accuracy_options(config, text);
    if (vw_plan_keeps_time(plan))
        vw_print("budget   %.0f s; this command took %.1f s\n", plan->budget_s, vw_now_s() - plan->started_s);
    vw_print("again    the same bits by %s\n", text);
}

static void add_plan(const struct vw_plan *plan, const struct vw_config *config, json_t **root) {
    char text[VW_ACCURACY_TEXT_BYTES];
    vw_accuracy_options(config, text);
    json_t *object = json_pack("{s:f, s:s}", "took_s", vw_now_s() - plan->started_s, "options", text);
    if (json_object_update_missing(object, plan->record)) {
        json_decref(object); // NULL is allowed
        object = NULL;
    }
    vw_json_set(root, json_object_get(plan->record, "budget_s") ? "budget" : "accuracy", object);
}

static double time_of_passes(const struct vw_run_results *results) {
    double ms = 0;
    for (uint32_t i = 0; i < results->pass_count; i++) ms += results->passes[i].total_ms;
    return ms;
}

static void print_profile(const struct vw_run_results *results) {
    if (results->pass_count) vw_print("pass                         dispatches  ms each  share\n");
    for (uint32_t i = 0; i < results->pass_count; i++) {
        const struct vw_gpu_timer *pass = &results->passes[i];
        char name[48];
        snprintf(name, sizeof name, "%s%s%s", pass->name, pass->role ? ", " : "", pass->role ? pass->role : "");
        vw_print("%-28s %10" PRIu64 "  %7.3f  %4.1f%%\n", name, pass->dispatches,
                 pass->total_ms / (double)pass->dispatches, 100 * pass->total_ms / time_of_passes(results));
    }
}

static json_t *profile_to_json(const struct vw_run_results *results) {
    json_t *passes = json_array();
    for (uint32_t i = 0; i < results->pass_count; i++) {
        const struct vw_gpu_timer *pass = &results->passes[i];
        vw_json_append(&passes,
                       json_pack("{s:s, s:s?, s:I, s:f, s:f}", "pass", pass->name, "role", pass->role, "dispatches",
                                 (json_int_t)pass->dispatches, "ms", pass->total_ms / (double)pass->dispatches, "share",
                                 pass->total_ms / time_of_passes(results)));
    }
    return passes;
}

// Says how far ranks can be believed, and why there are none.
static void print_agreement(const struct vw_ranking_agreement *agreement) {
    bool low = vw_ranking_agreement_is_low(agreement);
    if (isfinite(agreement->better_training) && !low)
        vw_print("ranks    by a training of ten times the cost would agree with these by about %.2f (Spearman)\n",
                 agreement->better_training);
    if (low && isnan(agreement->other_views))
        vw_print("no ranks by credit: so few photos cannot tell whether other validation photos would agree\n");
    if (isnan(agreement->other_views)) return;
    vw_print("%s by %u other validation photos would agree with these by %.2f to %.2f (90 %%, about %.2f)%s\n",
             low ? "no ranks by credit: those" : "ranks   ", agreement->view_count, agreement->other_views_low,
             agreement->other_views_high, agreement->other_views, low ? "; more of them tell more" : "");
}

// A validation photo: what the matrix and the cameras say of it.
struct view_row {
    const char *name;
    const struct vw_view_evidence *evidence;
    double distance; // over that between train photos; NaN: unknown
    bool far;
};

#define OF_VIEW(name, kind, member)                                                                                    \
    { VW_CELL_VIA(name, struct view_row, evidence, kind, struct vw_view_evidence, member) }
static const struct vw_column view_columns[] = {
    VW_COLUMN(struct view_row, TEXT, name),        OF_VIEW("psnr_end_db", REAL_OR_NULL, end_psnr),
    OF_VIEW("agreement", REAL_OR_NULL, agreement), OF_VIEW("ranking_without", REAL_OR_NULL, without),
    OF_VIEW("disagrees", FLAG, disagrees),         OF_VIEW("lone", FLAG, lone),
    OF_VIEW("stays_low", FLAG, stays_low),         VW_COLUMN(struct view_row, REAL_OR_NULL, distance),
    VW_COLUMN(struct view_row, FLAG, far),
};

static json_t *view_to_json(const struct vw_scene *scene, const struct vw_run_outputs *outputs, uint32_t place) {
    const struct vw_view_evidence *evidence = &outputs->results.views[place];
    struct view_row row = {.name = scene->views[evidence->image_id].name, .evidence = evidence, .distance = NAN};
    for (uint32_t i = 0; i < outputs->distance_count; i++)
        if (outputs->distances[i].view == evidence->image_id)
            row.distance = outputs->distances[i].ratio, row.far = outputs->distances[i].far;
    const struct vw_rows rows = VW_ROWS(view_columns, &row, 1);
    return vw_row_to_json(&rows, 0);
}

static void add_validation_views(const struct vw_scene *scene, const struct vw_run_outputs *outputs, json_t **root) {
    json_t *views = json_array();
    for (uint32_t v = 0; outputs->matrix_path && v < outputs->results.matrix.view_count; v++)
        vw_json_append(&views, view_to_json(scene, outputs, v));
    vw_json_set(root, "validation_views", views);
    if (outputs->matrix_path) vw_json_set(root, "matrix", vw_json_string(outputs->matrix_path));
}

static json_t *advice_to_json(const struct vw_results *results) {
    json_t *counts = json_object();
    struct vw_rows photos = vw_advice_rows(&results->advice);
    if (!results->score_count) photos.count = 0;
    for (enum vw_advice_word word = 0; word < VW_ADVICE_COUNT; word++) {
        uint32_t count = 0;
        for (uint32_t i = 0; i < photos.count; i++) count += results->advice.photos[i].advice == word;
        vw_json_set(&counts, vw_advice_words[word], json_integer(count));
    }
    return json_pack("{s:o, s:o}", "counts", counts, "photos", vw_rows_to_json(&photos));
}

// ---- Text ----------------------------------------------------------------------------------------------------------

static bool is_credit(const struct vw_ranking *ranking) {
    return ranking->count && strcmp(ranking->scores[0].method, vw_value_default_method) == 0;
}

// Prints the photos at both ends by the method that answers for their value.
static void print_ranking(const struct vw_run_results *results, const struct vw_ranking *ranking) {
    const char *method = ranking->count ? ranking->scores[0].method : "";
    if (strcmp(method, "lasting_psnr") == 0) vw_lasting_print(&results->lasting);
    else if (strcmp(method, "worth_psnr") == 0) vw_ranking_print(ranking, "highest worth", "lowest worth");
    else
        vw_ranking_print(ranking,
                         "highest credit (dv_psnr: what the steps on the photo moved, as a share of what the training "
                         "gained; 95 % intervals of score and rank)",
                         "lowest credit");
}

static void print_valued(const struct vw_run_results *results, const struct vw_ranking *ranking) {
    const struct vw_ranking_agreement *agreement = &results->outputs.results.agreement;
    print_agreement(agreement);
    if (!vw_ranking_agreement_is_low(agreement) || !is_credit(ranking)) print_ranking(results, ranking);
    vw_attribution_print(&results->outputs.attribution);
    if (vw_plan_has_level(&results->plan)) print_plan(&results->plan, results->config);
    vw_print("validation PSNR  %.2f dB before training, %.2f dB after %" PRIu64 " steps%s\n",
             results->statistics.first_val_psnr_db, results->statistics.last_val_psnr_db, results->statistics.steps,
             vw_scene_has_weights(results->scene) ? ", means weighted by photo" : "");
    vw_print("files    %s %s %s", results->ledger_path, results->scores_path, results->field_path);
    if (results->outputs.has_splats) vw_print(" %s", results->splats_path);
    if (results->outputs.matrix_path) vw_print(" %s", results->outputs.matrix_path);
    if (results->outputs.report_path) vw_print("\nreport   %s", results->outputs.report_path);
    vw_print("\n");
    vw_print("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", results->head);
}

static void print_trained(const struct vw_run_results *results) {
    vw_reconstruction_print(&results->outputs.results.reconstruction);
    vw_print("%" PRIu64 " steps taken\nledger   %s\nfield    %s\n", results->statistics.steps, results->ledger_path,
             results->field_path);
    if (results->outputs.has_splats) vw_print("splats   %s\n", results->splats_path);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static void add_values(const struct vw_run_results *results, const struct vw_ranking *ranking, json_t **root) {
    const struct vw_step_statistics *statistics = &results->statistics;
    vw_json_set(root, "scores", vw_json_string(results->scores_path));
    if (results->outputs.report_path) vw_json_set(root, "report", vw_json_string(results->outputs.report_path));
    vw_json_set(root, "val_psnr_start_db", vw_json_real(statistics->first_val_psnr_db));
    vw_json_set(root, "val_psnr_end_db", vw_json_real(statistics->last_val_psnr_db));
    vw_json_set(root, "most_valuable", vw_ranking_to_json(ranking, VW_RANKING_HIGHEST));
    vw_json_set(root, "least_valuable", vw_ranking_to_json(ranking, VW_RANKING_LOWEST));
    vw_json_set(root, "advice", advice_to_json(&results->outputs.results));
    vw_attribution_add_json(&results->outputs.attribution, root);
    vw_json_set(root, "verdict",
                vw_verdict_to_json(&results->outputs.results.reconstruction, &results->outputs.results.agreement));
    add_validation_views(results->scene, &results->outputs, root);
    if (results->lasting.pass.step_count) vw_json_set(root, "lasting", vw_lasting_to_json(&results->lasting));
    if (vw_plan_has_level(&results->plan)) add_plan(&results->plan, results->config, root);
}

// Returns the results; without a table those of a run that trained only.
static json_t *run_to_json(const struct vw_run_results *results, const struct vw_ranking *ranking) {
    json_t *root = json_pack("{s:s, s:s, s:s, s:s, s:I, s:o, s:s, s:s, s:s}", "run_id", results->run_id, "scene",
                             results->scene->path, "device", results->device->name, "driver", results->device->driver,
                             "steps", (json_int_t)results->statistics.steps, "effects",
                             vw_effects_to_json(results->effects, results->effect_count), "ledger",
                             results->ledger_path, "field", results->field_path, "head", results->head);
    if (results->outputs.has_splats) vw_json_set(&root, "splats", vw_json_string(results->splats_path));
    if (results->plan.record) vw_json_set(&root, "plan", json_incref(results->plan.record));
    if (results->pass_count) vw_json_set(&root, "profile", profile_to_json(results));
    if (ranking) add_values(results, ranking, &root);
    else vw_json_set(&root, "reconstruction", vw_reconstruction_to_json(&results->outputs.results.reconstruction));
    return root;
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_run_print(const struct vw_run *run, bool trained_only, bool json) {
    const struct vw_run_results *results = vw_run_get_results(run);
    const struct vw_step_statistics *statistics = &results->statistics;
    struct vw_ranking ranking = {.scene = results->scene,
                                 .gain_db = statistics->last_val_psnr_db - statistics->first_val_psnr_db};
    enum vw_status status = trained_only ? VW_OK : vw_run_scores(run, NULL, &ranking.scores, &ranking.count);
    if (!status && !trained_only) status = vw_run_scores(run, "quality", &ranking.qualities, &ranking.quality_count);
    if (status) return status;
    if (json) return vw_json_print(run_to_json(results, trained_only ? NULL : &ranking));
    if (trained_only) print_trained(results);
    else print_valued(results, &ranking);
    print_profile(results);
    return VW_OK;
}
