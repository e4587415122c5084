// Samples placed by importance: where hand-made densities of the even samples put them, held against the reference, and
// whole steps and renderings with them, held against the reference at the places that the device listed.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"
#include "train/fields/mlp.h"

// A share of the whole weight is a sum of floats near 1; a stratum's own weight magnifies what that is off by.
static const double SHARE_TOLERANCE = 6e-6;
static const double PLACE_TOLERANCE = 4e-6;         // strata, up to 40 of them
static const uint64_t STEP = UINT64_C(0x300000005); // needs both words

// 7 even and 20 importance samples: neither fill a workgroup.
static const struct step_case setup = {.name = "importance",
                                       .seed = 321,
                                       .rays = 70,
                                       .samples = 7,
                                       .importance_samples = 20,
                                       .levels = 4,
                                       .log2_table = 8,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .weight_scale = 3.0f};

// Optical thickness of stratum i of a ray.
typedef double thickness(uint32_t ray, uint32_t i);

static double nothing(uint32_t ray, uint32_t i) { return 0.0 * (ray + i); }
static double one_spike(uint32_t ray, uint32_t i) { return i == ray % 7 ? 0.5 : 0.0; }
static double opaque_at_once(uint32_t ray, uint32_t i) { return i == 0 ? 200.0 + ray : 1.0; }
static double fog(uint32_t ray, uint32_t i) { return 0.01 * (1 + (3 * ray + 5 * i) % 11); }
static double beyond_exp(uint32_t ray, uint32_t i) { return i == ray % 7 ? 1e30 : 1e-12; }
static double unknown(uint32_t ray, uint32_t i) { return i == ray % 7 ? NAN : 1.0; }

static struct vw_ray *make_rays(const struct step_bench *bench, uint32_t count) {
    struct vw_ray *rays = test_allocate(count, sizeof *rays);
    for (uint32_t ray = 0; ray < count; ray++) {
        rays[ray].direction_stride = (vw_float4){1.0f, 0.0f, 0.0f, exp2f(-(float)(ray % 8))};
        rays[ray].target_weight.w = 1.0f;
        if (!bench->model.specialization.effect_unbounded) continue;
        rays[ray].origin_near.w = 0.1f + 0.2f * (float)(ray % 3);
        rays[ray].direction_stride.w = rays[ray].origin_near.w * exp2f(1.0f + (float)(ray % 20));
    }
    return rays;
}

// Checks one ray's places against the reference, each as near as its stratum's weight allows, all in order and on the
// ray.
static void check_ray(struct hard_finding *finding, const struct vw_specialization *s, uint32_t ray, const double *taus,
                      vw_uint4 key, const float *device) {
    double places[20], weights[7], before = 0.0;
    reference_place_samples(s, ray, taus, key, weights, places);
    for (uint32_t i = 0; i < s->samples; i++) {
        uint32_t stratum = (uint32_t)fmin(places[i], s->strata - 1.0);
        // At a border between strata the place may be a little off in the next one, whose weight may be the least.
        double near_border = fmin(places[i] - stratum, stratum + 1.0 - places[i]),
               least = near_border * weights[stratum] < SHARE_TOLERANCE ? 1e-5 : weights[stratum];
        if (!isfinite(taus[0] + taus[ray % 7])) least = 1.0;
        hard_compare(finding, "place", ray * s->samples + i, device[i], places[i], 1.0,
                     fmin(SHARE_TOLERANCE / least, 1.0) + PLACE_TOLERANCE);
        hard_require(finding, device[i] >= before && device[i] <= s->strata, "places ascend along the ray");
        before = device[i];
    }
}

static void check_placing(struct hard_finding *finding, struct step_bench *bench, thickness *medium, bool training) {
    struct vw_specialization s = bench->model.specialization;
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    struct vw_push_samples push = step_bench_push(bench, STEP);
    struct vw_buffer *places = training ? bench->volume->places : vw_volume_evaluation_of(evaluator)->places;
    struct vw_ray *rays = make_rays(bench, push.ray_count);
    s.training = training;
    assert_int_equal(s.samples, 20);
    vw_float4 *field = test_allocate((size_t)push.ray_count * s.samples, sizeof *field);
    double *taus = test_allocate((size_t)push.ray_count * s.strata, sizeof *taus);
    for (uint32_t i = 0; i < push.ray_count * s.strata; i++) {
        struct reference_ray ray = reference_ray_of(&rays[i / s.strata]);
        double length = reference_stratum_length(&s, &ray, i % s.strata);
        field[i].w = (float)(medium(i / s.strata, i % s.strata) / length);
        taus[i] = field[i].w * length;
    }
    test_write(training ? bench->step.ray_buffer : evaluator->rays, rays);
    test_write(training ? bench->volume->samples : vw_volume_evaluation_of(evaluator)->samples, field);
    step_bench_dispatch(bench,
                        training ? bench->volume->gradient.importance.place
                                 : vw_volume_evaluation_of(evaluator)->importance.place,
                        &push, sizeof push, step_bench_lanes(bench, push.ray_count));
    float *device = test_read(places);
    for (uint32_t ray = 0; ray < push.ray_count; ray++)
        check_ray(finding, &s, ray, &taus[ray * s.strata], push.key, &device[ray * s.samples]);
}

// Shares rays among no lanes, a few, and more than there are strata and samples.
static void place(struct hard_finding *finding, thickness *medium) {
    static const uint32_t lanes[] = {1, 1, 2, 4, 32};
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(lanes); i++) {
        struct step_case bounds = setup;
        bounds.effects = i % 2 ? "unbounded" : NULL;
        bounds.ray_lanes = lanes[i];
        struct step_bench *bench = step_bench_open(&bounds);
        check_placing(finding, bench, medium, true);
        check_placing(finding, bench, medium, false);
        test_release(bench);
    }
}

static void no_matter(struct hard_finding *finding) {
    place(finding, nothing);
    struct step_bench *bench = step_bench_open(&setup);
    check_placing(finding, bench, nothing, false);
    float *device = test_read(vw_volume_evaluation_of(step_bench_evaluator(bench))->places);
    for (uint32_t i = 0; i < 20; i++) // the quantiles of the whole ray
        hard_compare(finding, "even place", i, device[i], (i + 0.5) / 20.0 * 7.0, 7.0, PLACE_TOLERANCE);
}
static void spike(struct hard_finding *finding) { place(finding, one_spike); }
static void opaque(struct hard_finding *finding) { place(finding, opaque_at_once); }
static void thin(struct hard_finding *finding) { place(finding, fog); }
static void overflow(struct hard_finding *finding) { place(finding, beyond_exp); }
static void nonfinite(struct hard_finding *finding) { place(finding, unknown); }

// Rays, samples and gradients of whole steps, and the same in several chunks, which changes no bit.
static void whole_steps(struct hard_finding *finding) {
    for (int unbounded = 0; unbounded < 2; unbounded++) {
        struct step_case whole = setup;
        whole.samples = unbounded ? 8 : 40; // groups of rays are smaller than a step; fewer and more than the others
        whole.importance_samples = 20;
        whole.effects = unbounded ? "unbounded" : NULL;
        whole.ray_lanes = unbounded ? 1 : 16;
        struct step_bench *bench = step_bench_open(&whole);
        hard_check_rendering(finding, bench);
        hard_check_step(finding, bench, STEP);
        step_bench_check_chunks(&whole, bench->model.ray_group * bench->layout->ray_samples, STEP);
        test_release(bench);
    }
}

static const struct step_case coarse_setup = {.name = "coarse network",
                                              .seed = 322,
                                              .rays = 70,
                                              .field = VW_FIELD_MLP,
                                              .mlp_depth = 2,
                                              .width = 16,
                                              .frequencies = 3,
                                              .samples = 7,
                                              .importance_samples = 20,
                                              .own_coarse = true,
                                              .loss = VW_LOSS_L2};

// Sets all params of the coarse network to 0, and then the bias of its raw density: the same density everywhere.
static void make_coarse_network(struct step_bench *bench, float bias) {
    struct vw_mlp_list list;
    vw_mlp_list(&bench->model, false, bench->layout->coarse_column, &list);
    memset((char *)bench->params + bench->layout->coarse.offset_bytes, 0, bench->layout->coarse.size_bytes);
    for (uint32_t i = 0; i < list.count; i++)
        if (list.matrices[i].out == 1) bench->params[4 * (size_t)list.matrices[i].first_bias] = bias;
    step_bench_write_params(bench);
}

static void check_places(struct hard_finding *finding, struct step_bench *bench, double density) {
    const struct vw_specialization *s = &bench->model.specialization;
    const struct vw_push_samples push = step_bench_push(bench, STEP);
    struct vw_ray *rays = test_read(bench->step.ray_buffer);
    float *places = test_read(bench->volume->places);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        const struct reference_ray line = reference_ray_of(&rays[ray]);
        double taus[7];
        for (uint32_t i = 0; i < 7; i++) taus[i] = density * reference_stratum_length(s, &line, i);
        check_ray(finding, s, ray, taus, push.key, &places[ray * s->samples]);
    }
}

static void coarse_network_of(struct hard_finding *finding, float bias, bool learns) {
    struct step_bench *bench = step_bench_open(&coarse_setup);
    const struct vw_param_range *field = &bench->model.weights, *coarse = &bench->layout->coarse;
    make_coarse_network(bench, bias);
    step_bench_step(bench, STEP);
    check_places(finding, bench, exp(bias));
    vw_float4 *scalars = test_read(bench->scalars);
    char *after = test_read(bench->field.params), *before = (char *)bench->params;
    hard_require(finding, scalars->z == 0.0f && scalars->x > 0.0f, "the step is sound");
    for (size_t i = 0; i < bench->model.param_bytes / sizeof(float); i++)
        hard_require(finding, isfinite(((const float *)after)[i]), "params are finite");
    bool learned = memcmp(after + coarse->offset_bytes, before + coarse->offset_bytes, coarse->size_bytes) != 0;
    hard_require(finding, learned == learns, "the coarse network learns where it has matter");
    hard_require(finding, memcmp(after, before, field->size_bytes) != 0, "the field learns");
}

static void coarse_zeros(struct hard_finding *finding) { coarse_network_of(finding, 0.0f, true); }
static void coarse_without_matter(struct hard_finding *finding) { coarse_network_of(finding, -1e4f, false); }

// Checks that a bench without importance samples has neither buffers nor passes for them.
static void off(struct hard_finding *finding) {
    struct step_case plain = setup;
    plain.importance_samples = 0;
    struct step_bench *bench = step_bench_open(&plain);
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    hard_require(finding, !bench->volume->places && !bench->volume->gradient.importance.place,
                 "a step has nothing of it");
    hard_require(finding,
                 !vw_volume_evaluation_of(evaluator)->places && !vw_volume_evaluation_of(evaluator)->importance.place,
                 "an evaluator has nothing of it");
    for (int i = 0; i < FIELD_PASSES_MAX; i++)
        hard_require(finding, !bench->volume->gradient.importance.even.passes[i], "no pass renders even samples");
    hard_equal(finding, "samples", 0, bench->model.specialization.samples, bench->model.specialization.strata);
}

static const struct hard_case cases[] = {
    {"no matter on a ray", "0/0 in the inverse of the distribution", no_matter},
    {"one stratum holds all matter", "drawn samples beside it", spike},
    {"opaque first stratum", "weights after it that are not 0", opaque},
    {"fog", "places that leave their stratum", thin},
    {"densities beyond exp", "weights that overflow", overflow},
    {"densities that are not numbers", "places that are not, and hide it", nonfinite},
    {"whole steps", "positions, lengths or chunks of other places", whole_steps},
    {"coarse network of zeros", "gradients that stay 0 or are not finite", coarse_zeros},
    {"coarse network without matter", "0/0 in weights and moments, a field that stands still", coarse_without_matter},
    {"no importance samples", "buffers or passes that are not needed", off},
};

HARD_CASES("importance", cases)
