#include "check/explain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

enum { SEARCH_PX = 36, DRAWS = 400, ROUNDS = 8, UNKNOWNS = 6 };
static const float MATCHED = 0.65F;          // correlation with a place elsewhere
static const double INLIER_PX = 2.5;         // small pixels
static const double FITTING_LEAST = 0.3;     // share of the points, for a pose to be refined
static const double SHIFT_SPREAD = 0.1;      // a camera's shift, in median depths: without relief, a turn explains more
static const double BETTER = 2, GOOD = 0.25; // shares in place: times that by the scene's pose, and at least
static const double BETTER_OF_HALF = 1.5, HALF = 0.5;  // the same at another photo's pose, to which nothing is fitted
static const double FREER = 1.1;                       // times that of a zoom, which a pose, of six unknowns, must have
static const double ZOOM_MOST = 1.6, ZOOM_STEP = 1.01; // a step moves the corner of a small photo by 2 px

// A place of a point in the photo.
struct match {
    const double *position_world;
    double at_px[2], away_px[2]; // where the pose sees it, and how far from there the photo shows it
    double depth;
    bool fits;
};

struct matches {
    struct match *list;
    uint32_t count, expected_count;
};

// ---- Linear equations ----------------------------------------------------------------------------------------------

// Solves A x = b of a symmetric positive matrix by Cholesky's method, in place; false: it is singular.
static bool solve(double matrix[UNKNOWNS][UNKNOWNS], double side[UNKNOWNS], int count) {
    for (int i = 0; i < count; i++)
        for (int j = 0; j <= i; j++) {
            double sum = matrix[i][j];
            for (int k = 0; k < j; k++) sum -= matrix[i][k] * matrix[j][k];
            if (i == j && !(sum > 1e-12)) return false;
            matrix[i][j] = i == j ? sqrt(sum) : sum / matrix[j][j];
        }
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < i; k++) side[i] -= matrix[i][k] * side[k];
        side[i] /= matrix[i][i];
    }
    for (int i = count - 1; i >= 0; i--) {
        for (int k = i + 1; k < count; k++) side[i] -= matrix[k][i] * side[k];
        side[i] /= matrix[i][i];
    }
    return true;
}

// ---- A turn and a shift --------------------------------------------------------------------------------------------

// Returns the focal length along an axis of the small photo.
static double focal_px(const struct vw_check_photo *photo, int axis) {
    const struct vw_camera *camera = &photo->view->camera;
    return (axis ? camera->focal_y_px : camera->focal_x_px) * photo->small_per_px;
}

// Computes how a place in the photo moves (focal lengths) with a turn about the camera's axes, in radians, and with its
// shift along them, in depths of the point.
static void derive(const struct vw_check_photo *photo, const struct match *match, double rows[2][UNKNOWNS]) {
    const struct vw_camera *camera = &photo->view->camera;
    double x = (match->at_px[0] / photo->small_per_px - camera->centre_x_px) / camera->focal_x_px;
    double y = (match->at_px[1] / photo->small_per_px - camera->centre_y_px) / camera->focal_y_px; // down
    // Derivatives of X' = X - w x X - s in axes right, up, back, at X = (x, -y, -1) depths.
    const double of_x[UNKNOWNS] = {x * y, 1 + x * x, -y, -1, 0, -x}, of_y[UNKNOWNS] = {1 + y * y, x * y, x, 0, 1, -y};
    memcpy(rows[0], of_x, sizeof of_x);
    memcpy(rows[1], of_y, sizeof of_y);
}

// Adds the equations of a match to the least squares of the first `count` unknowns.
static void add_equations(const struct vw_check_photo *photo, const struct match *match, double depth_unit, int count,
                          double matrix[UNKNOWNS][UNKNOWNS], double side[UNKNOWNS]) {
    double rows[2][UNKNOWNS];
    derive(photo, match, rows);
    for (int r = 0; r < 2; r++)
        for (int i = 0; i < count; i++) {
            double of_i = rows[r][i] * (i < 3 ? 1 : depth_unit / match->depth);
            for (int j = 0; j < count; j++) matrix[i][j] += of_i * rows[r][j] * (j < 3 ? 1 : depth_unit / match->depth);
            side[i] += of_i * match->away_px[r] / focal_px(photo, r);
        }
}

// Marks and counts the matches that a turn explains.
static uint32_t count_fitting(const struct vw_check_photo *photo, const double turn[3], struct matches *matches) {
    uint32_t fitting = 0;
    for (uint32_t i = 0; i < matches->count; i++) {
        struct match *match = &matches->list[i];
        double rows[2][UNKNOWNS], apart_px = 0;
        derive(photo, match, rows);
        for (int r = 0; r < 2; r++)
            apart_px = hypot(apart_px, focal_px(photo, r) * vw_dot(rows[r], turn, 3) - match->away_px[r]);
        match->fits = apart_px <= INLIER_PX;
        fitting += match->fits;
    }
    return fitting;
}

// Finds the turn that explains most matches, of those that two of them give (RANSAC: Fischler and Bolles, CACM 1981).
static uint32_t find_turn(const struct vw_check_photo *photo, struct matches *matches) {
    double best[3] = {0};
    uint32_t most = 0;
    for (uint32_t draw = 0; draw < DRAWS; draw++) {
        uint32_t words[4];
        double matrix[UNKNOWNS][UNKNOWNS] = {{0}}, turn[UNKNOWNS] = {0};
        vw_random_words(0, VW_RANDOM_POSE, draw, 0, 0, words);
        for (int i = 0; i < 2; i++)
            add_equations(photo, &matches->list[vw_random_below(words[i], matches->count)], 0, 3, matrix, turn);
        if (!solve(matrix, turn, 3)) continue;
        uint32_t fitting = count_fitting(photo, turn, matches);
        if (fitting <= most) continue;
        most = fitting;
        memcpy(best, turn, sizeof best);
    }
    return count_fitting(photo, best, matches);
}

// Turns a pose about its own axes, and shifts it along them.
static void move_pose(double pose[3][4], const double turn[3], const double shift[3]) {
    double angle = sqrt(vw_dot(turn, turn, 3)), s = angle > 0 ? sin(angle) / angle : 1,
           c = angle > 0 ? (1 - cos(angle)) / (angle * angle) : 0.5;
    const double cross[3][3] = {{0, -turn[2], turn[1]}, {turn[2], 0, -turn[0]}, {-turn[1], turn[0], 0}};
    double turned[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double square = 0;
            for (int k = 0; k < 3; k++) square += cross[i][k] * cross[k][j];
            turned[i][j] = (i == j) + s * cross[i][j] + c * square; // Rodrigues
        }
    for (int i = 0; i < 3; i++) {
        double row[3] = {pose[i][0], pose[i][1], pose[i][2]};
        for (int j = 0; j < 3; j++) {
            pose[i][j] = row[0] * turned[0][j] + row[1] * turned[1][j] + row[2] * turned[2][j];
            pose[i][VW_POSE_POSITION] += row[j] * shift[j];
        }
    }
}

// Refines the pose by all matches that fit, with Gauss and Newton.
static void refine(const struct vw_check_photo *photo, double depth_unit, struct matches *matches, double pose[3][4]) {
    struct vw_view view = *photo->view;
    struct vw_check_photo moved = *photo;
    moved.view = &view;
    for (int round = 0; round < ROUNDS; round++) {
        double matrix[UNKNOWNS][UNKNOWNS] = {{0}}, step[UNKNOWNS] = {0};
        for (uint32_t i = 0; i < matches->count; i++) {
            struct match now = matches->list[i];
            memcpy(view.camera_to_world, pose, sizeof view.camera_to_world);
            if (!vw_check_project(&moved, now.position_world, now.at_px, &now.depth)) continue;
            for (int k = 0; k < 2; k++) now.away_px[k] += matches->list[i].at_px[k] - now.at_px[k];
            bool near = hypot(now.away_px[0], now.away_px[1]) <= INLIER_PX;
            if (round ? near : now.fits) add_equations(&moved, &now, depth_unit, UNKNOWNS, matrix, step);
        }
        for (int i = 3; i < UNKNOWNS; i++) matrix[i][i] += 1 / (SHIFT_SPREAD * SHIFT_SPREAD);
        for (int i = 0; i < 3; i++) matrix[i][i] += 1e-9;
        if (!solve(matrix, step, UNKNOWNS)) return;
        for (int i = 3; i < UNKNOWNS; i++) step[i] *= depth_unit;
        move_pose(pose, step, step + 3);
    }
}

// ---- Explanations --------------------------------------------------------------------------------------------------

static enum vw_status match_all(const struct vw_check_photos *photos, const struct vw_check_photo *photo,
                                const struct vw_expected *expected, struct matches *matches) {
    matches->expected_count = expected->count;
    matches->list = vw_allocate(expected->count, sizeof *matches->list);
    if (!matches->list) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < expected->count; i++) {
        const struct vw_expected_point *point = &expected->list[i];
        double away_px[2];
        if (vw_patch_find(&photo->small, point->at_px, &point->patch, SEARCH_PX, away_px) < MATCHED) continue;
        matches->list[matches->count++] = (struct match){.position_world = photos->points[point->point],
                                                         .at_px = {point->at_px[0], point->at_px[1]},
                                                         .away_px = {away_px[0], away_px[1]},
                                                         .depth = point->depth};
    }
    return VW_OK;
}

static double angle_between(const double a[3][4], const double b[3][4]) {
    double trace = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) trace += a[i][j] * b[i][j];
    return acos(fmin(fmax((trace - 1) / 2, -1), 1)) * 180 / M_PI;
}

static double median_depth(const struct matches *matches, double *values) {
    for (uint32_t i = 0; i < matches->count; i++) values[i] = matches->list[i].depth;
    return vw_median(values, matches->count);
}

static double median_away_px(const struct matches *matches, double *values) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < matches->count; i++)
        if (matches->list[i].fits) values[count++] = hypot(matches->list[i].away_px[0], matches->list[i].away_px[1]);
    return vw_median(values, count);
}

// Returns the share in place of what a changed view sees.
static double mark_changed(const struct vw_check_photos *photos, uint32_t index, const struct vw_view *changed,
                           struct vw_expected *expected) {
    struct vw_check_photo photo = photos->list[index];
    photo.view = changed;
    vw_expected_list(photos, &photo, index, expected);
    return vw_expected_mark(&photo.small, expected);
}

// Finds the pose that the photo shows, near the scene's.
static enum vw_status find_pose(const struct vw_check_photos *photos, uint32_t index, struct matches *matches,
                                struct vw_expected *expected, struct vw_photo_evidence *evidence) {
    const struct vw_check_photo *photo = &photos->list[index];
    if (find_turn(photo, matches) < FITTING_LEAST * matches->expected_count) return VW_OK;
    struct vw_view view = *photo->view;
    double *values = vw_allocate(matches->count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    evidence->moved_px = median_away_px(matches, values) / photo->small_per_px;
    refine(photo, median_depth(matches, values), matches, view.camera_to_world);
    free(values);
    evidence->found_in_place = mark_changed(photos, index, &view, expected);
    evidence->turned_deg = angle_between(photo->view->camera_to_world, (const double(*)[4])view.camera_to_world);
    memcpy(evidence->pose_found, view.camera_to_world, sizeof view.camera_to_world);
    return VW_OK;
}

// Sums over matches that a zoom explains what the best one is made of: of these their number.
static uint32_t sum_zoomed(const struct vw_check_photo *photo, const struct matches *matches, double zoom,
                           double *along, double *squares) {
    const struct vw_camera *camera = &photo->view->camera;
    uint32_t fitting = 0;
    *along = *squares = 0;
    for (uint32_t i = 0; i < matches->count; i++) {
        const struct match *match = &matches->list[i];
        double x = match->at_px[0] - camera->centre_x_px * photo->small_per_px;
        double y = match->at_px[1] - camera->centre_y_px * photo->small_per_px;
        if (hypot(match->away_px[0] - (zoom - 1) * x, match->away_px[1] - (zoom - 1) * y) > INLIER_PX) continue;
        *along += match->away_px[0] * x + match->away_px[1] * y;
        *squares += x * x + y * y;
        fitting++;
    }
    return fitting;
}

// Finds the focal length that the photo shows, by that of its camera: of those tried the one that explains most
// matches.
static void find_zoom(const struct vw_check_photos *photos, uint32_t index, const struct matches *matches,
                      struct vw_expected *expected, struct vw_photo_evidence *evidence) {
    const struct vw_check_photo *photo = &photos->list[index];
    double along, squares, best = 1;
    uint32_t most = 0;
    for (double zoom = 1 / ZOOM_MOST; zoom <= ZOOM_MOST; zoom *= ZOOM_STEP) {
        uint32_t fitting = sum_zoomed(photo, matches, zoom, &along, &squares);
        if (fitting > most) most = fitting, best = zoom;
    }
    if (most < FITTING_LEAST * matches->expected_count) return;
    (void)sum_zoomed(photo, matches, best, &along, &squares);
    struct vw_view view = *photo->view;
    evidence->zoom = 1 + along / squares;
    view.camera.focal_x_px *= evidence->zoom, view.camera.focal_y_px *= evidence->zoom;
    evidence->zoomed_in_place = mark_changed(photos, index, &view, expected);
}

// Returns the share of the points in place that another photo's pose sees; NaN if its photos have another size.
static double in_place_at(const struct vw_check_photos *photos, uint32_t view, uint32_t pose,
                          struct vw_expected *expected) {
    const struct vw_plane *plane = &photos->list[view].small, *other = &photos->list[pose].small;
    if (plane->width_px != other->width_px || plane->height_px != other->height_px) return NAN;
    vw_expected_list(photos, &photos->list[pose], view, expected);
    return vw_expected_mark(plane, expected);
}

static void find_photo(const struct vw_check_photos *photos, uint32_t view, struct vw_expected *expected,
                       struct vw_photo_evidence *evidence) {
    const struct vw_check_photo *photo = &photos->list[view];
    for (uint32_t i = 0; i < photo->other_count; i++) {
        double share = in_place_at(photos, view, photo->others[i], expected);
        if (!(share > fmax(evidence->shows_in_place, 0))) continue;
        evidence->shows_in_place = share;
        evidence->shows = photo->others[i];
    }
}

// Computes the share that the photo shows in place when it is turned by quarters.
static enum vw_status turn_over(const struct vw_plane *plane, struct vw_expected *expected,
                                struct vw_photo_evidence *evidence) {
    size_t count = (size_t)plane->width_px * plane->height_px;
    uint32_t side = plane->width_px;
    struct vw_plane turned = {vw_allocate(count, sizeof *turned.values), plane->width_px, plane->height_px};
    if (!turned.values) return VW_ERROR_MEMORY;
    evidence->turned_over_in_place = 0;
    for (uint32_t quarters = 1; quarters < 4; quarters++) {
        if (quarters != 2 && plane->width_px != plane->height_px) continue;
        for (size_t i = 0; i < count; i++) {
            size_t x = i % side, y = i / side,
                   from = quarters == 2   ? count - 1 - i
                          : quarters == 1 ? (side - 1 - x) * side + y
                                          : x * side + side - 1 - y;
            turned.values[i] = plane->values[from];
        }
        double share = vw_expected_mark(&turned, expected);
        if (!(share > evidence->turned_over_in_place)) continue;
        evidence->turned_over_in_place = share;
        evidence->turned_over_deg = 90 * quarters;
    }
    free(turned.values);
    return VW_OK;
}

// Fills the evidence on a pose and a focal length, from places that the photo shows elsewhere.
static enum vw_status find_changes(const struct vw_check_photos *photos, uint32_t view, struct vw_expected *expected,
                                   struct vw_photo_evidence *evidence) {
    struct matches matches = {0};
    enum vw_status status = match_all(photos, &photos->list[view], expected, &matches);
    if (!status && matches.count >= VW_EXPECTED_FEW / 2) {
        status = find_pose(photos, view, &matches, expected, evidence);
        if (!status) find_zoom(photos, view, &matches, expected, evidence);
    }
    free(matches.list);
    return status;
}

static double least_of(const struct vw_photo_evidence *evidence) { return fmax(BETTER * evidence->in_place, GOOD); }

// Keeps the explanation by which the photo shows most in place, of those by which it shows enough, and makes the view
// that it says.
static void choose(const struct vw_check_photos *photos, struct vw_photo_evidence *evidence, struct vw_view *seen) {
    double least = least_of(evidence), least_of_photo = fmin(least, fmax(BETTER_OF_HALF * evidence->in_place, HALF));
    bool turned_over = evidence->turned_over_in_place >= least;
    bool zoomed = !turned_over && evidence->zoomed_in_place >= fmax(least, evidence->found_in_place / FREER);
    bool found = !turned_over && !zoomed && evidence->found_in_place >= least;
    double changed = zoomed ? evidence->zoomed_in_place : found ? evidence->found_in_place : 0;
    bool shows = !turned_over && evidence->shows_in_place >= fmax(least_of_photo, changed);
    if (!turned_over) evidence->turned_over_deg = 0;
    if (!shows) evidence->shows = UINT32_MAX;
    if (!found || shows) evidence->turned_deg = evidence->moved_px = NAN;
    if (!zoomed || shows) evidence->zoom = NAN;
    if (shows)
        memcpy(seen->camera_to_world, photos->list[evidence->shows].view->camera_to_world,
               sizeof seen->camera_to_world);
    else if (found) memcpy(seen->camera_to_world, evidence->pose_found, sizeof seen->camera_to_world);
    else if (zoomed) seen->camera.focal_x_px *= evidence->zoom, seen->camera.focal_y_px *= evidence->zoom;
}

enum vw_status vw_check_explain(const struct vw_check_photos *photos, uint32_t view, struct vw_expected *expected,
                                struct vw_photo_evidence *evidence) {
    struct vw_view seen = *photos->list[view].view;
    enum vw_status status = turn_over(&photos->list[view].small, expected, evidence);
    if (!status) status = find_changes(photos, view, expected, evidence);
    if (status) return status;
    if (!(evidence->turned_over_in_place >= least_of(evidence))) find_photo(photos, view, expected, evidence);
    choose(photos, evidence, &seen);
    (void)mark_changed(photos, view, &seen, expected);
    return VW_OK;
}
