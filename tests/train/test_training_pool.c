// A pool of trainings: who has a seat, who waits, and what a failure ends. The trainings are made up; those of trainers
// are in tests/run/test_runs_together.c and tests/experiment/test_retrain.c.
// label: host
#include "support/cmocka_test.h"

#include "support/trainer_fixture.h"
#include "train/training_pool.h"

enum { TRAININGS = 6, DEVICES = 2, TURNS = 3 };

// Training 1 has nothing to train, training 4 waits for training 2, and `failing` fails in its second turn.
struct made_up {
    uint32_t turns[TRAININGS], devices[TRAININGS], failing;
    bool seated[TRAININGS], ended[TRAININGS];
    uint32_t busy, most, next;
};

static enum vw_status begin(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct made_up *made_up = context;
    if (seat->place == 1) *answer = VW_POOL_NO_SEAT;
    if (seat->place == 4 && !made_up->ended[2]) *answer = VW_POOL_WAITS;
    if (*answer == VW_POOL_WAITS) return VW_OK;
    assert_int_equal(seat->place, made_up->next++);
    if (*answer == VW_POOL_NO_SEAT) return VW_OK;
    made_up->seated[seat->place] = true;
    made_up->devices[seat->place] = seat->device;
    if (++made_up->busy > made_up->most) made_up->most = made_up->busy;
    return VW_OK;
}

static enum vw_status advance(void *context, const struct vw_pool_seat *seat, bool *ended) {
    struct made_up *made_up = context;
    *ended = ++made_up->turns[seat->place] == TURNS;
    if (seat->place != made_up->failing || made_up->turns[seat->place] != 2) return VW_OK;
    return vw_fail(VW_ERROR_IO, "training %u fails", seat->place);
}

static enum vw_status end(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    struct made_up *made_up = context;
    made_up->ended[seat->place] = true;
    made_up->busy--;
    assert_true(seat->wall_s > 0);
    return status;
}

static enum vw_status run(struct made_up *made_up) {
    struct vw_training_device devices[DEVICES];
    for (int d = 0; d < DEVICES; d++) {
        devices[d].gpu = test_gpu();
        ASSERT_OK(vw_submissions_create(devices[d].gpu, &devices[d].submissions));
    }
    enum vw_status status = vw_training_pool_run(&(struct vw_training_pool){.devices = devices,
                                                                            .device_count = DEVICES,
                                                                            .together = 1,
                                                                            .begin = begin,
                                                                            .advance = advance,
                                                                            .end = end,
                                                                            .context = made_up},
                                                 TRAININGS);
    for (int d = 0; d < DEVICES; d++) vw_submissions_destroy(&devices[d].submissions);
    assert_int_equal(made_up->busy, 0);
    return status;
}

TEST(each_takes_its_turns_on_a_device_in_order) {
    struct made_up made_up = {.failing = TRAININGS};
    ASSERT_OK(run(&made_up));
    assert_int_equal(made_up.most, DEVICES);
    assert_int_equal(made_up.next, TRAININGS);
    for (uint32_t i = 0; i < TRAININGS; i++) assert_int_equal(made_up.turns[i], i == 1 ? 0 : TURNS);
    assert_int_not_equal(made_up.devices[0], made_up.devices[2]); // side by side
}

TEST(after_a_failure_none_begins_and_the_others_end) {
    struct made_up made_up = {.failing = 0};
    ASSERT_FAILS(run(&made_up), VW_ERROR_IO, "training 0 fails");
    assert_true(made_up.ended[0] && made_up.ended[2] && made_up.turns[2] == TURNS);
    assert_false(made_up.seated[3] || made_up.seated[5]);
}

TEST_GROUP(NULL, test_gpu_close)
