// Trainings that share their submissions: each has the bits that it has alone, and they wait at the barriers of one.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/command_list.h"
#include "gpu/pipeline.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

enum { TOGETHER = 3, STEPS_PER_SUBMISSION = 4, COUNTED_MOST = 8 };

// Differences between the trainings of a test: photos, seed and length.
struct member {
    uint32_t left_out; // the place of a photo that it is not trained on
    uint64_t seed;
    uint32_t epochs;
};
static const struct member members[TOGETHER] = {{0, 7, 3}, {2, 8, 3}, {4, 7, 1}}; // the last one ends earlier

struct group {
    struct vw_scene *scene;
    struct vw_config config;
    struct vw_submissions *submissions;
    struct vw_trainer *trainers[TOGETHER];
    struct test_run *runs[TOGETHER];
};

static struct vw_trainer *open_member(struct group *group, const struct member *member, uint32_t steps_per_submission,
                                      struct vw_submissions *submissions) {
    struct vw_config config = group->config;
    uint32_t *views = NULL, all = 0, count = 0;
    ASSERT_OK(vw_scene_list_views(group->scene, VW_SPLIT_TRAIN, &views, &all));
    for (uint32_t v = 0; v < all; v++)
        if (v != member->left_out) views[count++] = views[v];
    config.seed = member->seed;
    config.epochs = member->epochs;
    struct vw_trainer *trainer =
        test_trainer_open((struct vw_trainer_params){.gpu = test_gpu(),
                                                     .scene = group->scene,
                                                     .config = &config,
                                                     .train_views = views,
                                                     .train_view_count = count,
                                                     .validate = true,
                                                     .submissions = submissions,
                                                     .steps_per_submission = steps_per_submission});
    free(views);
    return trainer;
}

static void open_group(const char *effects, uint32_t steps_per_submission, struct group *group) {
    *group = (struct group){.scene = test_scene(), .config = test_config()};
    strcpy(group->config.effects, effects);
    group->config.consistency_weight = strstr(effects, "transient") ? 0.0 : 0.01; // for the encoder, where it is on
    group->submissions = test_submissions();
    for (uint32_t i = 0; i < TOGETHER; i++) {
        group->trainers[i] = open_member(group, &members[i], steps_per_submission, group->submissions);
        group->runs[i] = test_allocate(1, sizeof *group->runs[i]);
    }
}

// Takes one submission of a training; returns whether it had steps to hand out.
static bool take_submission(struct group *group, uint32_t index, bool collect) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    if (!group->trainers[index]) return false;
    if (collect) ASSERT_OK(vw_trainer_collect(group->trainers[index], &records, &count));
    else ASSERT_OK(vw_trainer_advance(group->trainers[index], &records, &count));
    test_run_keep(group->runs[index], records, count);
    return count > 0;
}

static bool take_round(struct group *group) {
    bool any = false;
    for (uint32_t i = 0; i < TOGETHER; i++) any |= take_submission(group, i, false);
    return any;
}

static void assert_as_alone(struct group *group, uint32_t index) {
    struct vw_trainer *alone = open_member(group, &members[index], STEPS_PER_SUBMISSION, NULL);
    struct test_run *expected = test_run_of(alone);
    test_run_finish(group->trainers[index], group->runs[index]);
    test_run_assert_same(expected, group->runs[index]);
}

TEST(bits_are_those_of_a_training_alone) {
    static const char *const effects[] = {"none", "appearance,visibility", "appearance_encoder,transient",
                                          "appearance_encoder,sky"};
    static const uint32_t submissions[] = {STEPS_PER_SUBMISSION, 0, 0, 0};
    for (size_t e = 0; e < VW_ARRAY_COUNT(effects); e++) {
        const size_t before = test_owned();
        struct group group;
        open_group(effects[e], submissions[e], &group);
        while (take_round(&group))
            ;
        for (uint32_t i = 0; i < TOGETHER; i++) assert_as_alone(&group, i);
        test_release_to(before);
    }
}

// One of them collects what it has in flight, for a checkpoint, while the others are ahead of it; one is given up with
// steps in flight; one does not advance for a while.
TEST(each_goes_its_own_way) {
    struct group group;
    open_group("none", 2, &group);
    take_round(&group);
    while (take_submission(&group, 1, true))
        ;
    assert_false(vw_trainer_in_flight(group.trainers[1]));
    take_submission(&group, 0, false);
    take_submission(&group, 0, false);
    assert_true(vw_trainer_in_flight(group.trainers[2]));
    test_release(group.trainers[2]);
    group.trainers[2] = NULL;
    while (take_round(&group))
        ;
    for (uint32_t i = 0; i < 2; i++) assert_as_alone(&group, i);
}

// Held, a training takes no step because others advance.
TEST(a_held_training_stays) {
    struct group group;
    open_group("none", STEPS_PER_SUBMISSION, &group);
    vw_trainer_stop_after(group.trainers[1], 5);
    while (take_round(&group))
        ;
    assert_int_equal(group.runs[1]->count, 1 + 5);
    assert_int_equal(group.runs[0]->count, 1 + 3 * 4);
    vw_trainer_stop_after(group.trainers[1], UINT64_MAX);
    for (uint32_t i = 0; i < TOGETHER; i++) assert_as_alone(&group, i);
}

// Counts the commands and barriers of a step in the second submission of as many trainings.
static void count_epochs(uint32_t together, double *commands, double *barriers) {
    const size_t before = test_owned();
    struct group group = {.scene = test_scene(), .config = test_config(), .submissions = test_submissions()};
    struct vw_trainer *trainers[COUNTED_MOST];
    const struct vw_step_record *records;
    uint32_t count;
    for (uint32_t i = 0; i < together; i++) {
        const struct member member = {.left_out = i % 5, .seed = i, .epochs = 10};
        trainers[i] = open_member(&group, &member, STEPS_PER_SUBMISSION, group.submissions);
    }
    ASSERT_OK(vw_trainer_advance(trainers[0], &records, &count));
    *commands = vw_submission_commands(group.submissions->submissions[1]) / (double)STEPS_PER_SUBMISSION;
    *barriers =
        vw_command_list_barriers(vw_submission_list(group.submissions->submissions[1])) / (double)STEPS_PER_SUBMISSION;
    for (uint32_t i = 0; i < together; i++) assert_true(vw_trainer_in_flight(trainers[i]));
    test_release_to(before);
}

TEST(barriers_are_those_of_one) {
    double commands_alone, barriers_alone;
    count_epochs(1, &commands_alone, &barriers_alone);
    for (uint32_t together = 1; together <= COUNTED_MOST; together *= 2) {
        double commands, barriers;
        count_epochs(together, &commands, &barriers);
        print_message("%u together: %.2f commands, %.2f barriers per step of all\n", together, commands, barriers);
        assert_float_equal(commands, together * commands_alone, 0);
        assert_float_equal(barriers, barriers_alone, 0);
    }
}

// Returns the stage of a pass in step `step`, from 0, of the second submission, whose steps have equal commands.
static uint64_t stage_of(const struct vw_command_list *list, uint32_t step, const char *pass, const char *role) {
    uint32_t per_step = (uint32_t)list->count / STEPS_PER_SUBMISSION;
    for (size_t i = 0; i < list->count; i++) {
        const struct vw_command *command = &list->commands[i];
        const char *own = command->pass->role ? command->pass->role : "";
        if ((uint32_t)i / per_step == step && !strcmp(vw_pass_name(command->pass), pass) && !strcmp(own, role))
            return command->stage;
    }
    fail_msg("no %s %s in step %u", role, pass, step);
    return 0;
}

// A step waits for no validation of the step before; nor do its own passes wait for each other in vain.
TEST(the_next_step_begins_beside_validation) {
    static const struct {
        const char *effects; // which need no photo
        uint32_t stages;
    } cases[] = {{"none", 8}, {"sky", 9}};
    for (size_t c = 0; c < VW_ARRAY_COUNT(cases); c++) {
        const size_t before = test_owned();
        struct group group = {.scene = test_scene(), .config = test_config(), .submissions = test_submissions()};
        const struct vw_step_record *records;
        uint32_t count;
        strcpy(group.config.effects, cases[c].effects);
        group.config.importance_samples = group.config.samples;
        const struct member member = {.seed = 1, .epochs = 10};
        struct vw_trainer *trainer = open_member(&group, &member, STEPS_PER_SUBMISSION, group.submissions);
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        const struct vw_command_list *list = vw_submission_list(group.submissions->submissions[1]);
        for (uint32_t step = 1; step + 1 < STEPS_PER_SUBMISSION; step++) {
            uint64_t end = stage_of(list, step, "forward_field", "even samples") + cases[c].stages;
            assert_int_equal(stage_of(list, step, "reduce_loss", ""), end);
            assert_int_equal(stage_of(list, step, "forward_field", "even samples, validation"), end);
            assert_int_equal(stage_of(list, step + 1, "forward_field", "even samples"), end);
            assert_int_equal(stage_of(list, step, "scatter_grid", ""), stage_of(list, step, "gradient_weights", ""));
        }
        test_release_to(before);
    }
}

TEST(pipelines_are_those_of_one) {
    struct group group;
    const uint32_t all = 100; // nothing is left out
    open_group("appearance_code", STEPS_PER_SUBMISSION, &group);
    uint32_t of_three = vw_gpu_pipeline_count(test_gpu());
    const struct member another = {.left_out = all, .seed = 99, .epochs = 5};
    open_member(&group, &another, 1, NULL);
    assert_int_equal(vw_gpu_pipeline_count(test_gpu()), of_three);
    group.config.learning_rate *= 2; // a sweep of it compiles nothing
    group.config.beta2 = 0.95;
    open_member(&group, &another, 1, NULL);
    assert_int_equal(vw_gpu_pipeline_count(test_gpu()), of_three);
    group.config.rays++; // is a constant
    open_member(&group, &another, 1, NULL);
    assert_true(vw_gpu_pipeline_count(test_gpu()) > of_three);
}

TEST(as_many_as_fit_are_taken_together) {
    struct vw_gpu_info device = {.kind = VW_GPU_DISCRETE, .memory_bytes = 1000};
    assert_int_equal(vw_trainers_together(&device, 100), 5);
    assert_int_equal(vw_trainers_together(&device, 900), 1);
    assert_int_equal(vw_trainers_together(&device, 1), VW_TRAINERS_TOGETHER_MAX);
    device.kind = VW_GPU_CPU;
    assert_int_equal(vw_trainers_together(&device, 1), 1);
}

TEST_GROUP(NULL, test_gpu_close)
