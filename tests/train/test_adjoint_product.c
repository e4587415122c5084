// The passes of the backward pass against double precision, at a state of a real training: the Gauss-Newton product
// against J^T L'' J, with J direction by differences of the reference's colours and the reference's backward pass; the
// direction and the credit of a step; and the gradient of U, validation's score, by differences of its rays' colours.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/reference.h"
#include "reference/step_bench.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/lasting.h"

// Bfloats between passes, kinks of ReLUs within the difference of colours (1e-3 of the params; the random adjoint is
// rougher than any real one), quanta of the grid. Seen: 0.008 to 0.05.
static const double TOLERANCE = 0.1;
static const double SCORE_TOLERANCE = 0.05; // the same without the kinks within a difference
static const uint64_t STEP = 47;

static void add_params(struct reference_params *to, const struct reference_params *direction, double factor,
                       const struct vw_model *model) {
    double *weights = (double *)&to->weights;
    const double *towards = (const double *)&direction->weights;
    for (size_t i = 0; i < 2 * (size_t)vw_volume_of(model)->pair_count; i++) to->grid[i] += factor * direction->grid[i];
    for (size_t i = 0; i < sizeof to->weights / sizeof *weights; i++) weights[i] += factor * towards[i];
    for (int i = 0; i < 3 * VW_SKY_COLUMNS; i++) to->sky[i / 3][i % 3] += factor * direction->sky[i / 3][i % 3];
    for (size_t i = 0; i < VW_ARRAY_COUNT(to->code_weights); i++)
        to->code_weights[i] += factor * direction->code_weights[i];
    for (uint32_t i = 0; i < reference_photo_count(model); i++) {
        double *photo = (double *)&to->photos[i];
        const double *moved = (const double *)&direction->photos[i];
        for (size_t k = 0; k < sizeof *to->photos / sizeof *photo; k++) photo[k] += factor * moved[k];
    }
}

// Returns what is seen of a ray, given its error.
static double seen(const struct reference_step *step, uint32_t ray, int channel) {
    return step->errors[ray][channel] + step->rays[ray].target[channel];
}

// Returns J^T L'' J direction at `before`, with samples held fixed. Takes `sample_places` over.
static struct reference_step *reference_product(const struct vw_model *model, const float *before,
                                                const float *direction, const struct vw_ray *rays,
                                                const double (*places)[2], double *sample_places, uint32_t ray_count,
                                                uint32_t view) {
    struct reference_params *params = reference_params_create(model, before),
                            *towards = reference_params_create(model, direction);
    struct reference_step *step = reference_step_create(model, rays, ray_count);
    double(*slopes)[3] = test_allocate(ray_count, sizeof *slopes);
    double size = 0, by = 0, h;
    for (uint64_t i = 0; i < model->param_bytes / 4; i++) {
        size += before[i] * before[i];
        by += direction[i] * direction[i];
    }
    h = 1e-6 * sqrt(size / by);
    step->view = view;
    step->sample_places = sample_places;
    memcpy(step->places, places, ray_count * sizeof *places);
    add_params(params, towards, h, model);
    reference_step_forward(step, params, true, STEP);
    for (uint32_t ray = 0; ray < ray_count; ray++)
        for (int c = 0; c < 3; c++) slopes[ray][c] = seen(step, ray, c);
    add_params(params, towards, -2 * h, model);
    reference_step_forward(step, params, true, STEP);
    for (uint32_t ray = 0; ray < ray_count; ray++)
        for (int c = 0; c < 3; c++) slopes[ray][c] = (slopes[ray][c] - seen(step, ray, c)) / (2 * h);
    add_params(params, towards, h, model);
    reference_step_forward(step, params, true, STEP);
    for (uint32_t ray = 0; ray < ray_count; ray++)
        for (int c = 0; c < 3; c++) // the slope of a squared error is twice the error
            step->errors[ray][c] =
                slopes[ray][c] * reference_curvature(&model->specialization, step->errors[ray][c]) / 2;
    struct vw_model squared = *model;
    squared.specialization.loss = LOSS_L2;
    step->model = &squared;
    reference_step_backward(step, params);
    step->model = model;
    return step;
}

// Returns the reference's gradients as a block.
static double *as_block(const struct vw_model *model, struct reference_step *step) {
    const struct vw_specialization *s = &model->specialization;
    double *block = test_allocate(model->param_bytes / 4, sizeof *block);
    double *weights = block + model->weights.offset_bytes / 4,
           *code_weights = block + model->ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes / 4,
           *codes = block + model->ranges[VW_SLOT_CODES].offset_bytes / 4;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    memcpy(block, step->d_grid, 2 * (size_t)vw_volume_of(model)->pair_count * sizeof *block);
    reference_matrices(s, &step->d_weights, matrices);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++)
        for (uint32_t i = 0; i < matrices[m].out * matrices[m].in; i++)
            weights[reference_block_index(s, m, i / matrices[m].in, i % matrices[m].in)] = matrices[m].values[i];
    for (int i = 0; model->ranges[VW_SLOT_SKY].size_bytes && i < 3 * VW_SKY_COLUMNS; i++)
        weights[4 * model->weight_columns + i / 3 * 4 + i % 3] = step->d_sky[i / 3][i % 3];
    for (uint64_t i = 0; i < model->ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / 4; i++)
        code_weights[i] = step->d_code_weights[i];
    for (uint32_t i = 0; model->ranges[VW_SLOT_CODES].size_bytes && i < REFERENCE_CODE; i++)
        codes[REFERENCE_CODE * step->view + i] = step->d_code[i];
    for (uint64_t i = 0; i < model->param_bytes / 4; i++) block[i] *= s->inverse_rays;
    return block;
}

// Returns where in their photo pixels lie, -1 to 1 across it.
static double (*places_of(const struct vw_trainer_parts *context, uint32_t first, uint32_t view, uint32_t count))[2] {
    double(*places)[2] = test_allocate(count, sizeof *places);
    struct vw_pixel *pixels = test_allocate(count, sizeof *pixels);
    ASSERT_OK(vw_buffer_read(context->pixels, first * sizeof *pixels, pixels, count * sizeof *pixels));
    const struct vw_image *image = &context->scene->views[view].image;
    for (uint32_t i = 0; i < count; i++) {
        places[i][0] = 2.0 * pixels[i].x_px / image->width_px - 1.0;
        places[i][1] = 2.0 * pixels[i].y_px / image->height_px - 1.0;
    }
    return places;
}

// Takes one step back from a random adjoint, and checks what it added against the reference.
static void check_step(struct vw_lasting *lasting, const char *where) {
    const struct vw_model *model = lasting->replay.context->field->model;
    const struct vw_step_passes *step = lasting->replay.context->step;
    const struct vw_adjoint_blocks *adjoint =
        &lasting->backward.by_measure[lasting->backward.measure_count - 1]; // its direction is left
    uint64_t count = model->param_bytes / 4;
    float *lambda = test_allocate(count, sizeof *lambda);
    struct test_random random = {.seed = 3};
    for (uint64_t i = 0; i < count; i++) lambda[i] = test_random_next(&random);
    ASSERT_OK(vw_buffer_write(adjoint->lambda, 0, lambda, model->param_bytes));
    vw_submission_begin(lasting->replay.submission);
    uint32_t pixel = vw_step_replay_draw(&lasting->replay, STEP, 0),
             view = vw_photo_order_view_of_step(lasting->replay.context->photo_order, STEP);
    vw_stored_steps_record_load(&lasting->stored, lasting->replay.submission, (uint32_t)STEP - 1,
                                &lasting->backward.blocks);
    vw_adjoint_record_step(&lasting->backward, lasting->replay.submission, STEP, pixel, 0);
    ASSERT_OK(vw_step_replay_run(&lasting->replay));
    float *before = test_read(lasting->backward.blocks.before), *after = test_read(lasting->backward.blocks.after),
          *gradient = test_read(lasting->backward.blocks.gradient), *direction = test_read(lasting->backward.direction),
          *moved = test_read(adjoint->lambda);
    const vw_float4 row =
        ((const vw_float4 *)vw_buffer_map(lasting->backward.rows))[lasting->backward.measure_count - 1];
    double credit = 0, credit_size = 0;
    for (uint64_t i = 0; i < count; i++) {
        double rate = gradient[i] != 0.0f ? ((double)before[i] - after[i]) / gradient[i] : 0.0;
        check_value(where, "direction", i, direction[i], -rate * lambda[i], 1e-5 * fabs(rate) + 1e-12);
        if (gradient[i] == 0.0f) continue; // visibility is held fixed
        credit += (double)lambda[i] * ((double)after[i] - before[i]);
        credit_size += fabs((double)lambda[i] * ((double)after[i] - before[i]));
    }
    check_value(where, "credit", STEP, (double)row.x + row.y, credit, 1e-5 * credit_size);
    const struct vw_param_range *held = &model->ranges[VW_SLOT_APPEARANCE];
    for (uint64_t i = held->offset_bytes / 4; i < (held->offset_bytes + held->size_bytes) / 4; i++)
        assert_true(gradient[i] == 0.0f && moved[i] == lambda[i]);
    uint32_t counted = vw_step_counted_rays(step, pixel),
             taken = lasting->backward.rays < counted ? lasting->backward.rays : counted;
    assert_int_equal(counted<step->rays, lasting->replay.context->scene->masked_view_count> 0);
    const struct vw_push_rays push = {
        .first_pixel = pixel, .ray_count = taken, .key = vw_model_key_of_step(model, STEP)};
    vw_submission_begin(lasting->replay.submission);
    vw_submission_dispatch(lasting->replay.submission, vw_volume_step_of(step)->gradient.of_rays.generate, &push,
                           sizeof push, step->padded_rays);
    ASSERT_OK(vw_step_replay_run(&lasting->replay));
    struct vw_ray *rays = test_read(step->ray_buffer);
    double(*places)[2] = places_of(lasting->replay.context, pixel, view, taken);
    struct reference_step *reference =
        reference_product(model, before, direction, rays, (const double(*)[2])places,
                          step_bench_sample_places(vw_volume_step_of(step)->places), taken, view);
    double *expected = as_block(model, reference), difference = 0, size = 0;
    double factor = (double)counted / taken;
    for (uint64_t i = 0; i < count; i++) {
        double added = (double)moved[i] - lambda[i], wanted = factor * expected[i];
        difference += (added - wanted) * (added - wanted);
        size += wanted * wanted;
    }
    if (!(size > 0 && sqrt(difference / size) < TOLERANCE))
        fail_msg("%s: the product is off by %g of its size", where, sqrt(difference / size));
}

// ---- The gradient of U ----------------------------------------------------------------------------------------------

struct score_case {
    const struct vw_validation *validation;
    const struct vw_ray *rays;
    const struct vw_ray_range *scored, *fitted; // fitted: NULL where nothing is fitted
    bool loss;                                  // minus L1 instead of PSNR
};

// Returns validation's score from the colours of its rays, one view's share.
static double score_of_view(const struct score_case *score, const double (*colours)[3], uint32_t view) {
    double squared = 0, absolute = 0, values = 0;
    for (int c = 0; c < 3; c++) {
        double gain = 0, bias = 0, rendered[VIEW_FIT_RAYS_MAX], target[VIEW_FIT_RAYS_MAX];
        uint32_t count = 0;
        for (uint32_t i = 0; score->fitted && i < score->fitted[view].count; i++) {
            uint32_t ray = score->fitted[view].first + i;
            if (score->rays[ray].target_weight.w == 0.0f) continue;
            rendered[count] = colours[ray][c];
            target[count++] = (&score->rays[ray].target_weight.x)[c];
        }
        if (score->fitted) reference_fit_channel(rendered, target, count, &gain, &bias);
        for (uint32_t i = 0; i < score->scored[view].count; i++) {
            uint32_t ray = score->scored[view].first + i;
            double error = (1 + gain) * colours[ray][c] + bias - (&score->rays[ray].target_weight.x)[c];
            if (score->rays[ray].target_weight.w == 0.0f) continue;
            squared += error * error;
            absolute += fabs(error);
            values++;
        }
    }
    double total = 0;
    for (uint32_t i = 0; i < score->validation->view_count; i++) total += 3.0 * score->validation->pixel_counts[i];
    return score->loss ? -absolute / total : -10 * log10(squared / values) / score->validation->view_count;
}

static void slope_range(const struct score_case *score, double (*colours)[3], uint32_t view,
                        const struct vw_ray_range *range, double (*slopes)[3]) {
    const double h = 1e-6;
    for (uint32_t ray = range->first; ray < range->first + range->count; ray++)
        for (int c = 0; c < 3; c++) {
            double colour = colours[ray][c], ahead;
            colours[ray][c] = colour + h;
            ahead = score_of_view(score, (const double(*)[3])colours, view);
            colours[ray][c] = colour - h;
            slopes[ray][c] = (ahead - score_of_view(score, (const double(*)[3])colours, view)) / (2 * h);
            colours[ray][c] = colour;
        }
}

// Checks the gradient of the last state's share of 1 / `states`, from an adjoint of 0.
static void check_score_gradient(struct vw_lasting *lasting, const char *where, uint32_t measure) {
    const struct vw_validation *validation = lasting->replay.context->validation;
    const struct vw_model *model = lasting->replay.context->field->model;
    const uint32_t ray_count = validation->evaluator.ray_count, states = 3;
    uint64_t count = model->param_bytes / 4;
    float *zero = test_allocate(count, sizeof *zero);
    for (uint32_t i = 0; i < lasting->backward.measure_count; i++)
        ASSERT_OK(vw_buffer_write(lasting->backward.by_measure[i].lambda, 0, zero, model->param_bytes));
    vw_submission_begin(lasting->replay.submission);
    vw_stored_steps_record_load(&lasting->stored, lasting->replay.submission, (uint32_t)STEP - 1,
                                &lasting->backward.blocks);
    vw_adjoint_record_state(&lasting->backward, lasting->replay.submission, 0, states);
    ASSERT_OK(vw_step_replay_run(&lasting->replay));
    float *after = test_read(lasting->backward.blocks.after),
          *lambda = test_read(lasting->backward.by_measure[measure].lambda);
    struct vw_ray *rays = test_read(validation->evaluator.rays);
    struct vw_ray_range *scored = test_read(validation->ranges),
                        *fitted = validation->view_fit.ranges ? test_read(validation->view_fit.ranges) : NULL;
    const struct score_case score = {validation, rays, scored, fitted, measure == ADJOINT_LOSS};

    struct vw_model plain = *model; // validation takes nobody's code, gain or bias, and skips nothing
    plain.specialization.loss = LOSS_L2;
    plain.specialization.effect_appearance = plain.specialization.effect_appearance_code = 0;
    struct reference_params *params = reference_params_create(model, after);
    struct reference_step *step = reference_step_create(&plain, rays, ray_count);
    step->sample_places = step_bench_sample_places(vw_volume_evaluation_of(&validation->evaluator)->places);
    params->photos = NULL;
    params->visibility_codes = NULL;
    reference_step_forward(step, params, false, 0);
    double(*colours)[3] = test_allocate(ray_count, sizeof *colours),
    (*slopes)[3] = test_allocate(ray_count, sizeof *slopes);
    memcpy(colours, step->colours, ray_count * sizeof *colours);
    for (uint32_t view = 0; view < validation->view_count; view++) {
        if (measure >= ADJOINT_OF_VIEWS && view != measure - ADJOINT_OF_VIEWS) continue;
        slope_range(&score, colours, view, &scored[view], slopes);
        if (fitted) slope_range(&score, colours, view, &fitted[view], slopes);
    }
    for (uint32_t ray = 0; ray < ray_count; ray++)
        for (int c = 0; c < 3; c++) step->errors[ray][c] = 3 * slopes[ray][c] / 2; // a third of a slope of 2 x error
    reference_step_backward(step, params);
    step->model = model;
    double *expected = as_block(model, step), difference = 0, size = 0;
    for (uint64_t i = 0; i < count; i++) {
        double wanted = expected[i] / model->specialization.inverse_rays / states;
        if (measure >= ADJOINT_OF_VIEWS) wanted *= validation->view_count; // not of a mean over views
        if (i >= model->ranges[VW_SLOT_APPEARANCE].offset_bytes / 4 && model->ranges[VW_SLOT_APPEARANCE].size_bytes)
            wanted = 0;
        difference += (lambda[i] - wanted) * (lambda[i] - wanted);
        size += wanted * wanted;
    }
    if (!(size > 0 && sqrt(difference / size) < SCORE_TOLERANCE))
        fail_msg("%s, measure %u: the gradient of U is off by %g of its size", where, measure, sqrt(difference / size));
}

TEST(meets_the_reference) {
    static const struct {
        const char *effects;
        enum vw_loss loss;
        uint32_t rays; // number of rays in the product
        uint32_t importance_samples;
    } cases[] = {{"none", VW_LOSS_L2, 0, 0},
                 {"none", VW_LOSS_L1, 64, 0},
                 {"sky,unbounded", VW_LOSS_HUBER, 0, 0},
                 {"none", VW_LOSS_L2, 0, 24},
                 {"appearance,appearance_code", VW_LOSS_L2, 0, 0},
                 {"visibility,sky", VW_LOSS_HUBER, 0, 0},
                 {"masks", VW_LOSS_L2, 24, 0},
                 {"masks,visibility,sky", VW_LOSS_L2, 0, 24}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = test_scene();
        if (!strncmp(cases[i].effects, "masks", 5)) test_hide_some(scene);
        struct vw_config config = test_config();
        config.epochs = 10;
        config.rays = 120;
        config.loss = cases[i].loss;
        config.importance_samples = cases[i].importance_samples;
        strcpy(config.effects, cases[i].effects);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        struct vw_trainer_params training = {.gpu = test_gpu(), .scene = scene, .config = &config, .validate = true};
        training.effects = vw_trainer_effects(trainer, &training.effect_count);
        const struct vw_lasting_params params = {.training = &training, .rays = cases[i].rays, .by_view = i % 2 == 0};
        struct vw_lasting *lasting = NULL;
        ASSERT_OK(vw_lasting_create(&params, &lasting));
        test_release(trainer);
        const struct vw_lasting_credit *credits;
        uint32_t count;
        for (bool done = false; !done;) ASSERT_OK(vw_lasting_advance(lasting, &credits, &count, &done));
        check_step(lasting, cases[i].effects);
        for (uint32_t measure = 0; measure < lasting->backward.measure_count; measure++)
            check_score_gradient(lasting, cases[i].effects, measure);
        vw_lasting_destroy(&lasting);
    }
}

TEST_GROUP(NULL, test_gpu_close)
