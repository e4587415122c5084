#include "run/outputs/validation_views.h"

#include <math.h>
#include <stdlib.h>

#include "base/file.h"
#include "base/memory.h"
#include "report/tables.h"
#include "viewworth/log.h"

bool vw_validation_views_have_matrix(const struct vw_validation_views *validation) {
    return validation->matrix.view_count > 0 && validation->matrix.visit_count > 0;
}

const char *vw_validation_views_name(const struct vw_validation_views *validation, uint32_t view) {
    return validation->scene->views[view].name;
}

static void warn(const struct vw_validation_views *validation) {
    for (uint32_t v = 0; vw_validation_views_have_matrix(validation) && v < validation->matrix.view_count; v++) {
        const struct vw_view_evidence *view = &validation->views[v];
        const char *name = vw_validation_views_name(validation, view->image_id);
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
    for (uint32_t i = 0; i < validation->distance_count; i++) {
        const struct vw_view_distance *distance = &validation->distances[i];
        if (distance->far)
            vw_log_warning("validation photo %s is far from all training photos: %.1f times their distance "
                           "from each other (the "
                           "nearest, %s, looks %.0f degrees elsewhere); what it shows may be guesswork",
                           vw_validation_views_name(validation, distance->view), distance->ratio,
                           vw_validation_views_name(validation, distance->nearest), distance->angle_deg);
    }
}

static enum vw_status compute(const struct vw_scene *scene, struct vw_ledger *ledger, const struct vw_scoring *scoring,
                              struct vw_validation_views *validation) {
    enum vw_status status = vw_value_matrix(ledger, &scoring->input, &validation->matrix);
    if (!status)
        status = vw_scene_view_distances(scene, VW_SPLIT_VAL, &validation->distances, &validation->distance_count);
    if (!status)
        status = vw_ranking_agreement_measure(&scoring->input, &validation->matrix, scoring->scores,
                                              scoring->score_count, &validation->agreement);
    if (status) return status;
    validation->views = vw_allocate(validation->matrix.view_count, sizeof *validation->views);
    validation->standard_errors = vw_allocate(validation->matrix.photo_count, sizeof *validation->standard_errors);
    if (!validation->views || !validation->standard_errors) return VW_ERROR_MEMORY;
    if (!vw_validation_views_have_matrix(validation)) return VW_OK;
    return vw_matrix_jackknife(&validation->matrix, validation->views, validation->standard_errors);
}

enum vw_status vw_validation_views_make(const struct vw_scene *scene, struct vw_ledger *ledger,
                                        const struct vw_scoring *scoring, const char *out, struct vw_checksums *made,
                                        struct vw_validation_views *validation) {
    *validation = (struct vw_validation_views){.scene = scene, .matrix_path = vw_path_join(out, "matrix.csv")};
    if (!validation->matrix_path) return VW_ERROR_MEMORY;
    enum vw_status status = compute(scene, ledger, scoring, validation);
    if (!status && vw_validation_views_have_matrix(validation)) {
        struct vw_csv_text table = {0};
        status = vw_table_make_matrix(validation->matrix_path, &validation->matrix, validation->standard_errors,
                                      scoring->input.images, scoring->input.image_count, &table);
        status = vw_result_write_table(status, out, "matrix.csv", &table, made);
    }
    if (!status) warn(validation);
    uint32_t views = validation->matrix.view_count;
    if (!status && views && views < VW_AGREEMENT_VIEWS_MIN)
        vw_log_warning("%u validation photo%s the scores: one view may decide the ranking; name at least %d by --val",
                       views, views == 1 ? " makes" : "s make", VW_AGREEMENT_VIEWS_MIN);
    return status;
}

void vw_validation_views_free(struct vw_validation_views *validation) {
    vw_matrix_clear(&validation->matrix);
    free(validation->views);
    free(validation->standard_errors);
    free(validation->distances);
    free(validation->matrix_path);
    *validation = (struct vw_validation_views){0};
}
