#include "scene/duplicates.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "image/image.h"
#include "viewworth/scene.h"

// CELLS along each axis that are averaged, over SAMPLES along each axis; PLACES of means of 2 x 2 cells; POINTS of a
// photo that are looked up in another.
enum { CELLS = 32, SAMPLES = 4, PLACES = CELLS - 1, POINTS = CELLS / 2 };
enum { MOVES = 2 * 3 * 3 }; // axes, and ways of either edge
enum { SHARED_LEAST = 8 };  // points that tell photos apart
static const double ANGLE_MOST = 2.0 * M_PI / 180;
static const double FLAT_CONTRAST = 1.0 / 255;         // standard deviation below which there is nothing to compare
static const double STEP_FIRST = 1.6, STEP_LAST = 0.2; // places that an edge of a frame moves

// Limits of near-duplicates. The first rule is for photos that were taken anywhere, the second for those taken
// together.
static const struct rule {
    double similarity;      // at least
    double glance;          // correlation at least, before their frames are aligned
    double edge;            // places that an edge of the frame may move
    double missing_by_step; // similarity at most, per place of the next step, for which aligning goes on
} rules[] = {{0.995, 0.8, 1.6, 0.1}, {0.95, 0.2, 4.5, 0.25}};

// Luminances around the places; NaN where the photo hides or lacks pixels.
struct fingerprint {
    float places[PLACES][PLACES];
    uint32_t points; // points that are not NaN
};

// The first and last places of a photo, as places of another one, and whether left and right are exchanged.
struct frame {
    double edges[4]; // left, top, right, bottom
    bool mirrored;
};

// ---- What photos show ----

// Returns the pixel of sample `index` along a side.
static uint32_t pixel_of(uint32_t index, uint32_t side_px) {
    return (uint32_t)(((uint64_t)2 * index + 1) * side_px / (2 * CELLS * SAMPLES));
}

static bool has_pixel(const struct vw_view *view, uint32_t x_px, uint32_t y_px) {
    float rgba[4] = {0, 0, 0, 1};
    if (view->image.has_alpha) vw_image_pixel(&view->image, x_px, y_px, rgba);
    return rgba[3] >= 0.5F && vw_view_keeps(view, x_px, y_px);
}

// Averages over a grid of samples whose size does not depend on the photo's; NaN if more than a quarter are missing.
static float mean_of_cell(const struct vw_view *view, uint32_t cell_x, uint32_t cell_y) {
    static const float black[3] = {0, 0, 0};
    double sum = 0;
    uint32_t count = 0;
    for (uint32_t i = 0; i < SAMPLES * SAMPLES; i++) {
        uint32_t x_px = pixel_of(cell_x * SAMPLES + i % SAMPLES, view->image.width_px);
        uint32_t y_px = pixel_of(cell_y * SAMPLES + i / SAMPLES, view->image.height_px);
        if (!has_pixel(view, x_px, y_px)) continue;
        sum += vw_image_luminance(&view->image, x_px, y_px, black);
        count++;
    }
    return 4 * count >= 3 * SAMPLES * SAMPLES ? (float)(sum / count) : NAN;
}

static void take_fingerprint(const struct vw_view *view, struct fingerprint *print) {
    float cells[CELLS][CELLS];
    for (uint32_t i = 0; i < CELLS * CELLS; i++) cells[i / CELLS][i % CELLS] = mean_of_cell(view, i % CELLS, i / CELLS);
    for (uint32_t y = 0; y < PLACES; y++)
        for (uint32_t x = 0; x < PLACES; x++) {
            print->places[y][x] = (cells[y][x] + cells[y][x + 1] + cells[y + 1][x] + cells[y + 1][x + 1]) / 4;
            if (x % 2 == 0 && y % 2 == 0 && !isnan(print->places[y][x])) print->points++;
        }
}

// ---- How alike they are ----

// Interpolates along one axis: the weight of place `*place` + 1; NaN outside of the photo.
static float locate(double position, uint32_t *place) {
    *place = (uint32_t)fmin(fmax(position, 0), PLACES - 2);
    return position >= 0 && position <= PLACES - 1 ? (float)(position - *place) : NAN;
}

// Correlates every `step`-th point of `a` along each axis with what `b` has there; 0 if they share too little.
static double correlate(const struct fingerprint *a, const struct fingerprint *b, const struct frame *frame,
                        uint32_t step) {
    const double *edges = frame->edges;
    double count = 0, sum_a = 0, sum_b = 0, squares_a = 0, squares_b = 0, products = 0;
    uint32_t columns[POINTS];
    float weights[POINTS];
    for (uint32_t i = 0; i < POINTS; i += step) {
        double x = edges[0] + (edges[2] - edges[0]) * i / (POINTS - 1);
        weights[i] = locate(frame->mirrored ? PLACES - 1 - x : x, &columns[i]);
    }
    for (uint32_t j = 0; j < POINTS; j += step) {
        uint32_t row;
        float down = locate(edges[1] + (edges[3] - edges[1]) * j / (POINTS - 1), &row);
        for (uint32_t i = 0; i < POINTS; i += step) {
            const float *above = &b->places[row][columns[i]], *below = &b->places[row + 1][columns[i]];
            float left = above[0] + down * (below[0] - above[0]), right = above[1] + down * (below[1] - above[1]);
            double at_a = a->places[2 * j][2 * i], at_b = left + weights[i] * (right - left);
            if (isnan(at_a) || isnan(at_b)) continue;
            count++;
            sum_a += at_a, sum_b += at_b;
            squares_a += at_a * at_a, squares_b += at_b * at_b, products += at_a * at_b;
        }
    }
    double least = fmax(0.5 * fmin(a->points, b->points), SHARED_LEAST) / (step * step);
    double variance_a = squares_a - sum_a * sum_a / count, variance_b = squares_b - sum_b * sum_b / count;
    bool flat = fmin(variance_a, variance_b) < count * FLAT_CONTRAST * FLAT_CONTRAST;
    if (count < least || flat) return 0;
    return fmin((products - sum_a * sum_b / count) / sqrt(variance_a * variance_b), 1);
}

// Moves edges while that helps: one or both of an axis at a time.
static double refine(const struct fingerprint *a, const struct fingerprint *b, double step, double edge_most,
                     double similarity, struct frame *frame) {
    for (uint32_t move = 0, failed = 0; failed < MOVES; move = (move + 1) % MOVES) {
        struct frame moved = *frame;
        double *begin = &moved.edges[move % 2], *end = begin + 2;
        *begin += step * (move / 2 % 3 - 1.0);
        *end += step * (move / 6 - 1.0);
        bool may = fabs(*begin) <= edge_most && fabs(*end - (PLACES - 1)) <= edge_most;
        double found = may ? correlate(a, b, &moved, 1) : 0;
        failed = found > similarity + 1e-5 ? 0 : failed + 1;
        if (failed) continue;
        similarity = found;
        *frame = moved;
    }
    return similarity;
}

// Finds the best of frames whose edges are moved by the first step or not at all, by few points.
static struct frame find_start(const struct fingerprint *a, const struct fingerprint *b, bool mirrored) {
    struct frame best = {{0, 0, PLACES - 1, PLACES - 1}, mirrored};
    double similarity = correlate(a, b, &best, 2);
    for (int start = 0; start < 3 * 3 * 3 * 3; start++) {
        struct frame frame = {{0, 0, PLACES - 1, PLACES - 1}, mirrored};
        for (int edge = 0, rest = start; edge < 4; edge++, rest /= 3) frame.edges[edge] += STEP_FIRST * (rest % 3 - 1);
        double found = correlate(a, b, &frame, 2);
        if (found <= similarity) continue;
        similarity = found;
        best = frame;
    }
    return best;
}

// Returns the largest correlation over frames: shifted, cut off or with a border at each edge. Gives up early where
// the rule's is out of reach.
static double align(const struct fingerprint *a, const struct fingerprint *b, bool mirrored, const struct rule *rule) {
    struct frame frame = find_start(a, b, mirrored);
    double similarity = correlate(a, b, &frame, 1);
    for (double step = STEP_FIRST; step >= STEP_LAST; step /= 2)
        if (similarity > rule->similarity - rule->missing_by_step * step)
            similarity = refine(a, b, step, rule->edge, similarity, &frame);
    return similarity;
}

// Returns 0 if the rule makes no near-duplicates of them.
static double compare(const struct fingerprint *a, const struct fingerprint *b, const struct rule *rule) {
    double similarity = 0;
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        struct frame whole = {{0, 0, PLACES - 1, PLACES - 1}, mirrored};
        if (correlate(a, b, &whole, 2) < rule->glance) continue;
        similarity = fmax(similarity, align(a, b, mirrored, rule));
    }
    return similarity >= rule->similarity ? similarity : 0;
}

// ---- Where they were taken ----

// Returns the distance of the nearest thing in the view: its near depth if known, otherwise the distance of the box's
// centre.
static double depth_of(const struct vw_scene *scene, const struct vw_view *view) {
    if (view->near_world > 0) return view->near_world;
    double away[3];
    for (int i = 0; i < 3; i++) away[i] = view->camera_to_world[i][VW_POSE_POSITION] - scene->box.centre_world[i];
    return hypot(hypot(away[0], away[1]), away[2]);
}

static bool stand_together(const struct vw_scene *scene, const struct vw_view *a, const struct vw_view *b) {
    double depth = fmin(depth_of(scene, a), depth_of(scene, b)), between = 0, trace = 0;
    for (int i = 0; i < 3; i++) {
        between = hypot(between, a->camera_to_world[i][3] - b->camera_to_world[i][3]);
        for (int j = 0; j < 3; j++) trace += a->camera_to_world[i][j] * b->camera_to_world[i][j];
    }
    double turn = acos(fmin(fmax((trace - 1) / 2, -1), 1)); // angle of the rotation between the cameras
    return between <= tan(ANGLE_MOST) * depth && turn <= ANGLE_MOST;
}

// ---- Groups ----

static bool is_asked(const struct vw_view *view) { return view->split != VW_SPLIT_EXCLUDED; }

// Returns 0 for photos that are not near-duplicates.
static double similarity_of(const struct vw_scene *scene, const struct fingerprint *prints, uint32_t a, uint32_t b) {
    const struct vw_view *first = &scene->views[a], *second = &scene->views[b];
    if (memcmp(first->sha256, second->sha256, sizeof first->sha256) == 0) return 1;
    return compare(&prints[a], &prints[b], &rules[stand_together(scene, first, second)]);
}

// Finds the photo that view v is most like. A leader comes before a photo that is more like its own leader. Returns v
// itself if there is none.
static uint32_t find_leader(const struct vw_scene *scene, const struct fingerprint *prints, const uint32_t *leaders,
                            const double *similarities, uint32_t v, double *similarity) {
    uint32_t found = v;
    double rank = 0;
    for (uint32_t first = 0; first < v && rank < 2; first++) {
        if (!is_asked(&scene->views[first])) continue;
        double alike = similarity_of(scene, prints, first, v);
        bool comes_before = leaders[first] == first || alike > similarities[first];
        if (alike == 0 || alike + comes_before <= rank) continue;
        found = first;
        *similarity = alike;
        rank = alike + comes_before;
    }
    return found;
}

// Sets leaders[v] to the first photo of its group; to v itself if there is no other in it.
static void find_leaders(const struct vw_scene *scene, const struct fingerprint *prints, uint32_t *leaders,
                         double *similarities) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        leaders[v] = v;
        similarities[v] = 1;
        if (!is_asked(&scene->views[v])) continue;
        double similarity = 1;
        uint32_t leader = find_leader(scene, prints, leaders, similarities, v, &similarity);
        leaders[leader] = leader; // leaves its group, if it was in one
        similarities[leader] = 1;
        leaders[v] = leader;
        similarities[v] = similarity;
    }
}

// Lists all groups of more than one photo; returns their number of photos. At worst O(photos^2) comparisons in memory.
static uint32_t list_groups(uint32_t view_count, const uint32_t *leaders, const double *similarities,
                            struct vw_duplicate *duplicates) {
    uint32_t count = 0, group = 0;
    for (uint32_t first = 0; first < view_count; first++) {
        uint32_t begin = count;
        if (leaders[first] != first) continue;
        for (uint32_t v = first; v < view_count; v++)
            if (leaders[v] == first) duplicates[count++] = (struct vw_duplicate){group, v, similarities[v]};
        if (count - begin > 1) group++;
        else count = begin;
    }
    return count;
}

enum vw_status vw_scene_find_duplicates(const struct vw_scene *scene, struct vw_duplicate **duplicates,
                                        uint32_t *count) {
    struct fingerprint *prints = vw_allocate(scene->view_count, sizeof *prints);
    uint32_t *leaders = vw_allocate(scene->view_count, sizeof *leaders);
    double *similarities = vw_allocate(scene->view_count, sizeof *similarities);
    struct vw_duplicate *found = vw_allocate(scene->view_count, sizeof *found);
    enum vw_status status = prints && leaders && similarities && found ? vw_scene_decode_all(scene) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        if (is_asked(&scene->views[v])) take_fingerprint(&scene->views[v], &prints[v]);
    if (!status) {
        find_leaders(scene, prints, leaders, similarities);
        *count = list_groups(scene->view_count, leaders, similarities, found);
        *duplicates = found;
    } else {
        free(found);
    }
    free(prints);
    free(leaders);
    free(similarities);
    return status;
}

// ---- Pairs ----

static enum vw_status take_fingerprints(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                        struct fingerprint *prints) {
    enum vw_status status = vw_scene_decode(scene, views, count);
    for (uint32_t i = 0; !status && i < count; i++) take_fingerprint(&scene->views[views[i]], &prints[views[i]]);
    return status;
}

enum vw_status vw_scene_match_duplicates(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                         const uint32_t *others, uint32_t other_count, uint32_t *matches) {
    struct fingerprint *prints = vw_allocate(scene->view_count, sizeof *prints);
    enum vw_status status = prints ? take_fingerprints(scene, views, count, prints) : VW_ERROR_MEMORY;
    if (!status) status = take_fingerprints(scene, others, other_count, prints);
    for (uint32_t i = 0; !status && i < count; i++) {
        double most = 0;
        matches[i] = UINT32_MAX;
        for (uint32_t j = 0; j < other_count; j++) {
            double similarity = similarity_of(scene, prints, others[j], views[i]);
            if (similarity > most) matches[i] = others[j];
            most = fmax(most, similarity);
        }
    }
    free(prints);
    return status;
}
