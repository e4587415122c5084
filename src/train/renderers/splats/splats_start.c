// Initial values of splats: those of a file, or at the points of structure from motion that train views see, so that
// validation and test photos add nothing; without points, where train photos agree. Sizes follow the gaps between them.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/model.h"
#include "train/renderers/splats/splat_file.h"
#include "train/renderers/splats/splats.h"

// ---- Gaps between points --------------------------------------------------------------------------------------------

// Distances to the three nearest others, by a k-d tree that lies in an array (the root of a range is its middle, by an
// axis that changes from level to level).
enum { NEAREST = 3 };
static const float ALONE = 0.05f; // gap of a point without others, in box edges

struct node {
    float at[3];
    uint32_t point;
};

// Nodes by one axis; equal ones by their points, so that the tree does not depend on how qsort() works.
static int by_axis(const struct node *a, const struct node *b, int axis) {
    if (a->at[axis] != b->at[axis]) return a->at[axis] < b->at[axis] ? -1 : 1;
    return (a->point > b->point) - (a->point < b->point);
}
static int by_x(const void *a, const void *b) { return by_axis(a, b, 0); }
static int by_y(const void *a, const void *b) { return by_axis(a, b, 1); }
static int by_z(const void *a, const void *b) { return by_axis(a, b, 2); }

static void build(struct node *nodes, uint32_t count, int axis) {
    static int (*const orders[3])(const void *, const void *) = {by_x, by_y, by_z};
    if (count < 2) return;
    qsort(nodes, count, sizeof *nodes, orders[axis]);
    build(nodes, count / 2, (axis + 1) % 3);
    build(nodes + count / 2 + 1, count - count / 2 - 1, (axis + 1) % 3);
}

struct search {
    const float *at;
    uint32_t point, found;
    float nearest2[NEAREST]; // squared distances, ascending
};

static void offer(struct search *search, float distance2) {
    uint32_t i = search->found < NEAREST ? search->found++ : NEAREST;
    if (i == NEAREST && distance2 >= search->nearest2[NEAREST - 1]) return;
    if (i == NEAREST) i--;
    for (; i > 0 && search->nearest2[i - 1] > distance2; i--) search->nearest2[i] = search->nearest2[i - 1];
    search->nearest2[i] = distance2;
}

static void visit(struct search *search, const struct node *nodes, uint32_t count, int axis) {
    if (!count) return;
    const struct node *root = nodes + count / 2;
    float beside = search->at[axis] - root->at[axis], distance2 = 0.0f;
    for (int i = 0; i < 3; i++) distance2 += (search->at[i] - root->at[i]) * (search->at[i] - root->at[i]);
    if (root->point != search->point) offer(search, distance2);
    const struct node *sides[2] = {nodes, root + 1};
    uint32_t counts[2] = {count / 2, count - count / 2 - 1};
    bool second = beside > 0.0f; // the point is on the second side
    visit(search, sides[second], counts[second], (axis + 1) % 3);
    if (search->found < NEAREST || beside * beside < search->nearest2[NEAREST - 1])
        visit(search, sides[!second], counts[!second], (axis + 1) % 3);
}

enum vw_status vw_splats_measure_gaps(const float (*points)[3], uint32_t count, float least, float *gaps) {
    struct node *nodes = vw_allocate(count, sizeof *nodes);
    if (!nodes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++)
        nodes[i] = (struct node){.at = {points[i][0], points[i][1], points[i][2]}, .point = i};
    build(nodes, count, 0);
    for (uint32_t i = 0; i < count; i++) {
        struct search search = {.at = points[i], .point = i};
        float sum = 0.0f;
        visit(&search, nodes, count, 0);
        for (uint32_t k = 0; k < search.found; k++) sum += search.nearest2[k];
        gaps[i] = search.found ? fmaxf(sqrtf(sum / (float)search.found), least) : ALONE;
    }
    free(nodes);
    return VW_OK;
}

// ---- Initial values -------------------------------------------------------------------------------------------------

static const float OPACITY = 0.1f, CONSTANT_HARMONIC = 0.28209479f; // the latter of harmonics.glsl
static const float GAP_LEAST = 3e-4f;                               // box edges; coincident points have none
static const float GAP_SHARE = 0.95f; // share of gaps that are kept; those above are cut to the largest of these

static bool is_seen(const struct vw_model *model, const struct vw_scene *scene, const struct vw_point *point) {
    for (uint32_t t = 0; t < point->track_count; t++)
        if (vw_model_trains_on(model, scene, scene->tracks[point->first_track + t].view)) return true;
    return false;
}

uint32_t vw_splats_count_points(const struct vw_model *model, const struct vw_scene *scene) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->point_count; i++) count += is_seen(model, scene, &scene->points[i]);
    return count;
}

static int by_number(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

// Lists the points that are seen; of more than there are splats, draws as many (Fisher-Yates), in their order.
static void choose_points(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed, uint32_t *list) {
    uint32_t listed = 0, count = vw_splat_model_of(model)->count;
    for (uint32_t i = 0; i < scene->point_count; i++)
        if (is_seen(model, scene, &scene->points[i])) list[listed++] = i;
    if (listed <= count) return;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t words[4], kept = list[i];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, i, 1, words);
        uint32_t from = i + vw_random_below(words[0], listed - i);
        list[i] = list[from];
        list[from] = kept;
    }
    qsort(list, count, sizeof *list, by_number);
}

struct start {
    uint32_t *list;                          // points, by index in the scene
    float (*means)[3], *gaps, (*colours)[3]; // by splat; box coordinates
};

static enum vw_status create_start(uint32_t points, uint32_t count, struct start *start) {
    *start = (struct start){.list = vw_allocate(points, sizeof *start->list),
                            .means = vw_allocate(count, sizeof *start->means),
                            .gaps = vw_allocate(count, sizeof *start->gaps),
                            .colours = vw_allocate(count, sizeof *start->colours)};
    return start->list && start->means && start->gaps && start->colours ? VW_OK : VW_ERROR_MEMORY;
}

static void destroy_start(struct start *start) {
    free(start->list);
    free(start->means);
    free(start->gaps);
    free(start->colours);
}

// Places the first splats: one at each point that is listed.
static void place_at_points(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed, uint32_t count,
                            struct start *start) {
    double edge = 2.0 * model->box.half_extent_world;
    choose_points(model, scene, seed, start->list);
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_point *point = &scene->points[start->list[i]];
        for (uint32_t axis = 0; axis < 3; axis++) {
            start->means[i][axis] = (float)((point->position_world[axis] - model->box.centre_world[axis]) / edge + 0.5);
            start->colours[i][axis] = point->rgb[axis];
        }
    }
}

// Places all splats where photos agree; those that photos tell nothing of, anywhere in the box.
static enum vw_status place_without_points(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                           uint32_t count, struct start *start) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, i, 0, words);
        for (uint32_t axis = 0; axis < 3; axis++) {
            start->means[i][axis] = vw_random_unit(words[axis]);
            start->colours[i][axis] = 0.5f;
        }
    }
    return vw_splats_place_by_photos(model, scene, seed, count, start->means, start->colours);
}

// Places the splats beyond one for each point: each point has one more in turn, along no axis farther from it than the
// gap between points there. A point's own do not depend on what other points there are, but for their gaps.
static void place_more(uint64_t seed, uint32_t points, uint32_t count, struct start *start) {
    for (uint32_t i = points; i < count; i++) {
        uint32_t words[4], from = i % points, copy = i / points;
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, start->list[from], 1 + copy, words);
        for (uint32_t axis = 0; axis < 3; axis++)
            start->means[i][axis] =
                start->means[from][axis] + start->gaps[from] * (2.0f * vw_random_unit(words[axis]) - 1.0f);
        memcpy(start->colours[i], start->colours[from], sizeof start->colours[i]);
    }
}

static int by_size(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static enum vw_status cut_gaps(float *gaps, uint32_t count) {
    float *sorted = vw_allocate(count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) sorted[i] = gaps[i];
    qsort(sorted, count, sizeof *sorted, by_size);
    float most = sorted[(uint32_t)(GAP_SHARE * (float)(count - 1))];
    for (uint32_t i = 0; i < count; i++) gaps[i] = fminf(gaps[i], most);
    free(sorted);
    return VW_OK;
}

static enum vw_status measure_gaps(struct start *start, uint32_t count) {
    enum vw_status status = vw_splats_measure_gaps((const float(*)[3])start->means, count, GAP_LEAST, start->gaps);
    return status ? status : cut_gaps(start->gaps, count);
}

static void write_splat(const struct start *start, uint32_t splat, uint32_t count, float *params) {
    size_t column = 4 * (size_t)count;
    float *own = params + 4 * (size_t)splat;
    for (uint32_t i = 0; i < 3; i++) {
        own[SPLAT_MEAN * column + i] = start->means[splat][i];
        own[SPLAT_SCALE * column + i] = logf(start->gaps[splat]);
        own[SPLAT_HARMONICS * column + i] = (start->colours[splat][i] - 0.5f) / CONSTANT_HARMONIC;
    }
    own[SPLAT_MEAN * column + 3] = logf(OPACITY / (1.0f - OPACITY));
    own[SPLAT_TURN * column] = 1.0f;
}

static enum vw_status start_from_file(const struct vw_model *model, const struct vw_scene *scene, float *params) {
    const struct vw_splat_model *splats = vw_splat_model_of(model);
    struct vw_splat_file file = {0};
    enum vw_status status = vw_splats_read_initial(model->config->initial, model->config->initial_sha256, &file);
    if (!status && (file.count != splats->count || file.degree > splats->degree))
        status = vw_fail(VW_ERROR_INPUT, "%s: does not have the splats that the configuration names",
                         model->config->initial);
    if (!status) status = vw_splat_file_place(&file, model->config->initial, splats->degree, &model->box, params);
    if (!status) status = vw_splats_filter(model, scene, true, params);
    vw_splat_file_free(&file);
    return status;
}

enum vw_status vw_splats_start(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                               float *params) {
    if (model->config->initial[0]) return start_from_file(model, scene, params);
    uint32_t count = vw_splat_model_of(model)->count, sources = vw_splat_model_of(model)->source_count,
             first = sources && sources < count ? sources : count;
    struct start start;
    enum vw_status status = create_start(sources, count, &start);
    if (!status && sources) place_at_points(model, scene, seed, first, &start);
    if (!status && !sources) status = place_without_points(model, scene, seed, count, &start);
    if (!status) status = measure_gaps(&start, first);
    if (!status) place_more(seed, first, count, &start);
    if (!status && first < count) status = measure_gaps(&start, count);
    for (uint32_t i = 0; i < count && !status; i++) write_splat(&start, i, count, params);
    if (!status) status = vw_splats_filter(model, scene, false, params);
    destroy_start(&start);
    return status;
}
