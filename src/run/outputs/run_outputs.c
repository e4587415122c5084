#include "run/outputs/run_outputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "check/table.h"
#include "image/image.h"
#include "report/advice.h"
#include "report/tables.h"
#include "run/out_folder.h"
#include "run/outputs/checksums.h"
#include "run/outputs/cover_masks.h"
#include "run/outputs/reconstruction.h"
#include "run/outputs/report_folder.h"
#include "run/outputs/residuals.h"
#include "run/outputs/results_files.h"
#include "scene/splits_file.h"
#include "scene/view_distance.h"
#include "viewworth/log.h"

enum vw_status vw_run_scores_write(const char *out, const struct vw_scoring *scoring, bool pays) {
    struct vw_csv_text table = {0};
    enum vw_status status = vw_run_remove_derived(out, pays);
    if (status) return status;
    status = vw_report_make_csv("scores.csv", scoring->scores, scoring->score_count, scoring->input.images,
                                scoring->input.image_count, &table);
    return vw_result_write_table(status, out, "scores.csv", &table);
}

enum vw_status vw_run_splits_write(const struct vw_scene *scene, const char *out) {
    char *text = NULL;
    enum vw_status status = vw_splits_file_make(scene, &text);
    if (!status) status = vw_result_write(out, VW_SPLITS_FILE, text, strlen(text));
    free(text);
    return status;
}

enum vw_status vw_run_splats_write(struct vw_trainer *trainer, uint32_t degree, const char *out, bool *written) {
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_trainer_make_splats(trainer, degree, &data, &size_bytes);
    *written = !status && data;
    if (*written) status = vw_result_write(out, VW_SPLATS_FILE, data, size_bytes);
    free(data);
    return status;
}

// ---- Validation photos ---------------------------------------------------------------------------------------------

static void warn_of_views(const struct vw_scene *scene, const struct vw_results *results) {
    for (uint32_t v = 0; vw_results_have_matrix(results) && v < results->matrix.view_count; v++) {
        const struct vw_view_evidence *view = &results->views[v];
        const char *name = scene->views[view->image_id].name;
        if (view->disagrees)
            vw_log_warning("validation photo %s looks corrupted: it ranks the photos as no other does (correlation "
                           "%.2f), and its PSNR ends at %.1f dB, below the others'; look at it, or leave it out by "
                           "--val",
                           name, view->agreement, view->end_psnr);
        if (view->lone)
            vw_log_info("validation photo %s probably sees what no other validation photo sees: it ranks the photos as "
                        "no other does (correlation %.2f), but its PSNR of %.1f dB is ordinary; keep it",
                        name, view->agreement, view->end_psnr);
        if (view->stays_low)
            vw_log_warning("validation photo %s looks corrupted: its PSNR ends at %.1f dB, far below the others'; look "
                           "at it, or leave it "
                           "out by --val",
                           name, view->end_psnr);
    }
}

static void warn_of_distances(const struct vw_scene *scene, const struct vw_run_outputs *outputs) {
    for (uint32_t i = 0; i < outputs->distance_count; i++) {
        const struct vw_view_distance *distance = &outputs->distances[i];
        if (distance->far)
            vw_log_warning("validation photo %s is far from all training photos: %.1f times their distance from each "
                           "other (the nearest, %s, looks %.0f degrees elsewhere); what it shows may be guesswork",
                           scene->views[distance->view].name, distance->ratio, scene->views[distance->nearest].name,
                           distance->angle_deg);
    }
}

// Logs a warning for each photo with a defect that judges others; advice has those that train.
static void warn_of_defects(const struct vw_scene *scene, const struct vw_photo_finding *findings) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        bool told = findings[v].word == vw_defect_words[VW_DEFECT_COPY]; // near-duplicates have a warning of their own
        if (findings[v].word && !told && (view->split == VW_SPLIT_VAL || view->split == VW_SPLIT_TEST))
            vw_log_warning("%s photo %s: %s (%s); look at it, or leave it out by --val or --test",
                           view->split == VW_SPLIT_VAL ? "validation" : "test", view->name, findings[v].word,
                           findings[v].description);
    }
}

// Computes the matrix, how far the ranking depends on each validation photo, and which look wrong; writes matrix.csv.
static enum vw_status judge_views(const struct vw_run_outputs_params *params, struct vw_run_outputs *outputs) {
    struct vw_results *results = &outputs->results;
    enum vw_status status = vw_results_measure(params->ledger, results);
    if (!status)
        status = vw_scene_view_distances(params->scene, VW_SPLIT_VAL, &outputs->distances, &outputs->distance_count);
    if (!status && vw_results_have_matrix(results)) {
        struct vw_csv_text table = {0};
        outputs->matrix_path = vw_path_join(params->out, "matrix.csv");
        if (!outputs->matrix_path) return VW_ERROR_MEMORY;
        status = vw_table_make_matrix(outputs->matrix_path, &results->matrix, results->standard_errors,
                                      results->input.images, results->input.image_count, &table);
        status = vw_result_write_table(status, params->out, "matrix.csv", &table);
    }
    if (status) return status;
    warn_of_views(params->scene, results);
    warn_of_distances(params->scene, outputs);
    uint32_t views = results->matrix.view_count;
    if (views && views < VW_AGREEMENT_VIEWS_MIN)
        vw_log_warning("%u validation photo%s the scores: one view may decide the ranking; name at least %d by --val",
                       views, views == 1 ? " makes" : "s make", VW_AGREEMENT_VIEWS_MIN);
    return VW_OK;
}

// ---- Scene and field -----------------------------------------------------------------------------------------------

enum vw_status vw_run_check_photos(const struct vw_scene *scene, const char *scene_options_json, struct vw_gpu *gpu,
                                   struct vw_photo_finding **findings) {
    const struct vw_reconstruction_params seen = {.scene = scene, .scene_options_json = scene_options_json, .gpu = gpu};
    struct vw_scene *sized = NULL; // as trained, photos may show too little
    enum vw_status status = vw_reconstruction_open_scene(&seen, &sized);
    if (!status) status = vw_photo_findings_make(sized ? sized : scene, findings);
    vw_scene_close(&sized);
    return status;
}

// Takes the findings that there are, or checks the photos.
static enum vw_status take_findings(const struct vw_run_outputs_params *params, struct vw_photo_finding **findings) {
    uint32_t count = params->scene->view_count;
    if (!params->findings) return vw_run_check_photos(params->scene, params->scene_options_json, params->gpu, findings);
    *findings = vw_allocate(count, sizeof **findings);
    if (*findings) memcpy(*findings, params->findings, count * sizeof **findings);
    return *findings ? VW_OK : VW_ERROR_MEMORY;
}

// Measures and pictures what a later report cannot, without scene and field, and writes it.
static enum vw_status look_at_field(const struct vw_run_outputs_params *params, struct vw_results *results,
                                    uint32_t *mask_count) {
    const struct vw_reconstruction_params seen = {
        .scene = params->scene,
        .scene_options_json = params->scene_options_json,
        .gpu = params->gpu,
        .trainer = params->trainer,
    };
    const struct vw_residuals_params residuals = {
        .panes = {.scene = params->scene,
                  .trainer = params->trainer,
                  .on_background = vw_effects_is_on(params->effects, params->effect_count, "background"),
                  .fitted = vw_effects_fit_views(params->effects, params->effect_count)},
        .scoring = params->scoring,
        .config = params->config,
    };
    struct vw_cover_params cover = {
        .panes = residuals.panes, .rays_most = vw_residuals_rays(params->scoring, params->config), .out = params->out};
    cover.panes.fitted = false; // but without what covers
    enum vw_status status = take_findings(params, &results->findings);
    if (!status) status = vw_reconstruction_measure(&seen, &results->reconstruction);
    if (!status) status = vw_cover_masks_make(&cover, results->findings, mask_count);
    if (!status) warn_of_defects(params->scene, results->findings);
    if (!status) results->map = vw_scene_map_make(params->scene, results->findings);
    if (!status && !params->report.options.no_thumbnails) status = vw_residuals_make(&residuals, &results->residuals);
    return status ? status : vw_results_write_files(results, params->scene, params->out);
}

// ---- Advice and report ---------------------------------------------------------------------------------------------

static enum vw_status write_advice(const struct vw_results *results, const char *out) {
    struct vw_csv_text table = {0};
    const struct vw_rows rows = vw_advice_rows(&results->advice);
    if (!results->score_count) return VW_OK;
    enum vw_status status = vw_rows_make_csv(VW_ADVICE_FILE, &rows, &table);
    return vw_result_write_table(status, out, VW_ADVICE_FILE, &table);
}

// Adds the tables that were written to the documents of the page.
static enum vw_status list_tables(const struct vw_attribution *attribution, struct vw_report_documents *documents) {
    enum vw_status status = VW_OK;
    for (int i = 0; !status && i < VW_ATTRIBUTION_TABLES; i++) {
        const struct vw_rows rows = vw_attribution_rows(attribution, i);
        if (rows.count && i != VW_TABLE_PAYOUT_PHOTOS)
            status =
                vw_report_documents_take(documents, attribution->out, vw_attribution_names[i], vw_rows_to_texts(&rows));
    }
    return status;
}

static enum vw_status write_report(const struct vw_run_outputs_params *params, struct vw_run_outputs *outputs) {
    struct vw_report_documents documents = {0};
    struct vw_report_params report = params->report;
    report.scene = params->scene;
    enum vw_status status = vw_results_read_next(params->out, params->report.options.no_thumbnails, &outputs->results);
    if (!status) status = list_tables(&outputs->attribution, &documents);
    if (!status) status = vw_report_of_run(&outputs->results, &documents, &report, &outputs->report_path);
    vw_report_documents_free(&documents);
    return status ? vw_fail_context(status, "no report") : VW_OK;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static enum vw_status begin(const struct vw_run_outputs_params *params, struct vw_results *results) {
    const struct vw_scoring *scoring = params->scoring;
    *results = (struct vw_results){.label = params->out,
                                   .input = scoring->input,
                                   .scores = scoring->scores,
                                   .score_count = scoring->score_count,
                                   .retrainings = scoring->retrainings,
                                   .retraining_count = scoring->retraining_count};
    vw_ledger_chain_head(params->ledger, results->head); // which a payout has changed
    return vw_ledger_get_run(params->ledger, &results->row);
}

enum vw_status vw_run_outputs_make(const struct vw_run_outputs_params *params, struct vw_run_outputs *outputs) {
    struct vw_results *results = &outputs->results;
    enum vw_status status = vw_attribution_make(params->scene, params->ledger, params->scoring, params->out,
                                                params->payout_cents, &outputs->attribution);
    if (!status) status = begin(params, results);
    if (!status) status = judge_views(params, outputs);
    if (!status) status = vw_run_splits_write(params->scene, params->out);
    if (!status) status = look_at_field(params, results, &outputs->mask_count);
    if (!status)
        status =
            vw_run_splats_write(params->trainer, params->report.options.ply_degree, params->out, &outputs->has_splats);
    if (!status) status = write_report(params, outputs);
    return status ? status : write_advice(results, params->out);
}

void vw_run_outputs_free(struct vw_run_outputs *outputs) {
    vw_attribution_free(&outputs->attribution);
    vw_results_free(&outputs->results);
    free(outputs->distances);
    free(outputs->matrix_path);
    free(outputs->report_path);
}
