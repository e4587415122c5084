#include "check/defects.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

// Chosen on real scenes damaged by scripts/lab/damage_photos and on drawn recipes, between untouched and damaged
// photos. Which, and how often they are right elsewhere: lab/results/defects.md.
static const double EMPTY_CONTRAST = 0.02; // untouched photos had 0.06 and more
static const double MISMATCH = 0.099;      // share in place that nothing explains: untouched photos had 0.11 and more
static const double HIDDEN = 0.04;         // untouched photos had less, but for 1 of 1,400
static const double HIDDEN_WIDELY = 0.15;  // so much makes a photo show little of what its pose sees
static const double SHARP = 0.8;  // upper quarter: untouched photos had 0.92 and more, blur of 1 px 0.67 and less
static const double EVEN = 0.76;  // blurred photos: motion of 4 px and more had 0.74 and less
static const double STOPS = 0.42; // 98 of 100 untouched photos had less
static const double STOPS_SPREADS = 2.3; // spreads of the photo's points: surfaces that shine differ by direction
static const double NOISY = 1.7;         // lower quarter: untouched photos had 1.3 and less
static const double NOISIER = 5;         // though something with a pattern hides a quarter of the photo
static const double HIDDEN_QUARTER = 0.25;
static const double TRACK_PX = 3;      // median of a photo
static const double BEHIND = 0.05;     // share of tracked points
static const double FEW_TRACKS = 0.05; // share of what others track: sound photos of four captures had 0.1 and more
// In addition, so that nothing stands out among photos of many kinds: robust spreads from the median, and a share.
static const double SPREADS = 4, MISMATCH_MEDIANS = 0.15, TIMES_MEDIAN = 4;
enum { POINTS_LEAST = 24, TRACKS_LEAST = 8 };

// The usual measure among the photos of a scene.
struct usual {
    double median, spread;
};

struct finding {
    struct vw_check *check;
    size_t capacity;
    uint32_t view;                                                    // the photo at hand
    enum vw_status status;                                            // the first failure; nothing is added after it
    struct usual in_place, sharpness, stops, noise, tracks, track_px; // sharpness and noise: of logarithms
};

static void add_of(struct finding *finding, enum vw_defect_kind kind, double amount, double detail, uint32_t other) {
    struct vw_check *check = finding->check;
    if (!finding->status)
        finding->status = vw_grow((void **)&check->defects, &finding->capacity, (size_t)check->defect_count + 1,
                                  sizeof *check->defects);
    if (!finding->status)
        check->defects[check->defect_count++] = (struct vw_defect){finding->view, kind, amount, detail, other};
}

static void add(struct finding *finding, enum vw_defect_kind kind, double amount, double detail) {
    add_of(finding, kind, amount, detail, VW_DEFECT_NO_OTHER);
}

static double log_sharpness(const struct vw_photo_evidence *evidence) { return log(evidence->sharpness_high); }
static double log_noise(const struct vw_photo_evidence *evidence) { return log(evidence->noise); }
static double in_place_of(const struct vw_photo_evidence *evidence) { return evidence->in_place; }
static double stops_of(const struct vw_photo_evidence *evidence) { return evidence->stops; }
static double tracks_of(const struct vw_photo_evidence *evidence) {
    return isnan(evidence->contrast) ? NAN : evidence->tracks;
}
static double track_px_of(const struct vw_photo_evidence *evidence) { return evidence->track_px; }

static struct usual find_usual(const struct vw_check *check, double (*of)(const struct vw_photo_evidence *),
                               double *values) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < check->view_count; v++)
        if (isfinite(of(&check->evidence[v]))) values[count++] = of(&check->evidence[v]);
    double median = vw_median(values, count);
    return (struct usual){median, vw_robust_spread(values, count)};
}

// Returns whether the orientation of EXIF turns the pixels back.
static bool exif_tells(const struct vw_photo_evidence *evidence) {
    static const double turns_deg[9] = {[3] = 180, [6] = 90, [8] = 270}; // clockwise
    return evidence->turned_over_deg == turns_deg[evidence->orientation];
}

static bool is_blurred(const struct finding *finding, const struct vw_photo_evidence *evidence) {
    double least = finding->sharpness.median - SPREADS * finding->sharpness.spread;
    return log(evidence->sharpness_high) < fmin(log(SHARP), least);
}

// Says why a photo shows little of what its pose sees. Returns whether it shows enough to be compared.
static bool find_place(struct finding *finding, const struct vw_photo_evidence *evidence) {
    double least = fmin(MISMATCH, MISMATCH_MEDIANS * finding->in_place.median);
    if (evidence->turned_over_deg > 0)
        return add(finding, VW_DEFECT_ORIENTATION, evidence->turned_over_deg, exif_tells(evidence)), false;
    if (evidence->shows != UINT32_MAX)
        return add_of(finding, VW_DEFECT_SWAPPED, evidence->shows_in_place, 0, evidence->shows), true;
    if (isfinite(evidence->turned_deg))
        return add(finding, VW_DEFECT_POSE, evidence->turned_deg, evidence->moved_px), true;
    if (isfinite(evidence->zoom)) return add(finding, VW_DEFECT_ZOOM, evidence->zoom, 0), true;
    if (!(evidence->in_place <= least) || evidence->expected_count < POINTS_LEAST ||
        is_blurred(finding, evidence)) // strong blur leaves nothing to compare
        return true;
    if (evidence->hidden > HIDDEN_WIDELY) add(finding, VW_DEFECT_OCCLUDER, evidence->hidden, 0);
    else add(finding, VW_DEFECT_MISMATCH, evidence->in_place, 0);
    return false;
}

static bool is_noisy(const struct finding *finding, const struct vw_photo_evidence *evidence) {
    double least = evidence->hidden > HIDDEN_QUARTER ? NOISIER : NOISY, spread = finding->noise.spread;
    return log(evidence->noise) > fmax(log(least), finding->noise.median + SPREADS * spread);
}

static bool is_exposed(const struct finding *finding, const struct vw_photo_evidence *evidence) {
    double least = fmax(SPREADS * finding->stops.spread, STOPS_SPREADS * evidence->stops_spread);
    return fabs(evidence->stops - finding->stops.median) > fmax(STOPS, least);
}

static void find_by_pixels(struct finding *finding, const struct vw_photo_evidence *evidence) {
    bool even = evidence->evenness > EVEN, noisy = is_noisy(finding, evidence); // noise hides points as well
    if (!noisy && evidence->hidden > HIDDEN) add(finding, VW_DEFECT_OCCLUDER, evidence->hidden, 0);
    if (is_blurred(finding, evidence))
        add(finding, even ? VW_DEFECT_BLUR : VW_DEFECT_MOTION_BLUR, evidence->sharpness,
            even ? 0 : evidence->motion_deg);
    if (is_exposed(finding, evidence)) add(finding, VW_DEFECT_EXPOSURE, evidence->stops - finding->stops.median, 0);
    if (noisy) add(finding, VW_DEFECT_NOISE, evidence->noise, 0);
}

static void find_by_tracks(struct finding *finding, const struct vw_photo_evidence *evidence, bool in_place) {
    bool behind = evidence->behind > BEHIND;
    bool away = evidence->track_px > fmax(TRACK_PX, TIMES_MEDIAN * finding->track_px.median);
    if (evidence->tracks >= TRACKS_LEAST && (behind || away))
        add(finding, VW_DEFECT_TRACKS, evidence->track_px, behind ? evidence->behind : 0);
    if (in_place && evidence->tracks < FEW_TRACKS * finding->tracks.median) // elsewhere it tracks nothing
        add(finding, VW_DEFECT_FEW_TRACKS, evidence->tracks, finding->tracks.median);
}

static void find_of_photo(struct finding *finding) {
    const struct vw_photo_evidence *evidence = &finding->check->evidence[finding->view];
    uint32_t before = finding->check->defect_count;
    if (isnan(evidence->contrast)) return; // excluded, or all of it masked
    if (evidence->contrast < EMPTY_CONTRAST) {
        add(finding, VW_DEFECT_EMPTY, evidence->contrast, 0);
        return;
    }
    bool compared = find_place(finding, evidence), in_place = finding->check->defect_count == before;
    if (evidence->copy_of != UINT32_MAX) add_of(finding, VW_DEFECT_COPY, evidence->similarity, 0, evidence->copy_of);
    if (compared) find_by_pixels(finding, evidence);
    find_by_tracks(finding, evidence, in_place);
}

// Sorts the defects of a photo by kind, the gravest first.
static void sort_from(struct vw_check *check, uint32_t first) {
    for (uint32_t i = first + 1; i < check->defect_count; i++)
        for (uint32_t k = i; k > first && check->defects[k - 1].kind > check->defects[k].kind; k--) {
            struct vw_defect swapped = check->defects[k];
            check->defects[k] = check->defects[k - 1], check->defects[k - 1] = swapped;
        }
}

enum vw_status vw_check_find_defects(struct vw_check *check) {
    double *values = vw_allocate(check->view_count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    struct finding finding = {.check = check,
                              .in_place = find_usual(check, in_place_of, values),
                              .sharpness = find_usual(check, log_sharpness, values),
                              .stops = find_usual(check, stops_of, values),
                              .noise = find_usual(check, log_noise, values),
                              .tracks = find_usual(check, tracks_of, values),
                              .track_px = find_usual(check, track_px_of, values)};
    free(values);
    for (; finding.view < check->view_count && !finding.status; finding.view++) {
        uint32_t first = check->defect_count;
        find_of_photo(&finding);
        sort_from(check, first);
    }
    return finding.status;
}
