// The effect transient in whole trainings: what it takes, what it must not change, and what it refuses. (That a run in
// parts is the run: test_fields.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/adjoint/lasting.h"
#include "train/effects/registry.h"
#include "train/fields/registry.h"

static struct vw_config config_with(enum vw_field field, const char *effects) {
    struct vw_config config = test_config_of(field);
    strcpy(config.effects, effects);
    return config;
}

// Off there is nothing of it; on, a head and a code per photo, and the field begins with the same numbers.
TEST(what_is_off_takes_no_room) {
    struct vw_scene *scene = test_scene();
    const uint64_t head[VW_FIELD_COUNT] = {16 * (16 + 16 + 1) + 16 * 17 + 5 * 17,
                                           8 * (16 + 16 + 1) + 3 * 8 * 9 + 5 * 9};
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        struct vw_config off = config_with(field, "none"), on = config_with(field, "transient");
        struct vw_trainer *without = test_trainer_create(scene, &off, true, 1),
                          *with = test_trainer_create(scene, &on, true, 1);
        test_trainer_has_no_effects(without);
        assert_null(without->field.head_rows);
        assert_int_equal(without->model.ranges[VW_SLOT_TRANSIENT_CODES].size_bytes, 0);
        assert_int_equal(with->model.param_count, without->model.param_count + head[field] + 16 * 5);
        uint64_t shared = without->model.weights.offset_bytes + without->model.weights.size_bytes;
        char *first = vw_allocate(shared, 1), *second = vw_allocate(shared, 1);
        ASSERT_OK(vw_buffer_read(without->field.params, 0, first, shared));
        ASSERT_OK(vw_buffer_read(with->field.params, 0, second, shared));
        assert_memory_equal(first, second, shared);
        free(first);
        free(second);
        vw_trainer_destroy(&without);
        vw_trainer_destroy(&with);
    }
    vw_scene_close(&scene);
}

static void check_that_nothing_of_it_is_rendered(const struct vw_scene *scene, const struct vw_config *off,
                                                 const struct vw_config *on) {
    struct vw_trainer *without = test_trainer_create(scene, off, true, 0),
                      *with = test_trainer_create(scene, on, true, 0);
    uint64_t own = without->model.weights.offset_bytes + without->model.weights.size_bytes,
             count = (with->model.param_bytes - own) / sizeof(float);
    float *before = NULL, *after = NULL, *sevens = vw_allocate(count, sizeof *sevens);
    for (uint64_t i = 0; i < count; i++) sevens[i] = 7.0f;
    ASSERT_OK(vw_trainer_render(with, 5, &before));
    ASSERT_OK(vw_buffer_write(with->field.params, own, sevens, count * sizeof *sevens));
    ASSERT_OK(vw_trainer_render(with, 5, &after));
    assert_memory_equal(before, after, 3 * sizeof(float) * 24 * 18);
    free(before);
    free(after);
    free(sevens);
    vw_trainer_destroy(&without);
    vw_trainer_destroy(&with);
}

// What validation and rendering see: the untrained field is the same with and without; a step of learning rate 0 and a
// repeated measurement have the same bits; and no number of head or codes changes a picture.
TEST(validation_sees_the_field_alone) {
    struct vw_scene *scene = test_scene();
    for (enum vw_field field = 0; field < VW_FIELD_COUNT; field++) {
        struct vw_config off = config_with(field, "none"), config = config_with(field, "transient");
        off.burn_in_epochs = config.burn_in_epochs = 0;
        config.noise_floor = true;
        config.epochs = 6;
        struct test_run *bare = test_run(scene, &off, true, 1), *run = test_run(scene, &config, true, 4);
        assert_memory_equal(bare->views[0], run->views[0], sizeof run->views[0]);
        uint32_t exact = 0;
        for (uint32_t k = 0; k < run->probe_count; k++) {
            if (run->probes[k].kind == VW_PROBE_RESAMPLED) continue;
            assert_true(test_same_bits(run->probes[k].val_psnr, run->records[run->probes[k].step - 1].val_psnr));
            exact++;
        }
        assert_true(exact > 0);
        check_that_nothing_of_it_is_rendered(scene, &off, &config);
        test_run_free(bare);
        test_run_free(run);
    }
    vw_scene_close(&scene);
}

TEST(what_it_cannot_be_beside_is_refused_by_name) {
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    static const char *const choices[] = {"auto", "+transient", "transient,occupancy"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(choices); i++) {
        struct vw_config config = config_with(VW_FIELD_HASH, choices[i]);
        vw_effects_list(verdicts, &count);
        for (uint32_t k = 0; k < count; k++)
            verdicts[k].on = !strcmp(verdicts[k].name, "occupancy") || !strcmp(verdicts[k].name, "transient");
        bool named = strstr(choices[i], "occupancy") != NULL;
        assert_int_equal(vw_effects_follow_field(&config, verdicts, count), named ? VW_ERROR_USAGE : VW_OK);
        if (named) assert_non_null(strstr(vw_error_message(), "occupancy cannot be beside transient"));
        else assert_false(vw_effects_is_on(verdicts, count, "occupancy"));
        assert_true(vw_effects_is_on(verdicts, count, "transient"));
        config.loss = VW_LOSS_HUBER;
        assert_int_equal(vw_effects_follow_field(&config, verdicts, count), VW_ERROR_USAGE);
    }
    assert_non_null(strstr(vw_error_message(), "needs --loss l2, not huber"));
}

TEST(the_sweep_refuses_it_by_name) {
    struct vw_config config = config_with(VW_FIELD_HASH, "transient");
    struct vw_scene *scene = test_scene();
    struct vw_trainer_params training = {.gpu = test_gpu(), .scene = scene, .config = &config, .validate = true};
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    training.effects = vw_trainer_effects(trainer, &training.effect_count);
    struct vw_lasting *lasting = NULL;
    ASSERT_FAILS(vw_lasting_create(&(struct vw_lasting_params){.training = &training}, &lasting), VW_ERROR_USAGE,
                 "--effects -transient");
    vw_trainer_destroy(&trainer);
    vw_scene_close(&scene);
}

// A photo that is half hidden: what hides it is found to be transient, and the other photos' views suffer less.
static double psnr_with(const struct vw_scene *scene, const char *effects) {
    struct vw_config config = config_with(VW_FIELD_HASH, effects);
    config.epochs = 40;
    struct test_run *run = test_run(scene, &config, true, 0);
    double psnr = 0.0;
    for (uint32_t i = run->count - 10; i < run->count; i++) psnr += run->records[i].val_psnr / 10.0;
    assert_int_equal(run->stats.nonfinite_steps, 0);
    test_run_free(run);
    return psnr;
}

TEST(what_hides_photos_harms_less) {
    struct vw_scene *scene = test_scene();
    for (uint32_t view = 0; view < 5; view++) { // another quarter of each, in a colour of its own
        struct vw_image *image = &scene->views[view].image;
        for (uint32_t y = 0; y < image->height_px / 2; y++)
            for (uint32_t x = 0; x < image->width_px / 2; x++) {
                uint32_t left = view % 2 * image->width_px / 2, top = view / 2 % 2 * image->height_px / 2;
                uint8_t *pixel = (uint8_t *)image->pixels + 4 * ((y + top) * image->width_px + x + left);
                for (uint32_t c = 0; c < 3; c++) pixel[c] = (view + 1) >> c & 1 ? 255 : 0;
            }
    }
    double without = psnr_with(scene, "none"), with = psnr_with(scene, "transient");
    print_message("photos hidden by a quarter: %.2f dB without, %.2f dB with transient\n", without, with);
    assert_true(with > without);
    vw_scene_close(&scene);
}

TEST_GROUP(NULL, test_gpu_close)
