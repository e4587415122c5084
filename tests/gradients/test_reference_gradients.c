// The reference's analytic gradient against central differences of the reference's own loss, for parameters of every
// matrix and every level. No GPU.
//
// Kinks: a difference across a changed decision (a ReLU switching, the density reaching its maximum, an L1 error
// changing sign) is not a derivative. Such a parameter is skipped; at most one in ten may be.
#include "support/cmocka_test.h"
#include "support/plain_config.h"

#include "base/memory.h"
#include "base/random.h"
#include "detect/decide.h"
#include "reference/reference.h"
#include "train/effects/ray_network.h"
#include "train/field.h"

static const double STEP = 1e-5;
// Share of the largest gradient of the range: the difference's own error is STEP^2 times third derivatives, and 1e-16 /
// STEP of the loss.
static const double TOLERANCE = 1e-6;
enum { RAYS = 6, PER_RANGE = 12 };

// Each of these fields is taken with every loss, without effects, with each effect alone and with all of them.
static const struct reference_case {
    const char *name;
    uint64_t seed;
    uint32_t samples, levels, features, log2_table, width;
    double weight_scale;
} cases[] = {
    {"default field", 1, 16, 8, 2, 14, 32, 1.0},
    {"four features", 2, 7, 2, 4, 8, 16, 1.5},
    {"wide network, one entry", 3, 9, 16, 2, 0, 64, 1.0},
    {"saturated densities", 4, 12, 4, 2, 10, 32, 4.0},
};
static const enum vw_loss all_losses[] = {VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER};

struct fixture {
    char where[192]; // case, seed, loss and effects, for messages
    struct vw_model model;
    struct reference_params *params;
    struct reference_step *step, *moved;
};

static double draw(uint64_t seed, uint32_t index) {
    uint32_t words[4];
    vw_random_words(seed, VW_RANDOM_INITIALISATION, 2, index, 0, words);
    return 2.0 * vw_random_unit(words[0]) - 1.0;
}

enum { VIEW = 1 }; // the photo whose step it is
static struct vw_view empty_views[2];
static const struct vw_scene empty_scene = {
    .background = {0.9f, 0.4f, 0.1f}, .views = empty_views, .view_count = VW_ARRAY_COUNT(empty_views)};

static void make_model(const struct reference_case *setup, enum vw_loss loss, const char *choice,
                       struct vw_model *model) {
    struct vw_config config = plain_config();
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    struct vw_gpu_limits limits = vw_gpu_floor_limits;
    uint32_t count;
    limits.shared_memory_bytes = 1 << 16;
    config.seed = setup->seed;
    config.samples = setup->samples;
    config.levels = setup->levels;
    config.features = setup->features;
    config.log2_table = setup->log2_table;
    config.width = setup->width;
    config.loss = loss;
    if (loss == VW_LOSS_HUBER) config.background = VW_BACKGROUND_RANDOM; // the other form under the other losses
    assert_int_equal(vw_config_check(&config), VW_OK);
    assert_int_equal(vw_effects_find_facts(&empty_scene, choice, effects, &count), VW_OK);
    struct vw_device_choices choices;
    vw_device_choose(&(struct vw_gpu_info){.kind = VW_GPU_CPU}, &choices);
    assert_int_equal(vw_model_create(&config, &empty_scene, NULL, 0, effects, &choices, &limits, model), VW_OK);
}

static void make_rays(uint64_t seed, const struct vw_specialization *s, struct vw_ray rays[RAYS]) {
    for (uint32_t i = 0; i < RAYS; i++) {
        double direction[3], length = 0.0;
        for (uint32_t k = 0; k < 3; k++) direction[k] = draw(seed, 100 + 3 * i + k);
        for (int k = 0; k < 3; k++) length += direction[k] * direction[k];
        for (int k = 0; k < 3; k++) direction[k] /= sqrt(length);
        rays[i] = (struct vw_ray){
            .origin_near = {(float)(0.5 - 0.4 * direction[0]), (float)(0.5 - 0.4 * direction[1]),
                            (float)(0.5 - 0.4 * direction[2]), 0.05f},
            .direction_stride = {(float)direction[0], (float)direction[1], (float)direction[2],
                                 s->effect_unbounded
                                     ? 3.0f
                                     : 0.8f / (float)s->samples}, // the far distance; the length of a stratum
            .target_weight = {(float)fabs(draw(seed, 50 + i)), (float)fabs(draw(seed, 60 + i)),
                              (float)fabs(draw(seed, 70 + i)), i == 4 ? 0.0f : 1.0f},
        };
    }
}

static void draw_codes(uint64_t seed, struct reference_params *params, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < REFERENCE_CODE; k++)
            params->photos[i].code[k] = draw(seed, 3000 + REFERENCE_CODE * i + k);
}

static void open_fixture(const struct reference_case *setup, enum vw_loss loss, const char *choice, struct fixture *f) {
    struct vw_ray rays[RAYS];
    snprintf(f->where, sizeof f->where, "case \"%s\", seed %llu, loss %s, effects %s", setup->name,
             (unsigned long long)setup->seed, vw_loss_name(loss), choice);
    make_model(setup, loss, choice, &f->model);
    make_rays(setup->seed, &f->model.specialization, rays);
    float *params = test_allocate(f->model.param_bytes, 1);
    assert_int_equal(vw_model_initialise(&f->model, NULL, setup->seed, params), VW_OK);
    size_t grid = f->model.grid.size_bytes / sizeof *params;
    for (size_t i = 0; i < grid; i++) params[i] *= 5000.0f; // from 1e-4 to 1/2
    size_t sky = f->model.ranges[VW_SLOT_SKY].offset_bytes / sizeof *params,
           sky_end = sky + f->model.ranges[VW_SLOT_SKY].size_bytes / sizeof *params;
    for (size_t i = grid; i < sky; i++) params[i] *= (float)setup->weight_scale;
    for (size_t i = sky; i < sky_end; i++) params[i] = (float)draw(setup->seed, 200 + (uint32_t)(i - sky));
    f->params = reference_params_create(&f->model, params);
    draw_codes(setup->seed, f->params, reference_photo_count(&f->model));
    f->step = reference_step_create(&f->model, rays, RAYS);
    f->moved = reference_step_create(&f->model, rays, RAYS);
    f->step->view = f->moved->view = VIEW;
    for (uint32_t i = 0; i < 2 * RAYS; i++)
        f->step->places[i / 2][i % 2] = f->moved->places[i / 2][i % 2] = draw(setup->seed, 4000 + i);
    for (uint32_t i = 0; i < RAYS * REFERENCE_FEATURES; i++) {
        uint32_t ray = i / REFERENCE_FEATURES, k = i % REFERENCE_FEATURES;
        double number = k + 1 < REFERENCE_FEATURES ? draw(setup->seed, 5000 + i) : 1.0;
        f->step->features[ray][k] = f->moved->features[ray][k] = number;
    }
    reference_step_forward(f->step, f->params, true, 1);
    reference_step_backward(f->step, f->params);
}

static bool same_decisions(const struct reference_step *a, const struct reference_step *b) {
    for (size_t i = 0; i < (size_t)RAYS * a->model->specialization.samples; i++) {
        size_t width = 4 * a->model->specialization.width4;
        if (memcmp(a->samples[i].active1, b->samples[i].active1, width) ||
            memcmp(a->samples[i].active2, b->samples[i].active2, width))
            return false;
        if (a->samples[i].saturated != b->samples[i].saturated) return false;
    }
    for (int ray = 0; ray < RAYS; ray++)
        for (int c = 0; c < 3; c++)
            if (signbit(a->errors[ray][c]) != signbit(b->errors[ray][c]) ||
                (fabs(a->errors[ray][c]) < 0.1) != (fabs(b->errors[ray][c]) < 0.1))
                return false;
    return true;
}

// Returns the slope of the loss by `*param`, or NaN at a kink.
static double central_difference(struct fixture *f, double *param) {
    double kept = *param, losses[2];
    bool smooth = true;
    for (int side = 0; side < 2; side++) {
        *param = kept + (side ? STEP : -STEP);
        reference_step_forward(f->moved, f->params, true, 1);
        losses[side] = f->moved->loss;
        smooth &= same_decisions(f->step, f->moved);
    }
    *param = kept;
    return smooth ? (losses[1] - losses[0]) / (2.0 * STEP) : NAN;
}

static void compare(struct fixture *f, const char *range, uint64_t index, double *param, double analytic, double scale,
                    int *skipped) {
    double slope = central_difference(f, param);
    *skipped += isnan(slope);
    if (!isnan(slope) && !(fabs(slope - analytic) <= TOLERANCE * scale))
        fail_msg("%s: %s[%llu]: analytic %.10g, difference %.10g", f->where, range, (unsigned long long)index, analytic,
                 slope);
}

static double largest_of(const double *values, size_t count) {
    double most = 0.0;
    for (size_t i = 0; i < count; i++) most = fmax(most, fabs(values[i]));
    return most;
}

static uint32_t index_in(uint32_t count, uint64_t seed, uint32_t draw_index) {
    return (uint32_t)(fabs(draw(seed, draw_index)) * count);
}

static void compare_weights(struct fixture *f, int *skipped) {
    const struct vw_specialization *s = &f->model.specialization;
    struct reference_matrix values[REFERENCE_MATRICES], gradients[REFERENCE_MATRICES];
    reference_matrices(s, &f->params->weights, values);
    reference_matrices(s, &f->step->d_weights, gradients);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
        uint32_t count = values[m].out * values[m].in;
        double scale = largest_of(gradients[m].values, count);
        assert_true(scale > 0.0);
        for (uint32_t k = 0; k < PER_RANGE; k++) {
            // The first PER_RANGE / 2 in output 0 (of the second matrix: the density), the others anywhere.
            uint32_t index =
                index_in(k < PER_RANGE / 2 ? values[m].in : count, (uint32_t)f->model.seed, 1000 + 100 * m + k);
            compare(f, values[m].name, index, &values[m].values[index], gradients[m].values[index], scale, skipped);
        }
    }
}

static void compare_grid(struct fixture *f, int *skipped) {
    const struct vw_specialization *s = &f->model.specialization;
    double scale = largest_of(f->step->d_grid, 2 * (size_t)f->model.pair_count);
    for (uint32_t level = 0; level < s->levels; level++) {
        for (uint32_t k = 0; k < PER_RANGE; k++) { // entries that some sample touches
            const struct reference_sample *sample = &f->step->samples[(k * 31 + level) % (RAYS * s->samples)];
            struct reference_corner corners[8];
            reference_grid_corners(s, sample->position, level, corners);
            uint64_t index = corners[k % 8].first_feature + k % (2 * s->feature_pairs);
            compare(f, "grid", index, &f->params->grid[index], f->step->d_grid[index], scale, skipped);
        }
    }
}

static void compare_sky(struct fixture *f, int *skipped) {
    if (!f->model.specialization.effect_sky) return;
    double scale = largest_of(f->step->d_sky[0], 3 * VW_SKY_COLUMNS);
    assert_true(scale > 0.0);
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS; i++)
        compare(f, "sky", i, &f->params->sky[i / 3][i % 3], f->step->d_sky[i / 3][i % 3], scale, skipped);
}

static void compare_visibility(struct fixture *f, int *skipped) {
    if (!f->params->visibility_codes) return;
    double scale = largest_of(f->step->d_visibility, REFERENCE_VISIBILITY), *code = f->params->visibility_codes[VIEW];
    assert_true(scale > 0.0);
    for (uint32_t i = 0; i < REFERENCE_VISIBILITY; i += 7) // every part of the network
        compare(f, "visibility", i, &f->params->visibility[i], f->step->d_visibility[i], scale, skipped);
    for (uint32_t i = 0; i < REFERENCE_VISIBILITY_CODE; i++)
        compare(f, "visibility_codes", i, &code[i], f->step->d_visibility_code[i],
                largest_of(f->step->d_visibility_code, REFERENCE_VISIBILITY_CODE), skipped);
}

static void compare_uncertainty(struct fixture *f, int *skipped) {
    if (!f->params->uncertainty) return;
    double scale = largest_of(f->step->d_uncertainty, REFERENCE_UNCERTAINTY);
    assert_true(scale > 0.0);
    for (uint32_t i = 0; i < REFERENCE_UNCERTAINTY; i += 7)
        compare(f, "uncertainty", i, &f->params->uncertainty[i], f->step->d_uncertainty[i], scale, skipped);
}

// Compares the gradients by the code of the step's photo: those of the other one are 0, since nothing of it enters the
// loss. Returns how many it compared.
static int compare_codes(struct fixture *f, int *skipped) {
    const struct vw_specialization *s = &f->model.specialization;
    struct reference_photo *photo = f->params->photos ? &f->params->photos[VIEW] : NULL;
    double scale = largest_of(f->step->d_code, REFERENCE_CODE);
    assert_true(!s->effect_appearance_code || scale > 0.0);
    for (uint32_t k = 0; k < PER_RANGE && s->effect_appearance_code; k++) {
        uint32_t weight = index_in(4 * s->width4 * REFERENCE_CODE, (uint32_t)f->model.seed, 1800 + k),
                 number = 4 * k + k % 4;
        compare(f, "code_weights", weight, &f->params->code_weights[weight], f->step->d_code_weights[weight],
                largest_of(f->step->d_code_weights, 4 * s->width4 * REFERENCE_CODE), skipped);
        compare(f, "codes", number, &photo->code[number], f->step->d_code[number], scale, skipped);
    }
    return s->effect_appearance_code ? 2 * PER_RANGE : 0;
}

static void compare_ranges(const struct reference_case *setup, enum vw_loss loss, const char *choice) {
    struct fixture f;
    int skipped = 0;
    open_fixture(setup, loss, choice, &f);
    const struct vw_model *m = &f.model;
    uint64_t ranges = m->grid.size_bytes + m->weights.size_bytes + vw_visibility_network(m).size_bytes +
                      vw_uncertainty_network(m).size_bytes;
    for (uint32_t i = 0; i < VW_SLOT_COUNT; i++) ranges += m->ranges[i].size_bytes;
    assert_in_range(m->param_bytes - ranges, 0, 4 * 256); // there is no other range; some begin at multiples of 256
    compare_weights(&f, &skipped);
    compare_grid(&f, &skipped);
    compare_sky(&f, &skipped);
    compare_visibility(&f, &skipped);
    compare_uncertainty(&f, &skipped);
    int taken = PER_RANGE * (int)(REFERENCE_MATRICES + f.model.specialization.levels) + compare_codes(&f, &skipped);
    if (skipped * 10 > taken) fail_msg("%s: %d of %d parameters stand at kinks", f.where, skipped, taken);
}

// Returns whether another program tests the effect: transient, with a loss and a reference of its own, see
// test_transient_gradients; pose, see test_pose_gradients; appearance_encoder, see test_encoder_gradients.
static bool is_elsewhere(const char *effect) {
    return !strcmp(effect, "transient") || !strcmp(effect, "pose") || !strcmp(effect, "appearance_encoder");
}

TEST(the_gradient_is_the_slope_of_the_loss) {
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    char all[192] = "";
    uint32_t count;
    assert_int_equal(vw_effects_find_facts(&empty_scene, "none", effects, &count), VW_OK);
    for (uint32_t i = 0; i < count; i++)
        if (!is_elsewhere(effects[i].name) && strcmp(effects[i].name, "uncertainty") != 0) // it excludes visibility
            snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", *all ? "," : "", effects[i].name);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        for (size_t k = 0; k < VW_ARRAY_COUNT(all_losses); k++) {
            compare_ranges(&cases[i], all_losses[k], "none");
            compare_ranges(&cases[i], all_losses[k], all);
            for (uint32_t e = 0; e < count; e++)
                if (!is_elsewhere(effects[e].name)) compare_ranges(&cases[i], all_losses[k], effects[e].name);
        }
    }
}
