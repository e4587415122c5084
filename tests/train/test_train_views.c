// Inputs that a trainer is handed: its views, and verdicts on effects. It decides neither.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/trainer_fixture.h"

enum { LEFT_OUT = 1 }; // the place among the photos to train on

static void exclude(struct vw_scene *scene, uint32_t view) {
    scene->views[view].split = VW_SPLIT_EXCLUDED;
    scene->split_count[VW_SPLIT_TRAIN]--;
    scene->split_count[VW_SPLIT_EXCLUDED]++;
}

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
    exclude(smaller, views[LEFT_OUT]);
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
    ASSERT_FAILS(vw_trainer_create(&params, &trainer), VW_ERROR_USAGE, "no verdicts on effects");

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

TEST_GROUP(NULL, test_gpu_close)
