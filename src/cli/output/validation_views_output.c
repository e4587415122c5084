#include "cli/output/validation_views_output.h"
#include "cli/output/print.h"

#include <math.h>

#include "base/json.h"

static const char *name_of(const struct vw_validation_views *validation, uint32_t view) {
    return validation->scene->views[view].name;
}

static const struct vw_view_distance *find_distance(const struct vw_validation_views *validation, uint32_t view) {
    for (uint32_t i = 0; i < validation->distance_count; i++)
        if (validation->distances[i].view == view) return &validation->distances[i];
    return NULL;
}

// Returns the view whose removal changes the ranking most; NULL if that is unknown.
static const struct vw_view_evidence *find_lowest(const struct vw_validation_views *validation) {
    const struct vw_view_evidence *lowest = NULL;
    for (uint32_t v = 0; vw_validation_views_have_matrix(validation) && v < validation->matrix.view_count; v++) {
        const struct vw_view_evidence *view = &validation->views[v];
        if (!isnan(view->without) && (!lowest || view->without < lowest->without)) lowest = view;
    }
    return lowest;
}

void vw_validation_views_print(const struct vw_validation_views *validation) {
    const struct vw_view_evidence *lowest = find_lowest(validation);
    if (lowest)
        vw_print("validation photos  leaving one out, the ranking correlates %.3f or better with this one (lowest "
                 "without %s)\n",
                 lowest->without, name_of(validation, lowest->image_id));
    if (vw_validation_views_have_matrix(validation)) vw_print("matrix   %s\n", validation->matrix_path);
}

static json_t *view_to_json(const struct vw_validation_views *validation, const struct vw_view_evidence *view) {
    const struct vw_view_distance *distance = find_distance(validation, view->image_id);
    return json_pack("{s:s, s:o, s:o, s:o, s:b, s:b, s:o, s:b}", "name", name_of(validation, view->image_id),
                     "psnr_end_db", vw_json_real(view->end_psnr), "agreement", vw_json_real(view->agreement),
                     "ranking_without", vw_json_real(view->without), "disagrees", view->disagrees, "stays_low",
                     view->stays_low, "distance", vw_json_real(distance ? distance->ratio : NAN), "far",
                     distance && distance->far);
}

bool vw_validation_views_add_json(const struct vw_validation_views *validation, json_t *root) {
    json_t *views = json_array();
    int failed = 0;
    for (uint32_t v = 0; vw_validation_views_have_matrix(validation) && v < validation->matrix.view_count; v++)
        vw_json_append(&views, view_to_json(validation, &validation->views[v]));
    failed |= json_object_set_new(root, "validation_views", views);
    if (vw_validation_views_have_matrix(validation))
        failed |= json_object_set_new(root, "matrix", json_string(validation->matrix_path));
    return !failed;
}
