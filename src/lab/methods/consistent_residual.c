#include "lab/methods/consistent_residual.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "lab/methods/photo_sightings.h"
#include "train/trainer.h"

enum { SIDE_MOST = 64, CELLS = 24, OTHERS_LEAST = 2 }; // pixels and cells along the sides of a photo
static const double OUTLIER_SPREADS = 3;
static const double DEPTH_AGREES = 1.1; // a point hides those that are so many times as far

const char vw_consistent_residual_name[] = "consistent_residual";

struct work {
    const struct vw_scene *scene;
    const uint32_t *photos;
    uint32_t photo_count;
    const struct vw_residuals *residuals;
    uint32_t *numbers;    // by view: 1 + its place among the photos; 0: none
    double *listed;       // by track: the residual there; NaN: unknown
    double *scratch;      // room for residuals
    double *depths;       // depths of a photo's points, along its axis; NaN: outside
    double *own;          // a photo's residuals at its points
    double outlier_above; // residual
};

// ---- Residuals of points ----

static double residual_at(const struct vw_view *view, const struct vw_residuals *residuals, double x_px, double y_px) {
    double x = floor(x_px / view->camera.width_px * residuals->columns);
    double y = floor(y_px / view->camera.height_px * residuals->rows);
    if (!(x >= 0 && x < residuals->columns && y >= 0 && y < residuals->rows)) return NAN;
    return residuals->values[(size_t)y * residuals->columns + (size_t)x];
}

// Returns the threshold of `count` values, which are overwritten.
static double find_threshold(double *values, uint32_t count) {
    double median = vw_median(values, count);
    return median + OUTLIER_SPREADS * vw_robust_spread(values, count);
}

static void list_residuals(struct work *work) {
    uint32_t known = 0;
    for (uint32_t t = 0; t < work->scene->track_count; t++) {
        const struct vw_track *track = &work->scene->tracks[t];
        uint32_t number = work->numbers[track->view];
        work->listed[t] = NAN;
        if (number)
            work->listed[t] =
                residual_at(&work->scene->views[track->view], &work->residuals[number - 1], track->x_px, track->y_px);
        if (isfinite(work->listed[t])) work->scratch[known++] = work->listed[t];
    }
    work->outlier_above = find_threshold(work->scratch, known);
}

// Returns the median residual of the other photos that list a point; `count` is how many of them have a residual.
static double median_of_others(struct work *work, const struct vw_point *point, uint32_t view, uint32_t *count) {
    *count = 0;
    for (uint32_t t = point->first_track; t < point->first_track + point->track_count; t++)
        if (work->scene->tracks[t].view != view && isfinite(work->listed[t]))
            work->scratch[(*count)++] = work->listed[t];
    return vw_median(work->scratch, *count);
}

// ---- Which points a photo sees ----

static uint32_t cell_of(const struct vw_view *view, double x_px, double y_px) {
    return (uint32_t)(y_px / view->camera.height_px * CELLS) * CELLS + (uint32_t)(x_px / view->camera.width_px * CELLS);
}

// Fills the photo's residual at every point that it sees, NaN at others.
static void find_own(struct work *work, uint32_t photo) {
    const struct vw_scene *scene = work->scene;
    const struct vw_view *view = &scene->views[work->photos[photo]];
    double nearest[CELLS * CELLS], x_px, y_px;
    for (uint32_t i = 0; i < CELLS * CELLS; i++) nearest[i] = INFINITY;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        work->own[p] = work->depths[p] = NAN;
        if (!vw_view_project(view, scene->points[p].position_world, &x_px, &y_px, &work->depths[p])) {
            work->depths[p] = NAN;
            continue;
        }
        double *cell = &nearest[cell_of(view, x_px, y_px)];
        *cell = fmin(*cell, work->depths[p]);
    }
    for (uint32_t p = 0; p < scene->point_count; p++) {
        if (!isfinite(work->depths[p])) continue;
        (void)vw_view_project(view, scene->points[p].position_world, &x_px, &y_px, NULL); // as before
        if (work->depths[p] <= DEPTH_AGREES * nearest[cell_of(view, x_px, y_px)])
            work->own[p] = residual_at(view, &work->residuals[photo], x_px, y_px);
    }
    for (uint32_t p = 0; p < scene->point_count; p++) // the photo sees the points of its tracks at the tracks' pixels
        for (uint32_t t = 0; t < scene->points[p].track_count; t++)
            if (scene->tracks[scene->points[p].first_track + t].view == work->photos[photo])
                work->own[p] = work->listed[scene->points[p].first_track + t];
}

// ---- Scores ----

// Returns the share of the photo's points whose residual is an outlier in this photo alone; NaN if other photos know
// none of its points.
static double share_of_points(struct work *work, uint32_t photo) {
    uint32_t known = 0, alone = 0, others;
    find_own(work, photo);
    for (uint32_t p = 0; p < work->scene->point_count; p++) {
        if (!isfinite(work->own[p])) continue;
        double median = median_of_others(work, &work->scene->points[p], work->photos[photo], &others);
        if (others < OTHERS_LEAST) continue;
        known++;
        alone += work->own[p] > work->outlier_above && median <= work->outlier_above;
    }
    return known ? (double)alone / known : NAN;
}

static double share_of_pixels(const struct vw_residuals *residuals, double outlier_above) {
    uint32_t known = 0, outliers = 0;
    for (uint32_t i = 0; i < residuals->columns * residuals->rows; i++) {
        known += isfinite(residuals->values[i]);
        outliers += residuals->values[i] > outlier_above;
    }
    return known ? (double)outliers / known : NAN;
}

// Sets the threshold by all pixels, for scenes without points.
static void take_all_pixels(struct work *work) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < work->photo_count; i++)
        for (uint32_t j = 0; j < work->residuals[i].columns * work->residuals[i].rows; j++)
            if (isfinite(work->residuals[i].values[j])) work->scratch[count++] = work->residuals[i].values[j];
    work->outlier_above = find_threshold(work->scratch, count);
}

static enum vw_status allocate(struct work *work) {
    const struct vw_scene *scene = work->scene;
    size_t scratch = scene->track_count;
    for (uint32_t i = 0; i < work->photo_count && !scene->track_count; i++)
        scratch += (size_t)work->residuals[i].columns * work->residuals[i].rows;
    work->numbers = vw_allocate(scene->view_count, sizeof *work->numbers);
    work->listed = vw_allocate(scene->track_count, sizeof *work->listed);
    work->scratch = vw_allocate(scratch, sizeof *work->scratch);
    work->depths = vw_allocate(scene->point_count, sizeof *work->depths);
    work->own = vw_allocate(scene->point_count, sizeof *work->own);
    return work->numbers && work->listed && work->scratch && work->depths && work->own ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_consistent_residual_score(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                            const struct vw_residuals *residuals, double *scores) {
    struct work work = {.scene = scene, .photos = photos, .photo_count = photo_count, .residuals = residuals};
    enum vw_status status = allocate(&work);
    for (uint32_t i = 0; !status && i < photo_count; i++) work.numbers[photos[i]] = i + 1;
    if (!status && scene->track_count) list_residuals(&work);
    else if (!status) take_all_pixels(&work);
    for (uint32_t i = 0; !status && i < photo_count; i++) {
        double share = scene->track_count ? share_of_points(&work, i) : NAN;
        scores[i] = -(isfinite(share) ? share : share_of_pixels(&residuals[i], work.outlier_above));
    }
    free(work.numbers);
    free(work.listed);
    free(work.scratch);
    free(work.depths);
    free(work.own);
    return status;
}

// ---- From a field ----

static enum vw_status finish_training(struct vw_trainer *trainer) {
    const struct vw_step_record *records;
    uint32_t count = 1;
    enum vw_status status = VW_OK;
    while (!status && count) status = vw_trainer_advance(trainer, &records, &count);
    return status;
}

static enum vw_status open_field(const struct vw_finished_field *finished, struct vw_trainer **trainer) {
    const struct vw_trainer_params params = {.gpu = finished->session->devices[0].gpu,
                                             .scene = finished->session->scene,
                                             .config = finished->config,
                                             .effects = finished->session->effects,
                                             .effect_count = finished->session->effect_count,
                                             .awaits_field = finished->path != NULL};
    enum vw_status status = vw_trainer_create(&params, trainer);
    if (status) return status;
    return finished->path ? vw_trainer_load_field(*trainer, finished->path) : finish_training(*trainer);
}

static double residual_of(const struct vw_session *session, const struct vw_view *view, uint32_t x_px, uint32_t y_px,
                          const float *rendered) {
    bool masked = vw_effects_is_on(session->effects, session->effect_count, "masks");
    bool on_background = vw_effects_is_on(session->effects, session->effect_count, "background");
    float rgba[4];
    double sum = 0;
    if (!(masked ? vw_view_keeps(view, x_px, y_px) : vw_view_can_use(view, x_px, y_px))) return NAN;
    vw_image_pixel(&view->image, x_px, y_px, rgba);
    double alpha = on_background ? rgba[3] : 1;
    for (int c = 0; c < 3; c++)
        sum += fabs(rendered[c] - alpha * rgba[c] - (1 - alpha) * session->scene->background[c]);
    return sum / 3;
}

static uint32_t shrink(uint32_t side_px, uint32_t longer_px) {
    uint32_t side = longer_px > SIDE_MOST ? (uint32_t)((uint64_t)side_px * SIDE_MOST / longer_px) : side_px;
    return side ? side : 1;
}

static enum vw_status measure(const struct vw_session *session, struct vw_trainer *trainer, uint32_t index,
                              struct vw_residuals *residuals) {
    const struct vw_view *view = &session->scene->views[index];
    uint32_t width_px = view->image.width_px, height_px = view->image.height_px,
             longer_px = width_px > height_px ? width_px : height_px;
    const uint32_t size_px[2] = {shrink(width_px, longer_px), shrink(height_px, longer_px)};
    float *rendered = NULL;
    *residuals = (struct vw_residuals){.columns = size_px[0],
                                       .rows = size_px[1],
                                       .values = vw_allocate((size_t)size_px[0] * size_px[1], sizeof(double))};
    enum vw_status status = residuals->values ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_trainer_render_small(trainer, index, size_px, &rendered);
    for (uint32_t i = 0; !status && i < size_px[0] * size_px[1]; i++) {
        uint32_t x_px = (uint32_t)((2 * (uint64_t)(i % size_px[0]) + 1) * width_px / (2 * (uint64_t)size_px[0]));
        uint32_t y_px = (uint32_t)((2 * (uint64_t)(i / size_px[0]) + 1) * height_px / (2 * (uint64_t)size_px[1]));
        residuals->values[i] = residual_of(session, view, x_px, y_px, rendered + 3 * (size_t)i);
    }
    free(rendered);
    return status;
}

enum vw_status vw_consistent_residual_find(const struct vw_finished_field *finished, const uint32_t *photos,
                                           uint32_t photo_count, double *scores) {
    const struct vw_session *session = finished->session;
    struct vw_trainer *trainer = NULL;
    for (uint32_t i = 0; i < photo_count; i++) scores[i] = NAN;
    if (vw_effects_fit_views(session->effects, session->effect_count)) return VW_OK;
    struct vw_residuals *residuals = vw_allocate(photo_count, sizeof *residuals);
    if (!residuals) return VW_ERROR_MEMORY;
    enum vw_status status = open_field(finished, &trainer);
    for (uint32_t i = 0; !status && i < photo_count; i++) status = measure(session, trainer, photos[i], &residuals[i]);
    if (!status) status = vw_consistent_residual_score(session->scene, photos, photo_count, residuals, scores);
    vw_trainer_destroy(&trainer);
    for (uint32_t i = 0; i < photo_count; i++) free(residuals[i].values);
    free(residuals);
    return status;
}
