#include "run/outputs/validation_views.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/output/json_output.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "report/tables.h"

static bool has_matrix(const struct vw_validation_report *report) {
    return report->matrix.view_count > 0 && report->matrix.visit_count > 0;
}

static const char *name_of(const struct vw_validation_report *report, uint32_t view) {
    return report->scene->views[view].name;
}

static const struct vw_view_distance *find_distance(const struct vw_validation_report *report, uint32_t view) {
    for (uint32_t i = 0; i < report->distance_count; i++)
        if (report->distances[i].view == view) return &report->distances[i];
    return NULL;
}

// The view without which the ranking changes most; NULL where that cannot be said.
static const struct vw_view_evidence *find_lowest(const struct vw_validation_report *report) {
    const struct vw_view_evidence *lowest = NULL;
    for (uint32_t v = 0; has_matrix(report) && v < report->matrix.view_count; v++) {
        const struct vw_view_evidence *view = &report->views[v];
        if (!isnan(view->without) && (!lowest || view->without < lowest->without)) lowest = view;
    }
    return lowest;
}

static void warn(const struct vw_validation_report *report) {
    for (uint32_t v = 0; has_matrix(report) && v < report->matrix.view_count; v++) {
        const struct vw_view_evidence *view = &report->views[v];
        const char *name = name_of(report, view->image_id);
        if (view->disagrees)
            vw_log_warning("validation photo %s looks corrupted: it ranks the photos as no other does (correlation "
                           "%.2f); look at it, "
                           "or leave it out by --val",
                           name, view->agreement);
        if (view->stays_low)
            vw_log_warning("validation photo %s looks corrupted: its PSNR ends at %.1f dB, far below the others'; look "
                           "at it, or leave it "
                           "out by --val",
                           name, view->end_psnr);
    }
    for (uint32_t i = 0; i < report->distance_count; i++) {
        const struct vw_view_distance *distance = &report->distances[i];
        if (distance->far)
            vw_log_warning("validation photo %s is far from every photo to train on: %.1f times as far as those are "
                           "from each other (the "
                           "nearest, %s, looks %.0f degrees elsewhere); what it shows may be guesswork",
                           name_of(report, distance->view), distance->ratio, name_of(report, distance->nearest),
                           distance->angle_deg);
    }
}

enum vw_status vw_validation_report_make(const struct vw_training_run *run, const struct vw_scoring *scoring,
                                         struct vw_validation_report *report) {
    *report = (struct vw_validation_report){.scene = run->scene,
                                            .matrix_path = vw_path_join(run->options->out, "matrix.csv")};
    if (!report->matrix_path) return VW_ERROR_MEMORY;
    enum vw_status status = vw_value_matrix(run->ledger, &scoring->input, &report->matrix);
    if (!status) status = vw_scene_view_distances(run->scene, &report->distances, &report->distance_count);
    if (status) return status;
    report->views = vw_allocate(report->matrix.view_count, sizeof *report->views);
    report->standard_errors = vw_allocate(report->matrix.photo_count, sizeof *report->standard_errors);
    if (!report->views || !report->standard_errors) return VW_ERROR_MEMORY;
    if (has_matrix(report)) status = vw_matrix_jackknife(&report->matrix, report->views, report->standard_errors);
    if (!status && has_matrix(report))
        status = vw_table_write_matrix(report->matrix_path, &report->matrix, report->standard_errors,
                                       scoring->input.images, scoring->input.image_count);
    if (!status) warn(report);
    return status;
}

void vw_validation_report_print(const struct vw_validation_report *report) {
    const struct vw_view_evidence *lowest = find_lowest(report);
    if (lowest)
        printf("validation photos  leaving one out, the ranking correlates %.3f or better with this one (lowest "
               "without %s)\n",
               lowest->without, name_of(report, lowest->image_id));
    if (has_matrix(report)) printf("matrix   %s\n", report->matrix_path);
}

static json_t *view_to_json(const struct vw_validation_report *report, const struct vw_view_evidence *view) {
    const struct vw_view_distance *distance = find_distance(report, view->image_id);
    return json_pack("{s:s, s:o, s:o, s:o, s:b, s:b, s:o, s:b}", "name", name_of(report, view->image_id), "psnr_end_db",
                     vw_json_real(view->end_psnr), "agreement", vw_json_real(view->agreement), "ranking_without",
                     vw_json_real(view->without), "disagrees", view->disagrees, "stays_low", view->stays_low,
                     "distance", vw_json_real(distance ? distance->ratio : NAN), "far", distance && distance->far);
}

bool vw_validation_report_add_json(const struct vw_validation_report *report, json_t *root) {
    json_t *views = json_array();
    int failed = 0;
    for (uint32_t v = 0; has_matrix(report) && v < report->matrix.view_count; v++)
        failed |= json_array_append_new(views, view_to_json(report, &report->views[v]));
    failed |= json_object_set_new(root, "validation_views", views);
    if (has_matrix(report)) failed |= json_object_set_new(root, "matrix", json_string(report->matrix_path));
    return !failed;
}

void vw_validation_report_free(struct vw_validation_report *report) {
    vw_matrix_clear(&report->matrix);
    free(report->views);
    free(report->standard_errors);
    free(report->distances);
    free(report->matrix_path);
    *report = (struct vw_validation_report){0};
}
