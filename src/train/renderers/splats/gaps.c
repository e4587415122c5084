// The gaps between points: distances to the three nearest others, by a k-d tree that lies in an array (the root of a
// range is its middle, by an axis that changes from level to level).
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "train/renderers/splats/splats_renderer.h"

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
