// The trainer as a whole: what it must guarantee whatever the scene (decisions 1, 2, 5, 8, 9 of src/README.md). On the
// default device, with validation.
#include "support/cmocka_test.h"

#include <inttypes.h>

#include "base/memory.h"
#include "gpu/command_list.h"
#include "gpu/compute.h"
#include "reference/step_bench.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/device_photos.h"
#include "train/pixels.h"
#include "train/trainer.h"
#include "train/trainer_private.h"

// On a CPU, where many steps in a submission gain nothing, cheap ones take no more memory than 128 default ones.
TEST(submissions_of_cheap_steps_stay_small) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    uint64_t pixel_bytes = vw_buffer_size_bytes(trainer->pixels);
    assert_true(trainer->photo_order.submission_steps_max > 64);
    if (vw_gpu_get_info(test_gpu())->kind == VW_GPU_CPU)
        assert_true(pixel_bytes <= SUBMISSIONS_IN_FLIGHT * sizeof(struct vw_pixel) * 128 * vw_config_default.rays);
}

// Every photo once per epoch, in an order shuffled anew; step 0 has no photo.
TEST(each_view_comes_once_per_epoch) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct test_run *run = test_run(scene, &config, true, 0);
    assert_int_equal(run->records[0].view, VW_RECORD_UNTRAINED);
    assert_true(isnan(run->records[0].train_loss) && isfinite(run->records[0].val_psnr));
    for (uint32_t epoch = 0; epoch < config.epochs; epoch++) {
        uint32_t seen = 0;
        for (uint32_t i = 0; i < 5; i++) {
            const struct vw_step_record *record = &run->records[1 + 5 * epoch + i];
            assert_int_equal(record->step, 1 + 5 * epoch + i);
            assert_int_equal(record->epoch, epoch);
            seen |= 1u << record->view;
        }
        assert_int_equal(seen, 0x1f);
    }
}

// Decision 5: val_psnr is the mean of the views' PSNR, floored at 100 dB; the pooled form and L1 come from the same
// sums.
TEST(psnr_means_what_it_says) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    config.epochs = 40;
    struct test_run *run = test_run(scene, &config, true, 0);
    for (uint32_t i = 0; i < run->count; i++) {
        double psnr = 0.0, mse = 0.0, l1 = 0.0;
        for (uint32_t v = 0; v < TEST_VALS; v++) {
            psnr += -10.0 * log10(fmax(run->views[i][v].mse, 1e-10)) / TEST_VALS;
            mse += run->views[i][v].mse / TEST_VALS; // all views have the same number of pixels
            l1 += run->views[i][v].l1 / TEST_VALS;
        }
        assert_near(run->records[i].val_psnr, psnr, 1e-12);
        assert_near(run->records[i].val_psnr_pooled, -10.0 * log10(mse), 1e-12);
        assert_near(run->records[i].val_l1, l1, 1e-14);
    }
    assert_true(run->records[run->count - 1].val_psnr > run->records[0].val_psnr + 1.0); // it learns
}

// Opens a trainer that draws pixels on the device or on the host; `submissions` NULL: with its own.
static struct vw_trainer *open_drawing(const struct vw_scene *scene, const struct vw_config *config, bool on_device,
                                       struct vw_submissions *submissions) {
    struct vw_device_choices choices;
    vw_device_choose(vw_gpu_get_info(test_gpu()), &choices);
    choices.draws_pixels = on_device;
    return test_trainer_open((struct vw_trainer_params){.scene = scene,
                                                        .config = config,
                                                        .validate = true,
                                                        .choices = &choices,
                                                        .submissions = submissions,
                                                        .steps_per_submission = 4});
}

// Decision 9: where the host draws, device memory depends on neither the size nor the number of the photos' pixels.
TEST(memory_is_flat_in_pixels) {
    struct vw_config config = test_config();
    uint64_t bytes[2];
    for (int large = 0; large < 2; large++) {
        struct vw_scene *scene = synthetic_scene(&(struct synthetic_scene_params){
            .train_views = 5, .val_views = TEST_VALS, .width_px = large ? 640 : 32, .height_px = large ? 480 : 24});
        struct vw_trainer *trainer = open_drawing(scene, &config, false, NULL);
        struct vw_trainer_stats stats;
        vw_trainer_get_stats(trainer, &stats);
        bytes[large] = stats.device_bytes;
        test_release(trainer);
    }
    assert_int_equal(bytes[0], bytes[1]);
}

// World coordinates of 1e6 metres train as well as those of 1.
TEST(world_offset_and_scale_change_little) {
    static const double worlds[][2] = {{0, 1}, {1e6, 1}, {-3e5, 1e6}};
    struct vw_config config = test_config();
    config.epochs = 12;
    double psnr[3];
    for (int i = 0; i < 3; i++) {
        struct synthetic_scene_params params = {5, TEST_VALS, .width_px = 24, .height_px = 18};
        params.world_offset = worlds[i][0];
        params.world_scale = worlds[i][1];
        const struct test_run *run = test_run(synthetic_scene(&params), &config, true, 0);
        psnr[i] = run->records[run->count - 1].val_psnr;
    }
    // Rounding of 1e6 in double moves rays by 1e-10; trainings that start so close end within a tenth of a dB.
    assert_near(psnr[1], psnr[0], 0.1);
    assert_near(psnr[2], psnr[0], 0.1);
}

// Decision 8: a step that is not finite is skipped and flagged, has no values, and the run goes on.
TEST(a_nonfinite_step_is_flagged) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    const float nan = NAN;
    ASSERT_OK(vw_buffer_write(trainer->field.params, trainer->model.weights.offset_bytes, &nan, sizeof nan));
    struct test_run *run = test_run_of(trainer);
    assert_int_equal(run->stats.nonfinite_steps, run->count);
    for (uint32_t i = 0; i < run->count; i++)
        assert_true(run->records[i].nonfinite && isnan(run->records[i].val_psnr) && isnan(run->records[i].val_l1));
}

// Trains a whole run on a device of its own, with its limits clamped or choices forced, unless NULL.
static struct test_run *run_clamped(const struct vw_scene *scene, const struct vw_config *config,
                                    const struct vw_gpu_limits *clamp, const struct vw_device_choices *choices,
                                    uint32_t wide) {
    struct vw_gpu *gpu = test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = clamp});
    struct vw_trainer *trainer = test_trainer_open(
        (struct vw_trainer_params){.gpu = gpu, .scene = scene, .config = config, .validate = true, .choices = choices});
    if (choices) assert_int_equal(trainer->model.specialization.skip_zeros, choices->skip_zeros);
    if (choices) assert_int_equal(trainer->model.specialization.rows_texel, choices->rows_texel);
    assert_int_equal(trainer->model.specialization.wide_gradient, wide);
    struct test_run *run = test_run_of(trainer);
    test_release(trainer);
    test_release(gpu);
    return run;
}

// A device that cannot be told to keep NaN may round otherwise, since its driver may then rearrange sums: still the
// same training.
TEST(a_device_that_keeps_no_nan_trains_the_same) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    if (!clamp.keeps_nan) skip();
    clamp.keeps_nan = false;
    struct test_run *ordinary = test_run(scene, &config, true, 0), *run = run_clamped(scene, &config, &clamp, NULL, 0);
    assert_int_equal(run->count, ordinary->count);
    for (uint32_t i = 0; i < run->count;
         i++) // roundings of 2^-24, which 15 steps have not driven apart to where a reader would see it
        assert_near(run->records[i].val_psnr, ordinary->records[i].val_psnr, 1e-3);
}

// A device with nothing but the floor's limits and no optional feature trains to the same bits here (storage buffers
// for texels, two 32-bit atomics for a 64-bit one), for narrow and wide gradients. (What keeping NaN changes is
// a_device_that_keeps_no_nan_trains_the_same's business.)
TEST(a_device_at_the_floor_trains_the_same) {
    struct vw_gpu_limits floor = vw_gpu_floor_limits;
    floor.keeps_nan = true;
    struct vw_scene *scene = test_scene();
    for (uint32_t wide = 0; wide < 2; wide++) {
        struct vw_config config = test_config();
        config.rays = wide ? 2100 : 60; // beyond 2^15 samples a step, words are wide
        test_run_assert_same(run_clamped(scene, &config, &floor, NULL, wide), test_run(scene, &config, true, 0));
    }
}

static const enum vw_gpu_kind kinds[] = {VW_GPU_CPU, VW_GPU_DISCRETE}; // one of them is chosen for like the device

// With slices of one length and as many parts; those of the other kind round otherwise.
TEST_CASES(the_choices_for_each_kind_train_the_same, i, VW_ARRAY_COUNT(kinds)) {
    struct vw_device_choices choices, own;
    vw_device_choose(&(struct vw_gpu_info){.kind = kinds[i]}, &choices);
    vw_device_choose(vw_gpu_get_info(test_gpu()), &own);
    assert_int_equal(choices.skip_zeros, kinds[i] == VW_GPU_DISCRETE);
    assert_true(kinds[i] == VW_GPU_CPU || choices.scatter == SCATTER_ATOMICS);
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct test_run *ordinary = test_run(scene, &config, true, 0);
    struct test_run *rounded = run_clamped(scene, &config, NULL, &choices, 0);
    for (uint32_t k = 0; k < ordinary->count; k++)
        assert_near(rounded->records[k].val_psnr, ordinary->records[k].val_psnr, 1e-3);
    choices.slice_samples = own.slice_samples, choices.slice_parts = own.slice_parts;
    choices.ray_lanes = own.ray_lanes;
    struct test_run *same = run_clamped(scene, &config, NULL, &choices, 0);
    test_run_assert_same(same, ordinary);
}

static const enum vw_field fields[] = {VW_FIELD_HASH, VW_FIELD_MLP, VW_FIELD_SPLATS};

TEST_CASES(commands_submitted_again_train_the_same, i, VW_ARRAY_COUNT(fields)) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_of(fields[i]);
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    assert_true(clamp.resubmits);
    clamp.resubmits = false;
    struct vw_trainer *trainer = test_trainer_open((struct vw_trainer_params){
        .gpu = test_gpu(), .scene = scene, .config = &config, .validate = true, .steps_per_submission = 1});
    uint64_t submitted = vw_gpu_submission_counts(test_gpu()).submitted, recordings = 0;
    test_run_assert_same(test_run_of(trainer), run_clamped(scene, &config, &clamp, NULL, 0));
    submitted = vw_gpu_submission_counts(test_gpu()).submitted - submitted;
    for (int k = 0; k < SUBMISSIONS_IN_FLIGHT; k++)
        recordings += vw_submission_recordings(trainer->submissions->submissions[k]);
    print_message("%" PRIu64 " of %" PRIu64 " submissions recorded\n", recordings, submitted);
    assert_true(recordings < submitted / 2);
}

static const struct {
    enum vw_field field;
    const char *effects;
    double consistency_weight; // for pixels that make a picture
    bool sorted;               // the host draws in any case
} drawn_cases[] = {
    {VW_FIELD_HASH, "none", 0.0, false},
    {VW_FIELD_HASH, "masks", 0.0, true},
    {VW_FIELD_HASH, "appearance_encoder,visibility", 0.01, false},
    {VW_FIELD_SPLATS, "masks,background", 0.0, false},
};

TEST_CASES(pixels_drawn_on_the_device_train_the_same, i, VW_ARRAY_COUNT(drawn_cases)) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config_of(drawn_cases[i].field);
    strcpy(config.effects, drawn_cases[i].effects);
    config.consistency_weight = drawn_cases[i].consistency_weight;
    config.rays = i == 3 ? 3 * 256 : 1100; // the picture has up to 32 x 32 pixels
    test_hide_some(scene);
    struct vw_trainer *on_device = open_drawing(scene, &config, true, NULL);
    assert_true(drawn_cases[i].sorted ? !on_device->step.photos
                                      : on_device->step.photos && on_device->step.draw_pixels);
    struct vw_trainer *on_host = open_drawing(scene, &config, false, NULL);
    assert_null(on_host->step.photos);
    test_run_assert_same(test_run_of(on_device), test_run_of(on_host));
}

// One begins on the host, the other goes on from its checkpoint on the device.
TEST(a_run_goes_on_where_others_draw_its_pixels) {
    struct vw_scene *scene = test_scene();
    const struct vw_config config = test_config();
    struct test_run *run = test_allocate(1, sizeof *run);
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "checkpoint");
    struct vw_trainer *first = open_drawing(scene, &config, false, NULL),
                      *second = open_drawing(scene, &config, true, NULL);
    uint64_t step;
    vw_trainer_stop_after(first, 7);
    test_run_advance(first, run);
    ASSERT_OK(vw_trainer_save_checkpoint(first, path));
    ASSERT_OK(vw_trainer_load_checkpoint(second, path, UINT64_MAX, &step));
    test_run_finish(second, run);
    test_run_assert_same(run, test_run(scene, &config, true, 0));
    temporary_folder_remove(folder);
}

// Trainers of one scene share its photos; the memory that each takes does not count them. One of another scene, and one
// whose effect has something to fill in beside each pixel, draw on the host.
TEST(trainers_share_photos) {
    struct vw_scene *scene = test_scene(), *other = test_scene();
    struct vw_config config = test_config(), longer = test_config();
    longer.seed = 9;
    struct vw_submissions *submissions = test_submissions();
    uint64_t bytes = vw_submissions_unshared_bytes(submissions, test_gpu()), all = vw_gpu_buffer_bytes(test_gpu());
    struct vw_trainer *a = open_drawing(scene, &config, true, submissions),
                      *b = open_drawing(scene, &longer, true, submissions),
                      *c = open_drawing(other, &config, true, submissions);
    assert_true(a->step.photos && a->step.photos == b->step.photos && !c->step.photos);
    uint64_t photo_bytes = vw_buffer_size_bytes(a->step.photos->buffer);
    assert_int_equal(photo_bytes, 4 * 24 * 18 * scene->view_count);
    assert_int_equal(vw_submissions_unshared_bytes(submissions, test_gpu()) - bytes + photo_bytes,
                     vw_gpu_buffer_bytes(test_gpu()) - all);
    test_run_assert_same(test_run_of(a), test_run(scene, &config, true, 0));
    test_run_assert_same(test_run_of(b), test_run(scene, &longer, true, 0));
    test_run_assert_same(test_run_of(c), test_run(other, &config, true, 0));
    struct vw_trainer *const all_trainers[] = {a, b, c};
    for (size_t i = 0; i < VW_ARRAY_COUNT(all_trainers); i++) test_release(all_trainers[i]);
    assert_null(submissions->photos); // the next trainer's scene may be at the address of this one
    struct vw_trainer *d = open_drawing(other, &config, true, submissions);
    assert_true(d->step.photos && d->step.photos->scene == other);
}

// --val-rays is a total, stratified within each view, at least 32 per view, on the same pixels for every seed.
TEST(validation_pixels_are_stratified_and_fixed) {
    struct vw_scene *scene = test_scene();
    const uint32_t asked[] = {1, 96, 200, 100000}, taken[] = {3 * 32, 96, 200, 3 * 24 * 18};
    for (size_t i = 0; i < VW_ARRAY_COUNT(asked); i++) {
        struct vw_config config = test_config();
        config.val_rays = asked[i];
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
        assert_int_equal(trainer->validation.ray_count, taken[i]);
        test_release(trainer);
    }
    struct vw_pixel pixels[100];
    scene->views[5].image.unusable =
        vw_allocate(24 * 18, 1); // a NaN in the file, say: left out whether or not alpha has a meaning
    scene->views[5].image.unusable[3 * 24 + 7] = 1;
    assert_true(vw_pixels_at(scene, 5, true, 7, 3).weight == 0.0f && vw_pixels_at(scene, 5, true, 8, 3).weight == 1.0f);
    assert_int_equal(vw_pixels_stratify_squares(scene, 5, vw_pixels_all_columns(scene, 5), 0, true, 1, 100, pixels),
                     100);
    uint32_t quadrant[4] = {0};
    for (int i = 0; i < 100; i++) quadrant[(pixels[i].x_px > 12.0f) + 2 * (pixels[i].y_px > 9.0f)]++;
    for (int i = 0; i < 4; i++) assert_in_range(quadrant[i], 20, 30); // strata of 2 x 2 px keep each quarter near 25
}

// ---- Held after a step ----------------------------------------------------------------------------------------------

static const uint32_t sizes[] = {1, 3, 64, 0};
TEST_CASES(epochs_end_where_they_are_held, i, VW_ARRAY_COUNT(sizes)) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct test_run *whole = test_run(scene, &config, true, 4), *held = test_allocate(1, sizeof *held);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, sizes[i]);
    assert_int_equal(vw_trainer_epoch_end(trainer, 0), 5);
    for (uint64_t step = 0; step < vw_trainer_total_steps(trainer); step = held->count - 1) {
        uint64_t end = vw_trainer_epoch_end(trainer, step + 1);
        vw_trainer_stop_after(trainer, end);
        test_run_advance(trainer, held);
        assert_false(vw_trainer_in_flight(trainer));
        assert_int_equal(held->count, end + 1); // with step 0
        assert_int_equal(end % 5, 0);
    }
    vw_trainer_stop_after(trainer, UINT64_MAX); // the run has an end of its own
    test_run_finish(trainer, held);
    test_run_assert_same(whole, held);
}

// ---- What it is handed ----------------------------------------------------------------------------------------------

enum { LEFT_OUT = 1 }; // the place among the photos to train on

static struct test_run *run_on(const struct vw_scene *scene, const struct vw_config *config, const uint32_t *views,
                               uint32_t count, uint8_t run_id[VW_HASH_BYTES]) {
    struct vw_trainer *trainer = test_trainer_open((struct vw_trainer_params){.gpu = test_gpu(),
                                                                              .scene = scene,
                                                                              .config = config,
                                                                              .train_views = views,
                                                                              .train_view_count = count,
                                                                              .validate = true});
    ASSERT_OK(vw_trainer_run_id(trainer, run_id));
    return test_run_of(trainer);
}

// Also where a photo has numbers of its own, and where its camera would move the box.
static const char *const effects[] = {"none", "appearance,appearance_code", "unbounded"};
TEST_CASES(some_views_are_as_a_scene_of_these, i, VW_ARRAY_COUNT(effects)) {
    struct vw_scene *whole = test_scene(), *smaller = test_scene();
    struct vw_config config = test_config();
    uint32_t *views = NULL, all = 0, count = 0;
    uint8_t ids[3][VW_HASH_BYTES];
    strcpy(config.effects, effects[i]);
    if (!strcmp(effects[i], "unbounded")) whole->box.half_extent_world = smaller->box.half_extent_world = 100.0;
    ASSERT_OK(vw_scene_list_views(whole, VW_SPLIT_TRAIN, &views, &all));
    struct test_run *everything = run_on(whole, &config, views, all, ids[2]);
    test_exclude(smaller, views[LEFT_OUT]);
    for (uint32_t v = 0; v < all; v++)
        if (v != LEFT_OUT) views[count++] = views[v];
    struct test_run *expected = run_on(smaller, &config, NULL, 0, ids[0]),
                    *got = run_on(whole, &config, views, count, ids[1]);
    assert_memory_equal(ids[0], ids[1], 32);
    assert_memory_not_equal(ids[0], ids[2], 32);
    test_run_assert_same(expected, got);
    assert_int_equal(expected->stats.param_count, got->stats.param_count);
    assert_true(everything->count > got->count);
    assert_int_equal(whole->split_count[VW_SPLIT_TRAIN], all);
    free(views);
}

TEST(what_cannot_be_trained_on_is_refused) {
    struct vw_scene *scene = test_scene();
    const struct vw_config config = test_config();
    struct vw_trainer *trainer = NULL;
    struct vw_trainer_params params = {.gpu = test_gpu(), .scene = scene, .config = &config};
    ASSERT_FAILS(vw_trainer_create(&params, &trainer), VW_ERROR_USAGE, "no decisions on effects");

    const uint32_t twice[] = {2, 2}, falling[] = {2, 1}, beyond[] = {2, scene->view_count};
    const uint32_t *const lists[] = {twice, falling, beyond};
    params.train_view_count = 2;
    for (size_t i = 0; i < VW_ARRAY_COUNT(lists); i++) {
        params.train_views = lists[i];
        ASSERT_FAILS(test_trainer_try(params, &trainer), VW_ERROR_USAGE, "train_views[1]");
    }
    params.train_view_count = 0;
    ASSERT_FAILS(test_trainer_try(params, &trainer), VW_ERROR_INPUT, "no view is left to train on");
}

// ---- The learning rate ----------------------------------------------------------------------------------------------

static double moved_by(struct step_bench *bench, uint64_t number, float extra) {
    step_bench_write_params(bench);
    vw_submission_begin(bench->submission);
    vw_step_record_gradients(&bench->step, bench->submission, 1, 0); // the same for all numbers
    vw_step_record_update(&bench->step, bench->submission, number, 0, extra);
    test_submit(bench->submission);
    float *params = test_read(bench->field.params);
    double sum = 0.0;
    for (size_t i = 0; i < bench->model.param_bytes / sizeof *params; i++) sum += fabs(params[i] - bench->params[i]);
    return sum;
}

// Plain descent makes a step as long as its rate.
TEST(the_rate_falls_to_its_share_at_the_last_planned_step) {
    const struct step_case setup = {.name = "decay",
                                    .seed = 41,
                                    .levels = 2,
                                    .width = 16,
                                    .samples = 16,
                                    .learning_rate = 1.0,
                                    .optimizer = VW_OPTIMIZER_SGD};
    struct step_bench *bench = step_bench_open(&setup);
    double constant = moved_by(bench, 7, 0.0f);
    assert_true(constant > 0.0);
    bench->model.learning_rate_decay = 0.01;
    bench->model.planned_steps = 11;
    const struct {
        uint64_t number;
        double share;
    } cases[] = {{1, 1.0}, {6, 0.1}, {11, 0.01}, {12, 0.01}, {UINT64_MAX, 0.01}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        double moved = moved_by(bench, cases[i].number, 0.0f) / constant;
        if (!(fabs(moved - cases[i].share) < 1e-3 * cases[i].share))
            fail_msg("step %llu moves by %g, not %g", (unsigned long long)cases[i].number, moved, cases[i].share);
    }
    assert_true(fabs(moved_by(bench, 6, 0.5f) / constant - 0.15) < 1e-3); // as the gate of lasting credit asks
    bench->model.planned_steps = 1;
    assert_true(vw_model_rate_factor_of_step(&bench->model, 1) == 1.0);
}

TEST(the_planned_steps_are_those_of_the_run) {
    struct vw_config config = test_config();
    config.learning_rate_decay = 0.05;
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, false, 0);
    assert_int_equal(trainer->model.planned_steps, vw_trainer_total_steps(trainer));
}

TEST_GROUP(NULL, test_gpu_close)
