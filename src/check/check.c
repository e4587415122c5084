#include "check/check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/statistics.h"
#include "check/beside.h"
#include "check/defects.h"
#include "check/expected.h"
#include "check/explain.h"
#include "check/photos.h"
#include "scene/duplicates.h"

static const double KEPT_BETTER = 0.2; // share in place by which a later copy is kept instead of the first
static const double DOUBTFUL = 0.5;    // share in place, below which a reason is looked for

struct checking {
    struct vw_check_photos photos;
    struct vw_beside **beside; // owned; by scene index
    uint32_t *beside_counts;   // owned
    struct vw_photo_evidence *evidence;
};

static void measure_contrast(const struct vw_plane *plane, struct vw_photo_evidence *evidence) {
    struct vw_spread spread = {0};
    for (size_t i = 0; i < (size_t)plane->width_px * plane->height_px; i++)
        if (!isnan(plane->values[i])) vw_spread_add(&spread, plane->values[i]);
    evidence->contrast = sqrt(vw_spread_variance(&spread));
}

static enum vw_status compare_photo(struct checking *checking, uint32_t view, struct vw_expected *expected) {
    const struct vw_check_photo *photo = &checking->photos.list[view];
    struct vw_photo_evidence *evidence = &checking->evidence[view];
    enum vw_status status = VW_OK;
    vw_expected_list(&checking->photos, photo, view, expected);
    evidence->expected_count = expected->count;
    evidence->in_place = vw_expected_mark(&photo->small, expected);
    if (evidence->in_place < DOUBTFUL) status = vw_check_explain(&checking->photos, view, expected, evidence);
    if (status) return status;
    evidence->hidden = vw_expected_hidden(&checking->photos, photo, expected);
    checking->beside[view] = vw_allocate((size_t)2 * expected->count, sizeof **checking->beside);
    if (!checking->beside[view]) return VW_ERROR_MEMORY;
    checking->beside_counts[view] = vw_beside_measure(&checking->photos, view, expected, checking->beside[view]);
    return VW_OK;
}

static enum vw_status check_photo(void *context, uint32_t view) {
    struct checking *checking = context;
    struct vw_expected *expected = NULL;
    if (!checking->photos.list[view].view) return VW_OK;
    measure_contrast(&checking->photos.list[view].small, &checking->evidence[view]);
    enum vw_status status = vw_expected_create(&checking->photos, &expected);
    if (!status) status = compare_photo(checking, view, expected);
    vw_expected_destroy(&expected);
    return status;
}

// Takes the direction and level that lost most.
static void read_sharpness(const struct vw_beside_level *levels, struct vw_photo_evidence *evidence) {
    double least = INFINITY;
    for (int level = 0; level < VW_SHARPNESS_LEVELS; level++) {
        const struct vw_beside_level *of = levels + VW_BESIDE_SHARPNESS + level * VW_SHARPNESS_DIRECTIONS;
        double most = -INFINITY;
        int direction = 0;
        for (int d = 0; d < VW_SHARPNESS_DIRECTIONS; d++) {
            most = fmax(most, of[d].median);
            if (of[d].median < of[direction].median) direction = d;
        }
        if (!(of[direction].median < least)) continue;
        least = of[direction].median;
        evidence->sharpness = exp(least);
        evidence->sharpness_high = exp(of[direction].high);
        evidence->evenness = exp(least - most);
        evidence->motion_deg = 180.0 * direction / VW_SHARPNESS_DIRECTIONS;
    }
}

static enum vw_status compare_photos(struct checking *checking) {
    uint32_t count = checking->photos.count;
    struct vw_beside_level(*levels)[VW_BESIDE_COUNT] = vw_allocate(count, sizeof *levels);
    enum vw_status status =
        levels ? vw_beside_solve(checking->beside, checking->beside_counts, count, levels) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < count && !status; v++) {
        const struct vw_beside_level *stops = &levels[v][VW_BESIDE_STOPS];
        if (isnan(levels[v][VW_BESIDE_SHARPNESS].low)) continue;
        checking->evidence[v].stops = isnan(stops->low) ? NAN : stops->median;
        checking->evidence[v].stops_spread = (stops->high - stops->low) / 2;
        checking->evidence[v].noise = exp(levels[v][VW_BESIDE_NOISE].low);
        read_sharpness(levels[v], &checking->evidence[v]);
    }
    free(levels);
    return status;
}

// ---- Tracks --------------------------------------------------------------------------------------------------------

// Sorts, photo by photo, how far tracks are from where the pose sees their points.
static enum vw_status check_tracks(const struct vw_scene *scene, struct vw_photo_evidence *evidence) {
    double *away_px = vw_allocate(scene->track_count, sizeof *away_px);
    uint32_t *begins = vw_allocate((size_t)scene->view_count + 1, sizeof *begins),
             *counts = vw_allocate(scene->view_count, sizeof *counts);
    bool room = away_px && begins && counts;
    for (uint32_t t = 0; room && t < scene->track_count; t++) begins[scene->tracks[t].view + 1]++;
    for (uint32_t v = 0; room && v < scene->view_count; v++) {
        evidence[v].tracks = begins[v + 1];
        begins[v + 1] += begins[v];
    }
    for (uint32_t p = 0; room && p < scene->point_count; p++)
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            const struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
            const struct vw_check_photo photo = {.view = &scene->views[track->view], .small_per_px = 1};
            double at_px[2], depth;
            if (!vw_check_project(&photo, scene->points[p].position_world, at_px, &depth)) continue;
            away_px[begins[track->view] + counts[track->view]++] =
                hypot(at_px[0] - track->x_px, at_px[1] - track->y_px);
        }
    for (uint32_t v = 0; room && v < scene->view_count; v++) {
        if (scene->views[v].split == VW_SPLIT_EXCLUDED) evidence[v].tracks = 0;
        if (!evidence[v].tracks) continue;
        evidence[v].behind = 1 - (double)counts[v] / evidence[v].tracks;
        evidence[v].track_px = vw_median(away_px + begins[v], counts[v]);
    }
    free(away_px);
    free(begins);
    free(counts);
    return room ? VW_OK : VW_ERROR_MEMORY;
}

// Returns the photo to keep: of those whose poses fit about as well, the first.
static uint32_t choose_kept(const struct vw_duplicate *group, uint32_t count,
                            const struct vw_photo_evidence *evidence) {
    uint32_t kept = group[0].view;
    for (uint32_t i = 1; i < count; i++)
        if (evidence[group[i].view].in_place > evidence[kept].in_place + KEPT_BETTER) kept = group[i].view;
    return kept;
}

static enum vw_status find_copies(const struct vw_scene *scene, struct vw_photo_evidence *evidence) {
    struct vw_duplicate *list = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_scene_find_duplicates(scene, &list, &count);
    for (uint32_t begin = 0, end; begin < count && !status; begin = end) {
        for (end = begin; end < count && list[end].group == list[begin].group;) end++;
        uint32_t kept = choose_kept(list + begin, end - begin, evidence);
        for (uint32_t i = begin; i < end; i++) {
            if (list[i].view != kept) evidence[list[i].view].copy_of = kept;
            evidence[list[i].view].similarity = list[i].similarity;
        }
    }
    free(list);
    return status;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static enum vw_status begin(const struct vw_scene *scene, struct checking *checking, struct vw_check *check) {
    check->view_count = scene->view_count;
    check->evidence = vw_allocate(scene->view_count, sizeof *check->evidence);
    checking->beside = vw_allocate(scene->view_count, sizeof *checking->beside);
    checking->beside_counts = vw_allocate(scene->view_count, sizeof *checking->beside_counts);
    if (!check->evidence || !checking->beside || !checking->beside_counts) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_photo_evidence *evidence = &check->evidence[v];
        memset(evidence, 0xFF, sizeof *evidence); // NaN, no other photo, and padding that compares equal
        evidence->expected_count = evidence->tracks = 0;
        evidence->turned_over_deg = 0;
        evidence->orientation = vw_view_orientation(scene, v);
    }
    checking->evidence = check->evidence;
    enum vw_status status = vw_check_photos_open(scene, &checking->photos);
    struct vw_made_point *made = NULL;
    uint32_t made_count = 0;
    if (!status) status = vw_check_make_points(&checking->photos, &made, &made_count);
    if (!status) status = vw_check_take_points(&checking->photos, made, made_count);
    free(made);
    check->point_count = scene->point_count;
    check->made_count = made_count;
    return status;
}

static void end(struct checking *checking) {
    for (uint32_t v = 0; checking->beside && v < checking->photos.count; v++) free(checking->beside[v]);
    free(checking->beside);
    free(checking->beside_counts);
    vw_check_photos_close(&checking->photos);
}

enum vw_status vw_check_scene(const struct vw_scene *scene, struct vw_check *check) {
    struct checking checking = {0};
    *check = (struct vw_check){0};
    enum vw_status status = begin(scene, &checking, check);
    if (!status) status = vw_parallel_for(scene->view_count, check_photo, &checking);
    if (!status) status = compare_photos(&checking);
    if (!status) status = check_tracks(scene, check->evidence);
    if (!status) status = find_copies(scene, check->evidence);
    if (!status) status = vw_check_find_defects(check);
    end(&checking);
    if (status) vw_check_free(check);
    return status;
}

void vw_check_free(struct vw_check *check) {
    free(check->evidence);
    free(check->defects);
    *check = (struct vw_check){0};
}
