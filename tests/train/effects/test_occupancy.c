// The effect `occupancy` in whole trainings: the run's bits do not depend on how it is cut into submissions or parts,
// validation sees everything, off it leaves nothing behind, and it finds space to skip.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// Returns a run past the warm-up, with refreshes on both sides of it.
static struct vw_config skipping_config(void) {
    struct vw_config config = test_config();
    config.epochs = 60; // 5 steps each
    config.rays = 32;
    config.samples = 64;
    config.learning_rate = 0.02;
    snprintf(config.effects, sizeof config.effects, "occupancy");
    return config;
}

// Makes photos whose upper half is black, so that the field soon empties there.
static struct vw_scene *dark_scene(void) {
    struct vw_scene *scene = test_scene();
    for (uint32_t i = 0; i < scene->view_count; i++) {
        struct vw_image *image = &scene->views[i].image;
        for (uint32_t p = 0; p < image->width_px * (image->height_px / 2); p++)
            memset((uint8_t *)image->pixels + 4 * (size_t)p, 0, 3);
    }
    return scene;
}

// Returns how many samples the last step kept.
static uint32_t last_kept(struct vw_trainer *trainer) {
    uint32_t kept;
    ASSERT_OK(vw_buffer_read(trainer->step.effect_buffers[VW_SLOT_KEPT_BEGINS], 4ull * trainer->step.padded_rays, &kept,
                             sizeof kept));
    return kept;
}

// Goes on in a second trainer from within the skipping part.
static void run_parts(const struct vw_scene *scene, const struct vw_config *config, struct test_run *run) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "checkpoint");
    const struct vw_step_record *records;
    uint32_t count;
    uint64_t step = 0;
    struct vw_trainer *first = test_trainer_create(scene, config, true, 7),
                      *second = test_trainer_create(scene, config, true, 0);
    while (!run->count || run->records[run->count - 1].step < 270) {
        ASSERT_OK(vw_trainer_advance(first, &records, &count));
        test_run_keep(run, records, count);
    }
    while (vw_trainer_in_flight(first)) {
        ASSERT_OK(vw_trainer_collect(first, &records, &count));
        test_run_keep(run, records, count);
    }
    print_message("%u samples of %u are kept\n", last_kept(first), first->model.specialization.chunk_samples);
    assert_true(last_kept(first) > 0 &&
                last_kept(first) < first->model.specialization.chunk_samples); // there is something to get wrong
    ASSERT_OK(vw_trainer_save_checkpoint(first, path));
    ASSERT_OK(vw_trainer_load_checkpoint(second, path, UINT64_MAX, &step));
    test_run_finish(second, run);
    temporary_folder_remove(folder);
}

TEST(a_run_has_the_same_bits_however_it_is_cut) {
    struct vw_scene *scene = dark_scene();
    struct vw_config config = skipping_config();
    struct test_run *whole = test_run(scene, &config, true, 0), *single = test_run(scene, &config, true, 1),
                    *parts = test_allocate(1, sizeof *parts);
    test_run_assert_same(whole, single);
    run_parts(scene, &config, parts);
    test_run_assert_same(whole, parts);
}

// The same params validate to the same bits with the effect, whatever is believed empty, and without it (decision 1).
TEST(validation_skips_nothing) {
    struct vw_scene *scene = dark_scene();
    struct vw_config with = skipping_config(), without = with;
    snprintf(without.effects, sizeof without.effects, "none");
    struct vw_trainer *on = test_trainer_create(scene, &with, true, 1),
                      *off = test_trainer_create(scene, &without, true, 1);
    struct test_run *run = test_run_of(on);
    float *zeros = test_allocate(VW_OCCUPANCY_CELLS, sizeof *zeros), *rendered_on, *rendered_off;
    ASSERT_OK(
        vw_buffer_write(on->field.effect_buffers[VW_SLOT_OCCUPANCY], 0, zeros, sizeof *zeros * VW_OCCUPANCY_CELLS));
    ASSERT_OK(vw_buffer_write(off->field.params, 0, run->params, 4ull * run->param_words));
    uint32_t view = on->validation.views[0],
             values = 3 * scene->views[view].image.width_px * scene->views[view].image.height_px;
    ASSERT_OK(vw_trainer_render(on, view, &rendered_on));
    ASSERT_OK(vw_trainer_render(off, view, &rendered_off));
    assert_memory_equal(rendered_on, rendered_off, sizeof *rendered_on * values);
    free(rendered_on);
    free(rendered_off);
}

// Off: no buffer and no pass; until the warm-up ends, on changes no bit either.
TEST(off_costs_nothing) {
    struct vw_scene *scene = test_scene();
    struct vw_config with = skipping_config(), without = with;
    with.epochs = without.epochs = 3;
    snprintf(without.effects, sizeof without.effects, "none");
    struct vw_trainer *off = test_trainer_create(scene, &without, true, 1);
    uint64_t bytes_off = vw_gpu_buffer_bytes(test_gpu());
    assert_null(off->field.effect_buffers[VW_SLOT_OCCUPANCY]);
    assert_null(off->step.effect_buffers[VW_SLOT_KEPT]);
    test_trainer_has_no_effects(off);
    test_release(off);
    test_trainer_create(scene, &with, true, 1);
    assert_true(vw_gpu_buffer_bytes(test_gpu()) > bytes_off + 4 * VW_OCCUPANCY_CELLS);
    struct test_run *run_on = test_run(scene, &with, true, 0), *run_off = test_run(scene, &without, true, 0);
    test_run_assert_same(run_on, run_off);
}

TEST_GROUP(NULL, test_gpu_close)
