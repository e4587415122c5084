// Decision 11: a run that goes on from a checkpoint leaves the rows and params of one that never stopped (with every
// field in test_fields, with effects in test_effect_promises); files that do not fit are refused and change nothing.
#include "support/cmocka_test.h"

#include "base/file.h"
#include "base/memory.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// Takes submissions until step `until` is handed out, then collects what is in flight.
static void take_some(struct vw_trainer *trainer, uint64_t until, struct test_run *run) {
    const struct vw_step_record *records;
    uint32_t count;
    while (!run->count || run->records[run->count - 1].step < until) {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        assert_true(count > 0);
        test_run_keep(run, records, count);
    }
    do {
        ASSERT_OK(vw_trainer_collect(trainer, &records, &count));
        test_run_keep(run, records, count);
    } while (count);
}

// A finished run goes on when more epochs are asked for.
FOLDER_TEST(a_finished_run_can_be_extended) {
    const char *path = temporary_path(*state, "checkpoint");
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config(), longer = config;
    longer.epochs = 2 * config.epochs;
    struct test_run *whole = test_run(scene, &longer, true, 0), *parts = test_allocate(1, sizeof *parts);
    struct vw_trainer *first = test_trainer_create(scene, &config, true, 0),
                      *second = test_trainer_create(scene, &longer, true, 0);
    uint64_t step = 0;
    test_run_finish(first, parts);
    ASSERT_OK(vw_trainer_save_checkpoint(first, path));
    ASSERT_OK(vw_trainer_load_checkpoint(second, path, UINT64_MAX, &step));
    test_run_finish(second, parts);
    test_run_assert_same(whole, parts);
}

static void assert_refused(struct vw_trainer *trainer, const char *path, uint64_t last_step, const char *words) {
    uint64_t step = 7;
    assert_int_equal(vw_trainer_load_checkpoint(trainer, path, last_step, &step), VW_ERROR_INPUT);
    assert_int_equal(step, 7);
    if (!strstr(vw_error_message(), words)) fail_msg("\"%s\" does not say \"%s\"", vw_error_message(), words);
}

FOLDER_TEST(what_does_not_fit_is_refused) {
    const char *path = temporary_path(*state, "checkpoint"), *corrupted = temporary_path(*state, "corrupted");
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config(), other = config;
    other.seed = 1;
    struct test_run *whole = test_run(scene, &config, true, 0), *taken = test_allocate(1, sizeof *taken);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    assert_int_equal(vw_trainer_save_checkpoint(trainer, path), VW_ERROR_USAGE); // nothing to keep yet
    take_some(trainer, 5, taken);
    ASSERT_OK(vw_trainer_save_checkpoint(trainer, path));

    struct vw_trainer *stranger = test_trainer_create(scene, &other, true, 1);
    assert_refused(stranger, path, UINT64_MAX, "another run");

    trainer = test_trainer_create(scene, &config, true, 1);
    assert_refused(trainer, temporary_path(*state, "none"), UINT64_MAX, "no such file");
    uint64_t step = 7;
    assert_int_equal(vw_trainer_load_checkpoint(trainer, path, 4, &step), VW_ERROR_USAGE);
    assert_int_equal(step, 7);
    void *bytes = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read(path, 1 << 30, &bytes, &size_bytes));
    for (size_t cut = 0; cut < size_bytes; cut += 1 + size_bytes / 60) { // cut short
        ASSERT_OK(vw_file_write(corrupted, bytes, cut));
        assert_refused(trainer, corrupted, UINT64_MAX, cut < 64 ? "remove the file" : "damaged");
    }
    for (size_t at = 30; at < size_bytes; at += 1 + size_bytes / 60) { // one bit flipped
        ((uint8_t *)bytes)[at] ^= 1;
        ASSERT_OK(vw_file_write(corrupted, bytes, size_bytes));
        assert_refused(trainer, corrupted, UINT64_MAX, "damaged");
        ((uint8_t *)bytes)[at] ^= 1;
    }
    struct test_run *after = test_run_of(trainer); // untouched by what was refused
    test_run_assert_same(whole, after);
    free(bytes);
}

TEST_GROUP(NULL, test_gpu_close)
