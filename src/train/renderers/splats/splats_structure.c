// Changes of structure, after 3DGS-MCMC (Kheradmand et al., NeurIPS 2024): splats that have faded move to others, and
// new ones are added to them. Each is drawn in proportion to opacity, and shares the opacity of the one that it joins.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/photo_order.h"
#include "train/renderers/splats/splats_structure.h"

static const double FADED = 0.005;       // opacity, as the paper has it
static const double OPACITY_MOST = 0.99; // beyond it, blending is no more opaque (blending.glsl)
static const double SPREAD = 0.5;        // how far from it those are put that join a splat, in standard deviations

static float *number(const struct vw_splat_set *set, uint32_t column, uint32_t splat, uint32_t lane) {
    return set->params + 4 * ((size_t)column * set->room + splat) + lane;
}

static double opacity_of(const struct vw_splat_set *set, uint32_t splat) {
    double opacity = 1.0 / (1.0 + exp(-(double)*number(set, SPLAT_MEAN, splat, 3)));
    return opacity < OPACITY_MOST ? opacity : OPACITY_MOST;
}

uint32_t vw_splats_count_born(const struct vw_splat_set *set) {
    uint32_t count = set->room;
    while (count > 1 && *number(set, SPLAT_MEAN, count - 1, 3) <= VW_SPLAT_UNBORN) count--;
    return count;
}

void vw_splats_close_up(struct vw_splat_set *set) {
    uint32_t born = vw_splats_count_born(set);
    for (uint32_t column = 1; column < set->columns; column++)
        memmove(set->params + 4 * (size_t)column * born, number(set, column, 0, 0), 16 * (size_t)born);
    set->room = born;
}

// Follows equation 9 of the paper, whose double sum is sum over k of C(n, k) (-1)^(k - 1) o'^k / sqrt(k).
void vw_splats_share(double opacity, uint32_t count, double *each, double *factor) {
    *each = -expm1(log1p(-opacity) / count);
    double sum = 0.0, term = -1.0;
    for (uint32_t k = 1; k <= count && fabs(term) > 1e-18; k++) {
        term *= -*each * (count - k + 1) / k;
        sum += term / sqrt(k);
    }
    *factor = opacity / sum;
}

// Sums up the opacities of the splats that others may join.
static double sum_opacities(const struct vw_splat_set *set, uint32_t born, double *sums) {
    double sum = 0.0;
    for (uint32_t i = 0; i < born; i++) {
        double opacity = opacity_of(set, i);
        sums[i] = sum += opacity > FADED ? opacity : 0.0;
    }
    return sum;
}

static uint32_t draw(const double *sums, uint32_t count, double at) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (sums[middle] > at) high = middle;
        else low = middle + 1;
    }
    return low;
}

// Turns a vector from the axes of a splat to those of the box.
static void turn(const float q[4], const double from[3], double to[3]) {
    double norm2 = 0.0;
    for (int i = 0; i < 4; i++) norm2 += (double)q[i] * q[i];
    double w = q[0], v[3] = {q[1], q[2], q[3]}, dot = v[0] * from[0] + v[1] * from[1] + v[2] * from[2];
    double v2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        double cross = v[j] * from[k] - v[k] * from[j];
        to[i] = ((w * w - v2) * from[i] + 2.0 * (v[i] * dot + w * cross)) / (norm2 > 0.0 ? norm2 : 1.0);
    }
}

// Moves a copy in a drawn direction: in the same place, two splats would move alike for good.
static void spread(const struct vw_splat_set *set, uint32_t splat, const uint32_t words[4]) {
    double angle = 2.0 * acos(-1.0) * vw_random_unit(words[1]), height = 2.0 * vw_random_unit(words[2]) - 1.0;
    double flat = sqrt(1.0 - height * height), at[3] = {flat * cos(angle), flat * sin(angle), height}, by[3];
    for (uint32_t i = 0; i < 3; i++) at[i] *= SPREAD * exp(*number(set, SPLAT_SCALE, splat, i));
    turn(number(set, SPLAT_TURN, splat, 0), at, by);
    for (uint32_t i = 0; i < 3; i++) *number(set, SPLAT_MEAN, splat, i) += (float)by[i];
}

static void copy(const struct vw_splat_set *set, uint32_t from, uint32_t to) {
    for (uint32_t column = 0; column < set->columns; column++)
        for (uint32_t lane = 0; lane < 4; lane++) *number(set, column, to, lane) = *number(set, column, from, lane);
}

static void forget(const struct vw_splat_set *set, uint32_t splat) {
    for (uint32_t m = 0; m < 2; m++)
        for (uint32_t column = 0; column < set->columns && set->moments[m]; column++)
            for (uint32_t lane = 0; lane < 4; lane++)
                set->moments[m][4 * ((size_t)column * set->room + splat) + lane] = 0.0f;
}

// Divides the opacity of a splat among it and those that join it.
static void shrink(const struct vw_splat_set *set, uint32_t splat, uint32_t count) {
    double each, factor;
    vw_splats_share(opacity_of(set, splat), count, &each, &factor);
    *number(set, SPLAT_MEAN, splat, 3) = (float)(log(each) - log1p(-each));
    for (uint32_t i = 0; i < 3; i++) *number(set, SPLAT_SCALE, splat, i) += (float)log(factor);
    forget(set, splat);
}

// Writes for each splat that moves which one it joins, and counts how many every one becomes.
static void draw_all(const struct vw_splat_set *set, uint32_t born, uint32_t wanted, const double *sums,
                     uint32_t *joined, uint32_t *counts) {
    for (uint32_t i = 0; i < wanted; i++) {
        uint32_t words[4];
        joined[i] = i;
        if (i < born && opacity_of(set, i) > FADED) continue;
        vw_random_words(set->seed, VW_RANDOM_STRUCTURE, set->step, i, 0, words);
        double unit = (words[0] + 0.5) * 0x1p-32;
        counts[joined[i] = draw(sums, born, unit * sums[born - 1])]++;
    }
}

enum vw_status vw_splats_restructure(const struct vw_splat_set *set, uint32_t wanted) {
    uint32_t born = vw_splats_count_born(set);
    if (wanted < born) wanted = born;
    double *sums = vw_allocate(born, sizeof *sums);
    uint32_t *joined = vw_allocate(wanted, sizeof *joined), *counts = vw_allocate(wanted, sizeof *counts);
    enum vw_status status = sums && joined && counts ? VW_OK : VW_ERROR_MEMORY;
    bool any = !status && sum_opacities(set, born, sums) > 0.0; // nothing is left to join
    if (any) draw_all(set, born, wanted, sums, joined, counts);
    for (uint32_t i = 0; any && i < born; i++)
        if (counts[i]) shrink(set, i, counts[i] + 1);
    for (uint32_t i = 0; any && i < wanted; i++) {
        if (joined[i] == i) continue;
        uint32_t words[4];
        vw_random_words(set->seed, VW_RANDOM_STRUCTURE, set->step, i, 0, words);
        copy(set, joined[i], i);
        spread(set, i, words);
        forget(set, i);
    }
    free(sums);
    free(joined);
    free(counts);
    return status;
}
