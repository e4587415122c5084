// How the same SfM points look in different photos.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "detect/evidence.h"
#include "base/memory.h"
#include "image/image.h"
#include "base/statistics.h"

static const double COLOUR_MIN = 0.05; // of a fitted colour that residuals are relative to
enum {
    POINTS_MAX = 1 << 16,  // evenly spaced among all: bounds the work
    PHOTO_POINTS_MIN = 16, // for the median over a photo's points to mean something
    PHOTOS_MIN = 4,        // for a spread over photos to
    FIT_ROUNDS = 20,
    GAIN_ROUNDS = 3, // of taking gains out, so that a point's median over photos means one exposure
};

// A point's colour in one photo beside that in the others.
struct sight {
    double here, elsewhere; // one channel; elsewhere: the median (of logs) over the other photos that see the point
};

// The sights of all photos in one channel, photo after photo.
struct sights {
    uint32_t *ends;    // of each view
    double *log_gains; // of each view, taken out of its colours before they are compared
    struct sight *sights;
};

// The colour of a track's pixel; false where it is not to be looked at, dark or saturated.
static bool colour_of(const struct survey *survey, const struct vw_track *track, int channel, double *colour) {
    float rgba[4];
    if (!survey_keeps_track(survey, track)) return false;
    vw_image_pixel(&survey->scene->views[track->view].image, (uint32_t)track->x_px, (uint32_t)track->y_px, rgba);
    *colour = rgba[channel];
    return rgba[3] == 1.0f && *colour > EVIDENCE_DARK && *colour < EVIDENCE_SATURATED;
}

// The median of sorted values without one that equals `value`.
static double median_without(const double *sorted, uint32_t count, double value) {
    uint32_t left_out = 0;
    while (left_out + 1 < count && sorted[left_out] != value) left_out++;
    uint32_t low = (count - 2) / 2, high = (count - 1) / 2; // the middle ones of count - 1 values
    return 0.5 * (sorted[low + (low >= left_out)] + sorted[high + (high >= left_out)]);
}

// Counts (filling = false) or files the sights of one point. `logs` and `sorted` have room for its tracks.
static void add_point(const struct survey *survey, const struct vw_point *point, int channel, bool filling,
                      double *logs, double *sorted, struct sights *all) {
    const struct vw_track *tracks = survey->scene->tracks + point->first_track;
    uint32_t count = 0;
    for (uint32_t t = 0; t < point->track_count; t++) {
        double colour;
        logs[t] = colour_of(survey, &tracks[t], channel, &colour) ? log(colour) - all->log_gains[tracks[t].view] : NAN;
        if (!isnan(logs[t])) sorted[count++] = logs[t];
    }
    if (count < 2) return;
    if (filling) vw_sort(sorted, count);
    for (uint32_t t = 0; t < point->track_count; t++) {
        if (isnan(logs[t])) continue;
        uint32_t *place =
            &all->ends[tracks[t].view +
                       !filling]; // the count of view v lies one further, so that sums of counts are begins
        if (filling) all->sights[*place] = (struct sight){exp(logs[t]), exp(median_without(sorted, count, logs[t]))};
        ++*place;
    }
}

static enum vw_status gather_sights(const struct survey *survey, int channel, struct sights *all) {
    const struct vw_scene *scene = survey->scene;
    double *logs = vw_allocate(scene->track_count, sizeof *logs),
           *sorted = vw_allocate(scene->track_count, sizeof *sorted);
    uint32_t stride = 1 + scene->point_count / POINTS_MAX;
    enum vw_status status = logs && sorted ? VW_OK : VW_ERROR_MEMORY;
    memset(all->ends, 0, (scene->view_count + 1) * sizeof *all->ends);
    for (int filling = 0; filling < 2 && !status; filling++) {
        for (uint32_t p = 0; p < scene->point_count; p += stride)
            add_point(survey, &scene->points[p], channel, filling, logs, sorted, all);
        for (uint32_t v = 1; !filling && v <= scene->view_count; v++) all->ends[v] += all->ends[v - 1];
    }
    free(logs);
    free(sorted);
    return status;
}

// ---- One photo, one channel -----------------------------------------------------------------------------------------

static double log_gain(const struct sight *sights, uint32_t count, double *room) {
    for (uint32_t i = 0; i < count; i++) room[i] = log(sights[i].here / sights[i].elsewhere);
    return vw_median(room, count);
}

// here = gain * elsewhere + bias in least absolute deviations, by reweighted least squares.
static void fit(const struct sight *sights, uint32_t count, double *gain, double *bias) {
    for (int round = 0; round < FIT_ROUNDS; round++) {
        double w = 0, x = 0, y = 0, xx = 0, xy = 0;
        for (uint32_t i = 0; i < count; i++) {
            double weight = 1.0 / fmax(fabs(sights[i].here - *gain * sights[i].elsewhere - *bias), 0.01);
            w += weight;
            x += weight * sights[i].elsewhere;
            y += weight * sights[i].here;
            xx += weight * sights[i].elsewhere * sights[i].elsewhere;
            xy += weight * sights[i].elsewhere * sights[i].here;
        }
        double determinant = w * xx - x * x;
        if (determinant < 1e-6 * w * w) return; // points all of one colour: the gain alone
        *gain = (w * xy - x * y) / determinant;
        *bias = (y - *gain * x) / w;
    }
}

static double residual_spread(const struct sight *sights, uint32_t count, double *room) {
    double gain = exp(log_gain(sights, count, room)), bias = 0.0;
    fit(sights, count, &gain, &bias);
    for (uint32_t i = 0; i < count; i++) {
        double fitted = gain * sights[i].elsewhere + bias;
        room[i] = fabs(sights[i].here - fitted) / fmax(fitted, COLOUR_MIN);
    }
    return VW_NORMAL_SPREAD * vw_median(room, count);
}

// ---- All photos -----------------------------------------------------------------------------------------------------

typedef double photo_measure(const struct sight *sights, uint32_t count, double *room);

// A measure of every photo that has enough points; NaN of the others.
static void measure_photos(const struct survey *survey, const struct sights *all, photo_measure *measure, double *room,
                           double *values) {
    for (uint32_t v = 0, begin = 0; v < survey->scene->view_count; begin = all->ends[v++]) {
        uint32_t count = all->ends[v] - begin;
        values[v] = count >= PHOTO_POINTS_MIN ? measure(all->sights + begin, count, room) : NAN;
    }
}

// The measure of every photo in one channel, after `rounds` of taking the photos' gains out.
static enum vw_status measure_channel(const struct survey *survey, int channel, int rounds, photo_measure *measure,
                                      struct sights *all, double *room, double *values) {
    uint32_t views = survey->scene->view_count;
    memset(all->log_gains, 0, views * sizeof *all->log_gains);
    for (int round = 0;; round++) {
        enum vw_status status = gather_sights(survey, channel, all);
        if (status != VW_OK) return status;
        measure_photos(survey, all, round < rounds ? log_gain : measure, room, values);
        if (round == rounds) return VW_OK;
        for (uint32_t v = 0; v < views; v++)
            if (!isnan(values[v])) all->log_gains[v] += values[v];
    }
}

// The same in all channels, without the photos that have too few points: into `values`, room for 3 per view.
static enum vw_status measure_scene(const struct survey *survey, int rounds, photo_measure *measure, double *values,
                                    uint32_t *count) {
    uint32_t views = survey->scene->view_count, tracks = survey->scene->track_count;
    struct sights all = {.ends = vw_allocate((size_t)views + 1, sizeof *all.ends),
                         .log_gains = vw_allocate(views, sizeof *all.log_gains),
                         .sights = vw_allocate(tracks, sizeof *all.sights)};
    double *room = vw_allocate(tracks, sizeof *room);
    enum vw_status status = all.ends && all.log_gains && all.sights && room ? VW_OK : VW_ERROR_MEMORY;
    for (int channel = 0; channel < 3 && !status; channel++) {
        status = measure_channel(survey, channel, rounds, measure, &all, room, values + *count);
        uint32_t first = *count;
        for (uint32_t v = 0; v < views && !status; v++)
            if (!isnan(values[first + v])) values[(*count)++] = values[first + v];
    }
    free(all.ends);
    free(all.log_gains);
    free(all.sights);
    free(room);
    return status;
}

enum vw_status evidence_appearance(const struct survey *survey, double *evidence) {
    double *gains = vw_allocate(survey->scene->view_count, 3 * sizeof *gains);
    uint32_t count = 0;
    enum vw_status status = gains ? measure_scene(survey, 0, log_gain, gains, &count) : VW_ERROR_MEMORY;
    if (!status) *evidence = count >= 3 * PHOTOS_MIN ? vw_robust_spread(gains, count) : survey->pilot.gain_spread;
    free(gains);
    return status;
}

enum vw_status evidence_appearance_code(const struct survey *survey, double *evidence) {
    double *spreads = vw_allocate(survey->scene->view_count, 3 * sizeof *spreads);
    uint32_t count = 0;
    enum vw_status status =
        spreads ? measure_scene(survey, GAIN_ROUNDS, residual_spread, spreads, &count) : VW_ERROR_MEMORY;
    if (!status) *evidence = count >= 3 * PHOTOS_MIN ? vw_median(spreads, count) : NAN;
    free(spreads);
    return status;
}
