#include "lab/methods/photo_transport.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "lab/methods/optimal_transport.h"
#include "viewworth/log.h"

static const double TEMPERATURE = 0.05; // share of the mean cost

enum part { THUMBNAILS, POSITIONS, AXES, PART_COUNT };

static double squared_distance(enum part part, const struct vw_view *a, const struct vw_view *b,
                               const float *thumbnail_a, const float *thumbnail_b) {
    double sum = 0;
    int column = part == POSITIONS ? 3 : 2; // the pose's column: the position or the axis
    if (part == THUMBNAILS)
        for (int i = 0; i < VW_THUMBNAIL_VALUES; i++) sum += pow((double)thumbnail_a[i] - thumbnail_b[i], 2);
    else
        for (int i = 0; i < 3; i++) sum += pow(a->camera_to_world[i][column] - b->camera_to_world[i][column], 2);
    return sum;
}

// Adds a part of the costs. A part in which all pairs are equal adds nothing.
static void add_part(const struct vw_scene *scene, enum part part, const uint32_t *photos,
                     const struct vw_photo_pixels *pixels, uint32_t photo_count, const uint32_t *validation,
                     const struct vw_photo_pixels *seen, uint32_t validation_count, double *room, double *costs) {
    size_t count = (size_t)photo_count * validation_count;
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        size_t photo = i / validation_count, other = i % validation_count;
        room[i] = squared_distance(part, &scene->views[photos[photo]], &scene->views[validation[other]],
                                   pixels[photo].thumbnail, seen[other].thumbnail);
        sum += room[i];
    }
    for (size_t i = 0; sum > 0 && i < count; i++) costs[i] += room[i] / sum * (double)count;
}

static void solve(const double *costs, uint32_t photo_count, uint32_t validation_count, double *sources,
                  double *targets, double *gradients) {
    double mean = 0;
    for (size_t i = 0; i < (size_t)photo_count * validation_count; i++)
        mean += costs[i] / ((double)photo_count * validation_count);
    const struct vw_transport transport = {.costs = costs,
                                           .source_count = photo_count,
                                           .target_count = validation_count,
                                           .temperature = TEMPERATURE * (mean > 0 ? mean : 1)};
    if (vw_transport_solve(&transport, sources, targets)) vw_transport_calibrate(sources, photo_count, gradients);
    else vw_log_info("transport   did not converge: no photo has a score by it");
}

static enum vw_status transport_to(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                   const struct vw_photo_pixels *pixels, const uint32_t *validation,
                                   uint32_t validation_count, double *gradients) {
    struct vw_photo_pixels *seen = vw_allocate(validation_count, sizeof *seen);
    double *costs = vw_allocate((size_t)photo_count * validation_count, sizeof *costs);
    double *room = vw_allocate((size_t)photo_count * validation_count, sizeof *room);
    double *potentials = vw_allocate((size_t)photo_count + validation_count, sizeof *potentials);
    enum vw_status status = seen && costs && room && potentials ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_scene_decode(scene, validation, validation_count);
    for (uint32_t i = 0; !status && i < validation_count; i++)
        status = vw_photo_pixels_measure(scene, validation[i], &seen[i]);
    for (enum part part = THUMBNAILS; !status && part < PART_COUNT; part++)
        add_part(scene, part, photos, pixels, photo_count, validation, seen, validation_count, room, costs);
    if (!status) solve(costs, photo_count, validation_count, potentials, potentials + photo_count, gradients);
    free(potentials);
    free(room);
    free(costs);
    free(seen);
    return status;
}

enum vw_status vw_photo_transport(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                  const struct vw_photo_pixels *pixels, double *gradients) {
    uint32_t *validation = NULL, count = 0;
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_VAL, &validation, &count);
    for (uint32_t i = 0; i < photo_count; i++) gradients[i] = NAN;
    if (!status && count) status = transport_to(scene, photos, photo_count, pixels, validation, count, gradients);
    free(validation);
    return status;
}
