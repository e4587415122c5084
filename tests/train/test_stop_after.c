// A trainer that is held takes no step beyond, whatever its submissions hold, and its steps are those of one that was
// never held.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

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

TEST_GROUP(NULL, test_gpu_close)
