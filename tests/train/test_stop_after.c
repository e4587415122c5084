// A trainer that is held takes no step beyond, whatever its submissions hold, and its steps are those of one that was
// never held.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

// Takes steps until none is left to hand out.
static void run_to_hold(struct vw_trainer *trainer, struct test_run *run) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        test_run_keep(run, records, count);
    } while (count);
    assert_false(vw_trainer_in_flight(trainer));
}

TEST(epochs_end_where_they_are_held) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = test_config();
    struct test_run *whole = test_run(scene, &config, true, 4);
    const uint32_t sizes[] = {1, 3, 64, 0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(sizes); i++) {
        struct vw_trainer *trainer = test_trainer_create(scene, &config, true, sizes[i]);
        struct test_run *held = test_allocate(1, sizeof *held);
        assert_non_null(held);
        assert_int_equal(vw_trainer_epoch_end(trainer, 0), 5);
        for (uint64_t step = 0; step < vw_trainer_total_steps(trainer); step = held->count - 1) {
            uint64_t end = vw_trainer_epoch_end(trainer, step + 1);
            vw_trainer_stop_after(trainer, end);
            run_to_hold(trainer, held);
            assert_int_equal(held->count, end + 1); // with step 0
            assert_int_equal(end % 5, 0);
        }
        vw_trainer_stop_after(trainer, UINT64_MAX); // the run has an end of its own
        test_run_finish(trainer, held);
        test_run_assert_same(whole, held);
        test_release(held);
        test_release(trainer);
    }
}

TEST_GROUP(NULL, test_gpu_close)
