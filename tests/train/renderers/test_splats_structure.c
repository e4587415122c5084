// Changes of the structure of splats: those that share one's place look like it by the paper's own sum, faded ones move
// to others, new ones come up to the room there is, and nothing happens where nothing is left to join.
#include "support/cmocka_test.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "support/draws.h"
#include "train/renderers/splats/splats_structure.h"

enum { ROOM = 40, COLUMNS = VW_SPLAT_COLUMNS(1) };

// Computes equation 9 of Kheradmand et al. as it is printed, in long doubles.
static double paper_factor(double opacity, uint32_t count) {
    long double each = 1.0L - powl(1.0L - (long double)opacity, 1.0L / count), sum = 0.0L;
    for (uint32_t i = 1; i <= count; i++) {
        long double choose = 1.0L;
        for (uint32_t k = 0; k < i; k++) {
            sum += choose * (k % 2 ? -1.0L : 1.0L) * powl(each, k + 1) / sqrtl(k + 1);
            choose *= (long double)(i - 1 - k) / (k + 1);
        }
    }
    return (double)((long double)opacity / sum);
}

TEST(shares_are_those_of_the_paper) {
    static const double opacities[] = {0.006, 0.1, 0.5, 0.9, 0.99};
    for (size_t i = 0; i < VW_ARRAY_COUNT(opacities); i++)
        for (uint32_t count = 1; count <= 30; count++) {
            double each, factor;
            vw_splats_share(opacities[i], count, &each, &factor);
            assert_near(1.0 - pow(1.0 - each, count), opacities[i], 1e-12); // blended, they are as opaque
            assert_near(factor, paper_factor(opacities[i], count), 1e-9);
        }
}

struct splats {
    float params[4 * COLUMNS * ROOM], moments[4 * COLUMNS * ROOM];
    struct vw_splat_set set;
};

static float *number(float *numbers, uint32_t column, uint32_t splat, uint32_t lane) {
    return &numbers[4 * (column * ROOM + splat) + lane];
}

// Makes `born` splats of which every third has faded, or all but one, or all; the rest are yet to come.
static struct splats *make(uint32_t born, uint32_t alive_from, uint32_t alive_to) {
    struct splats *made = test_allocate(1, sizeof *made);
    for (uint32_t i = 0; i < 4 * COLUMNS * ROOM; i++) {
        made->params[i] = (float)sin(i * 0.7);
        made->moments[i] = 1.0f;
    }
    for (uint32_t i = 0; i < ROOM; i++) {
        bool alive = i >= alive_from && i < alive_to && i % 3 != 2;
        *number(made->params, SPLAT_MEAN, i, 3) = i >= born ? VW_SPLAT_UNBORN : alive ? 0.1f * (float)i : -6.0f;
    }
    made->set = (struct vw_splat_set){.params = made->params, .room = ROOM, .columns = COLUMNS, .seed = 5, .step = 7};
    made->set.moments[1] = made->moments;
    return made;
}

static double opacity(struct splats *of, uint32_t splat) {
    return 1.0 / (1.0 + exp(-*number(of->params, SPLAT_MEAN, splat, 3)));
}

// Returns the splat that another one is a copy of, by its harmonics, which stay.
static uint32_t origin_of(struct splats *before, struct splats *after, uint32_t splat, uint32_t born) {
    for (uint32_t i = 0; i < born; i++)
        if (!memcmp(number(before->params, SPLAT_HARMONICS, i, 0), number(after->params, SPLAT_HARMONICS, splat, 0),
                    16))
            return i;
    return ROOM;
}

TEST(faded_and_new_splats_join_others) {
    enum { BORN = 20, WANTED = 31 };
    struct splats *before = make(BORN, 0, BORN), *after = make(BORN, 0, BORN), *again = make(BORN, 0, BORN);
    assert_int_equal(vw_splats_count_born(&after->set), BORN);
    ASSERT_OK(vw_splats_restructure(&after->set, WANTED));
    ASSERT_OK(vw_splats_restructure(&again->set, WANTED));
    assert_memory_equal(after->params, again->params, sizeof after->params);
    assert_int_equal(vw_splats_count_born(&after->set), WANTED);
    uint32_t counts[ROOM] = {0}, joined = 0;
    for (uint32_t i = 0; i < WANTED; i++) {
        uint32_t origin = origin_of(before, after, i, BORN);
        assert_true(origin < BORN && opacity(before, origin) > 0.005);
        counts[origin]++;
        joined += origin != i;
    }
    assert_int_equal(joined, BORN / 3 + WANTED - BORN);
    for (uint32_t i = 0; i < WANTED; i++) {
        uint32_t origin = origin_of(before, after, i, BORN);
        double each, factor, distance2 = 0.0;
        vw_splats_share(fmin(opacity(before, origin), 0.99), counts[origin], &each, &factor);
        if (counts[origin] > 1) assert_near(opacity(after, i), each, 1e-6);
        for (uint32_t lane = 0; lane < 3; lane++) {
            double by = *number(after->params, SPLAT_MEAN, i, lane) - *number(before->params, SPLAT_MEAN, origin, lane);
            distance2 += by * by;
            assert_near(*number(after->params, SPLAT_SCALE, i, lane),
                        *number(before->params, SPLAT_SCALE, origin, lane) + log(factor), 1e-6);
        }
        assert_true((distance2 > 0.0) == (origin != i));
        assert_true(*number(after->moments, SPLAT_MEAN, i, 0) == (counts[origin] > 1 ? 0.0f : 1.0f));
    }
    for (uint32_t i = WANTED; i < ROOM; i++) assert_true(*number(after->params, SPLAT_MEAN, i, 3) == VW_SPLAT_UNBORN);
}

TEST(hard_cases_leave_splats_sound) {
    static const struct {
        uint32_t born, from, to, wanted, after;
    } cases[] = {{20, 20, 20, 30, 20},        // none is left to join
                 {20, 3, 4, 40, 40},          // all join one
                 {ROOM, 0, ROOM, ROOM, ROOM}, // no room is left
                 {ROOM, 0, ROOM, 10, ROOM},   // fewer are wanted than there are
                 {1, 0, 1, 40, 40},           {1, 9, 9, 40, 1}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct splats *splats = make(cases[i].born, cases[i].from, cases[i].to);
        ASSERT_OK(vw_splats_restructure(&splats->set, cases[i].wanted));
        assert_int_equal(vw_splats_count_born(&splats->set), cases[i].after);
        for (uint32_t n = 0; n < 4 * COLUMNS * ROOM; n++) assert_true(isfinite(splats->params[n]));
    }
}

TEST_GROUP(NULL, NULL)
