// Scores of places for a next photo: the greedy choice by a made-up score, each score against plain computations in
// double precision, and Fisher's diagonal against differences of rendered colours.
// label: device
#include "support/cmocka_test.h"

#include "base/random.h"
#include "run/next/fisher_diagonal.h"
#include "run/next/seen_surface.h"
#include "scene/view_distance.h"
#include "support/trainer_fixture.h"

// ---- The choice -----------------------------------------------------------------------------------------------------

// A made-up score: what a pick gives, half of it lost by each pick beside it. Candidates are 4, 7, 7 and 5.
static double worth[4];

static enum vw_status begin_worth(const struct vw_known_views *known, const struct vw_candidate *candidates,
                                  uint32_t count, void **state) {
    (void)known, (void)candidates;
    memcpy(worth, (double[]){4, 7, 7, 5}, sizeof worth);
    *state = worth;
    return count == 4 ? VW_OK : vw_fail(VW_ERROR_USAGE, "four candidates");
}
static double tell_worth(const void *state, uint32_t candidate) { return ((const double *)state)[candidate]; }
static void halve_neighbours(void *state, uint32_t candidate) {
    double *values = state;
    if (candidate > 0) values[candidate - 1] /= 2;
    if (candidate < 3) values[candidate + 1] /= 2;
}
static void end_worth(void **state) { *state = NULL; }

static const struct vw_candidate_score made_up = {
    .name = "made-up", .create = begin_worth, .gain = tell_worth, .add = halve_neighbours, .destroy = end_worth};

TEST(a_batch_is_picked_one_after_another) {
    uint32_t picks[4];
    double gains[4], first[4];
    ASSERT_OK(vw_next_candidates_pick(&made_up, NULL, NULL, 4, 4, picks, gains, first));
    assert_memory_equal(picks, ((uint32_t[]){1, 3, 0, 2}), sizeof picks); // the first of equal ones
    assert_memory_equal(gains, ((double[]){7, 5, 2, 1.75}), sizeof gains);
    assert_memory_equal(first, ((double[]){4, 7, 7, 5}), sizeof first);
    ASSERT_FAILS(vw_next_candidates_pick(&made_up, NULL, NULL, 3, 1, picks, gains, first), VW_ERROR_USAGE, "four");
}

static enum vw_status begin_with_nan(const struct vw_known_views *known, const struct vw_candidate *candidates,
                                     uint32_t count, void **state) {
    enum vw_status status = begin_worth(known, candidates, count, state);
    worth[0] = worth[2] = NAN;
    return status;
}

TEST(a_gain_that_is_no_number_is_picked_last) {
    struct vw_candidate_score score = made_up;
    uint32_t picks[4];
    double gains[4], first[4];
    score.create = begin_with_nan;
    ASSERT_OK(vw_next_candidates_pick(&score, NULL, NULL, 4, 4, picks, gains, first));
    assert_memory_equal(picks, ((uint32_t[]){1, 3, 0, 2}), sizeof picks);
}

TEST(a_score_is_found_by_its_name) {
    const struct vw_candidate_score *score = NULL;
    ASSERT_OK(vw_candidate_score_find("coverage", &score));
    assert_ptr_equal(score, &vw_score_coverage);
    ASSERT_OK(vw_candidate_score_find(NULL, &score));
    assert_non_null(score);
    ASSERT_FAILS(vw_candidate_score_find("nearest", &score), VW_ERROR_USAGE, "--method nearest", "farthest, coverage");
}

// ---- Scores by poses ------------------------------------------------------------------------------------------------

// The bench: views 0 and 1 are known, views 2, 3 and 4 and a copy of 0 are candidates. Views 5 and 6 validate.
struct bench {
    struct vw_scene *scene;
    struct vw_known_views known;
    struct vw_candidate candidates[4];
};
static const uint32_t known_views[] = {0, 1}, val_views[] = {5, 6};
static const double val_mse[] = {0.01, 0.04};

static struct bench make_bench(void) {
    struct bench bench = {.scene = test_scene()};
    bench.known = (struct vw_known_views){.scene = bench.scene,
                                          .views = known_views,
                                          .count = 2,
                                          .val_views = val_views,
                                          .val_mse = val_mse,
                                          .val_count = 2};
    ASSERT_OK(vw_view_scales_find(bench.scene, &bench.known.scales));
    for (uint32_t i = 0; i < 4; i++) bench.candidates[i].pose = bench.scene->views[i < 3 ? i + 2 : 0];
    return bench;
}

static double apart(const struct bench *bench, uint32_t view, uint32_t candidate) {
    return vw_view_apart(&bench->known.scales, &bench->scene->views[view], &bench->candidates[candidate].pose);
}

TEST(farthest_is_the_distance_to_the_nearest_view) {
    struct bench bench = make_bench();
    void *made = NULL;
    ASSERT_OK(vw_score_farthest.create(&bench.known, bench.candidates, 4, &made));
    for (uint32_t i = 0; i < 4; i++)
        assert_near(vw_score_farthest.gain(made, i), fmin(apart(&bench, 0, i), apart(&bench, 1, i)), 1e-12);
    assert_near(vw_score_farthest.gain(made, 3), 0, 1e-6); // an angle of nearly 0
    vw_score_farthest.add(made, 1);                        // view 3
    assert_near(vw_score_farthest.gain(made, 1), 0, 1e-6);
    assert_near(vw_score_farthest.gain(made, 0),
                fmin(fmin(apart(&bench, 0, 0), apart(&bench, 1, 0)), apart(&bench, 3, 0)), 1e-12);
    vw_score_farthest.destroy(&made);
}

TEST(nearest_error_is_error_times_nearness) {
    struct bench bench = make_bench();
    void *made = NULL;
    ASSERT_OK(vw_score_nearest_error.create(&bench.known, bench.candidates, 4, &made));
    double kernel[2][4];
    for (uint32_t v = 0; v < 2; v++)
        for (uint32_t i = 0; i < 4; i++) kernel[v][i] = exp(-pow(apart(&bench, val_views[v], i), 2) / 2);
    for (uint32_t i = 0; i < 4; i++)
        assert_near(vw_score_nearest_error.gain(made, i), 0.01 * kernel[0][i] + 0.04 * kernel[1][i], 1e-15);
    vw_score_nearest_error.add(made, 2);
    for (uint32_t i = 0; i < 4; i++)
        assert_near(vw_score_nearest_error.gain(made, i),
                    0.01 * (1 - kernel[0][2]) * kernel[0][i] + 0.04 * (1 - kernel[1][2]) * kernel[1][i], 1e-15);
    vw_score_nearest_error.destroy(&made);
}

TEST(farthest_error_weighs_by_the_error_there) {
    struct bench bench = make_bench();
    void *made = NULL;
    ASSERT_OK(vw_score_farthest_error.create(&bench.known, bench.candidates, 4, &made));
    for (uint32_t i = 0; i < 4; i++) {
        double near[2];
        for (uint32_t v = 0; v < 2; v++) near[v] = 1 / (pow(apart(&bench, val_views[v], i), 2) + 0.25);
        double error = sqrt((0.01 * near[0] + 0.04 * near[1]) / (near[0] + near[1]));
        assert_near(vw_score_farthest_error.gain(made, i), error * fmin(apart(&bench, 0, i), apart(&bench, 1, i)),
                    1e-12);
    }
    vw_score_farthest_error.add(made, 1);
    assert_near(vw_score_farthest_error.gain(made, 1), 0, 1e-6);
    vw_score_farthest_error.destroy(&made);
}

TEST(spread_shortens_the_mean_distance) {
    struct bench bench = make_bench();
    void *made = NULL;
    ASSERT_OK(vw_score_spread.create(&bench.known, bench.candidates, 4, &made));
    for (uint32_t pick = 0; pick < 4; pick++) {
        double before = 0, after = 0;
        for (uint32_t i = 0; i < 4; i++) {
            double least = fmin(apart(&bench, 0, i), apart(&bench, 1, i));
            before += least / 4;
            after += fmin(least,
                          vw_view_apart(&bench.known.scales, &bench.candidates[pick].pose, &bench.candidates[i].pose)) /
                     4;
        }
        assert_near(vw_score_spread.gain(made, pick), before - after, 1e-12);
    }
    vw_score_spread.add(made, 1);
    assert_near(vw_score_spread.gain(made, 1), 0, 1e-6);
    vw_score_spread.destroy(&made);
}

// ---- Scores by the field --------------------------------------------------------------------------------------------

static void train(struct bench *bench, const struct vw_config *config) {
    bench->known.trainer = test_trainer_create(bench->scene, config, true, 0);
    test_run_of(bench->known.trainer);
}

TEST(cells_grow_beyond_the_box) { // a cell is half a unit wide
    const struct vw_box box = {.centre_world = {1, 2, 3}, .half_extent_world = 2};
    const double along_x[3] = {2, 1, -1}, along_y[3] = {0, -3, 1}, beside[3] = {2, 1, 1};
    uint32_t inside = vw_seen_surface_cell(&box, (double[]){1.1, 2.1, 3.1}, along_x);
    assert_int_equal(vw_seen_surface_cell(&box, (double[]){1.4, 2.4, 3.4}, along_x), inside);
    assert_int_not_equal(vw_seen_surface_cell(&box, (double[]){1.6, 2.1, 3.1}, along_x), inside);
    assert_int_not_equal(vw_seen_surface_cell(&box, (double[]){1.1, 2.1, 3.1}, along_y), inside);
    assert_int_not_equal(vw_seen_surface_cell(&box, (double[]){1.1, 2.1, 3.1}, beside), inside);
    uint32_t far = vw_seen_surface_cell(&box, (double[]){81, 2.1, 3.1}, along_x); // 40 half extents: 1.975 of 2
    assert_int_equal(vw_seen_surface_cell(&box, (double[]){31, 2.1, 3.1}, along_x), far);
    assert_int_not_equal(vw_seen_surface_cell(&box, (double[]){4.1, 2.1, 3.1}, along_x), far);
}

TEST(a_photo_counts_each_cell_once) {
    struct vw_seen_surface surface = {.counts = test_allocate(48, 4), .last = test_allocate(48, 4)};
    const struct vw_seen_cells seen = {(uint32_t[]){3, VW_SEEN_NOTHING, 3, 5}, 4};
    vw_seen_surface_add(&surface, &seen);
    assert_memory_equal(surface.counts, ((uint32_t[]){0, 0, 0, 1, 0, 1, 0, 0}), 32);
    vw_seen_surface_add(&surface, &seen);
    assert_memory_equal(surface.counts, ((uint32_t[]){0, 0, 0, 2, 0, 2, 0, 0}), 32);
    assert_int_equal(vw_seen_surface_photos(&surface, 20), 2); // the same place, from another direction
    assert_int_equal(vw_seen_surface_photos(&surface, 24), 0);
}

TEST(coverage_prefers_what_no_photo_sees) {
    struct bench bench = make_bench();
    const struct vw_config config = test_config();
    void *made = NULL;
    train(&bench, &config);
    ASSERT_OK(vw_score_coverage.create(&bench.known, bench.candidates, 4, &made));
    double copy = vw_score_coverage.gain(made, 3), other_side = vw_score_coverage.gain(made, 1);
    assert_true(copy > 0 && copy <= 0.5); // all that it sees is seen by a photo
    assert_true(other_side > 1.2 * copy && other_side <= 1);
    vw_score_coverage.add(made, 1);
    assert_true(vw_score_coverage.gain(made, 1) <= 0.5);
    assert_true(vw_score_coverage.gain(made, 3) <= copy);
    vw_score_coverage.destroy(&made);
}

// ---- Fisher ---------------------------------------------------------------------------------------------------------

enum { CHECKED = 24, DRAWS = 3 };

// Lists the params of largest diagonal.
static void list_largest(const float *diagonal, uint64_t count, uint64_t places[CHECKED]) {
    for (uint32_t k = 0; k < CHECKED; k++) {
        places[k] = UINT64_MAX;
        for (uint64_t j = 0; j < count; j++) {
            bool taken = false;
            for (uint32_t i = 0; i < k; i++) taken |= places[i] == j;
            if (!taken && (places[k] == UINT64_MAX || diagonal[j] > diagonal[places[k]])) places[k] = j;
        }
    }
}

// Renders the rays of the pose that was measured last, with a param moved.
static vw_float4 *render_moved(struct vw_fisher *fisher, float *params, uint64_t place, float by) {
    vw_float4 *colours = test_allocate(fisher->ray_count, sizeof *colours);
    float kept = params[place];
    params[place] += by;
    ASSERT_OK(vw_buffer_write(fisher->field->params, 0, params, 4 * fisher->param_count));
    ASSERT_OK(vw_evaluator_run(&fisher->evaluator));
    ASSERT_OK(vw_buffer_read(fisher->evaluator.colours, 0, colours, fisher->ray_count * sizeof *colours));
    params[place] = kept;
    return colours;
}

// Returns the mean of the squared sums of slopes with the draws' signs, by differences, and the sum of squares.
static double by_differences(struct vw_fisher *fisher, float *params, uint64_t place, double *squares) {
    const float step = 2e-3f;
    vw_float4 *ahead = render_moved(fisher, params, place, step), *back = render_moved(fisher, params, place, -step);
    double sums[DRAWS] = {0}, mean = 0;
    *squares = 0;
    for (uint32_t ray = 0; ray < fisher->ray_count && fisher->rays[ray].target_weight.w != 0; ray++)
        for (uint32_t c = 0; c < 3; c++) {
            const float *a = (const float *)&ahead[ray] + c, *b = (const float *)&back[ray] + c;
            double slope = ((double)*a - *b) / (2.0 * step);
            *squares += slope * slope;
            for (uint32_t draw = 0; draw < DRAWS; draw++) {
                uint32_t words[4];
                vw_random_words(0, VW_RANDOM_SIGN, draw, ray, 0, words);
                sums[draw] += words[c] & 1 ? slope : -slope;
            }
        }
    for (uint32_t draw = 0; draw < DRAWS; draw++) mean += sums[draw] * sums[draw] / DRAWS;
    return mean;
}

static void destroy_fisher(void *fisher) { vw_fisher_destroy(fisher); }

TEST(the_diagonal_is_that_of_rendered_colours) {
    struct bench bench = make_bench();
    const struct vw_config config = test_config();
    static struct vw_fisher fisher;
    uint64_t places[CHECKED];
    double squares = 0, many_draws = 0, apart = 0;
    train(&bench, &config);
    ASSERT_OK(vw_fisher_create(&bench.known, DRAWS, &fisher));
    test_own(&fisher, destroy_fisher);
    float *diagonal = test_allocate(fisher.param_count, 4), *many = test_allocate(fisher.param_count, 4),
          *params = test_allocate(fisher.param_count, 4);
    ASSERT_OK(vw_buffer_read(fisher.field->params, 0, params, 4 * fisher.param_count));
    ASSERT_OK(vw_fisher_add(&fisher, &bench.candidates[1].pose, diagonal));
    fisher.draws = 64;
    ASSERT_OK(vw_fisher_add(&fisher, &bench.candidates[1].pose, many));
    list_largest(many, fisher.param_count, places);
    for (uint32_t k = 0; k < CHECKED; k++) {
        double square, mean = by_differences(&fisher, params, places[k], &square);
        apart += pow(sqrt(diagonal[places[k]]) - sqrt(mean), 2);
        squares += square;
        many_draws += many[places[k]];
    }
    assert_near(sqrt(apart / squares), 0, 0.01); // seen: 0.0012
    assert_near(many_draws, squares, 0.25 * squares);
}

TEST(the_diagonal_is_finite_in_an_unbounded_box) { // where padding must not be rays of no length
    struct bench bench = make_bench();
    const struct vw_config config = test_config_with("unbounded");
    static struct vw_fisher fisher;
    double sum = 0;
    train(&bench, &config);
    ASSERT_OK(vw_fisher_create(&bench.known, 1, &fisher));
    test_own(&fisher, destroy_fisher);
    float *diagonal = test_allocate(fisher.param_count, 4);
    ASSERT_OK(vw_fisher_add(&fisher, &bench.candidates[1].pose, diagonal));
    for (uint64_t j = 0; j < fisher.param_count; j++) sum += diagonal[j];
    assert_true(isfinite(sum) && sum > 0);
}

TEST(fisher_prefers_what_no_photo_tells) {
    struct bench bench = make_bench();
    const struct vw_config config = test_config();
    void *made = NULL;
    train(&bench, &config);
    ASSERT_OK(vw_score_fisher.create(&bench.known, bench.candidates, 4, &made));
    assert_true(vw_score_fisher.gain(made, 1) > vw_score_fisher.gain(made, 3));
    double before = vw_score_fisher.gain(made, 1);
    vw_score_fisher.add(made, 1);
    assert_true(vw_score_fisher.gain(made, 1) < before);
    vw_score_fisher.destroy(&made);
}

TEST(fisher_refuses_splats_and_renders_do_not) {
    struct bench bench = make_bench();
    const struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    void *made = NULL;
    bench.known.trainer = test_trainer_create(bench.scene, &config, true, 0);
    ASSERT_FAILS(vw_score_fisher.create(&bench.known, bench.candidates, 4, &made), VW_ERROR_USAGE, "splats");
    vw_score_fisher.destroy(&made);
    ASSERT_OK(vw_score_coverage.create(&bench.known, bench.candidates, 4, &made));
    vw_score_coverage.destroy(&made);
}

TEST_GROUP(NULL, test_gpu_close)
