#include "support/trainer_fixture.h"

#include "support/cmocka_test.h"

#include "base/memory.h"
#include "detect/decide.h"
#include "gpu/compute.h"
#include "support/plain_config.h"
#include "support/temporary_folder.h"
#include "train/renderers/volume/volume.h"
#include "train/trainer.h"

struct vw_config test_config(void) {
    struct vw_config config = plain_config();
    config.epochs = 3;
    config.rays = 60;
    config.samples = 16;
    config.val_rays = 120;
    config.levels = 4;
    config.log2_table = 10;
    config.width = 16;
    return config;
}

static struct vw_config config_of_splats(void) {
    struct vw_config config = vw_config_of_field(VW_FIELD_SPLATS);
    config.epochs = 3;
    config.rays = 2 * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
    config.val_rays = TEST_VALS * 256;
    config.splats = 300;
    config.ssim_weight = 0.0;
    return config;
}

struct vw_config test_config_of(enum vw_field field) {
    if (field == VW_FIELD_SPLATS) return config_of_splats();
    struct vw_config config = test_config();
    config.field = field;
    if (field == VW_FIELD_HASH) return config;
    config.levels = vw_config_default.levels; // which are the hash grid's
    config.log2_table = vw_config_default.log2_table;
    config.mlp_depth = 6; // with a skip
    config.frequencies = 4;
    config.learning_rate = 1e-3;
    return config;
}

struct vw_config test_config_with(const char *effects) {
    struct vw_config config = test_config();
    strcpy(config.effects, effects);
    return config;
}

struct vw_scene *test_scene(void) {
    return synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 5, .val_views = TEST_VALS, .width_px = 24, .height_px = 18});
}

void test_exclude(struct vw_scene *scene, uint32_t view) {
    scene->views[view].split = VW_SPLIT_EXCLUDED;
    scene->split_count[VW_SPLIT_TRAIN]--;
    scene->split_count[VW_SPLIT_EXCLUDED]++;
}

void test_hide_some(struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count; v++) {
        uint32_t hidden = v == 4 ? 24 : 5 + v; // columns
        scene->views[v].mask = vw_allocate(24 * 18, 1);
        assert_non_null(scene->views[v].mask);
        for (uint32_t i = 0; i < 24 * 18; i++) scene->views[v].mask[i] = i % 24 < hidden ? VW_MASK_HIDE : VW_MASK_KEEP;
        scene->views[v].has_mask = true;
    }
    scene->masked_view_count = scene->view_count;
}

static void destroy_trainer(void *trainer) { vw_trainer_destroy(&(struct vw_trainer *){trainer}); }

enum vw_status test_trainer_try(struct vw_trainer_params params, struct vw_trainer **trainer) {
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    enum vw_status status = VW_OK;
    if (!params.effects)
        status = vw_effects_find_facts(params.scene, params.config->effects, effects, &params.effect_count);
    if (!params.effects) params.effects = effects;
    if (!params.gpu) params.gpu = test_gpu();
    if (!status) status = vw_trainer_create(&params, trainer);
    if (!status) test_own(*trainer, destroy_trainer);
    return status;
}

struct vw_trainer *test_trainer_open(struct vw_trainer_params params) {
    struct vw_trainer *trainer = NULL;
    ASSERT_OK(test_trainer_try(params, &trainer));
    return trainer;
}

struct vw_trainer *test_trainer_create(const struct vw_scene *scene, const struct vw_config *config, bool validate,
                                       uint32_t steps_per_submission) {
    return test_trainer_open((struct vw_trainer_params){
        .scene = scene, .config = config, .validate = validate, .steps_per_submission = steps_per_submission});
}

void test_run_keep(struct test_run *run, const struct vw_step_record *records, uint32_t count) {
    assert_true(run->count + count <= TEST_STEPS_MAX);
    for (uint32_t i = 0; i < count; i++) {
        struct vw_step_record *kept = &run->records[run->count];
        *kept = records[i];
        for (uint32_t v = 0; kept->views && v < kept->view_count && v < TEST_VALS; v++)
            run->views[run->count][v] = kept->views[v];
        kept->views = NULL;
        run->count++;
    }
}

void test_run_advance(struct vw_trainer *trainer, struct test_run *run) {
    const struct vw_step_record *records;
    uint32_t count;
    do {
        ASSERT_OK(vw_trainer_advance(trainer, &records, &count));
        test_run_keep(run, records, count);
    } while (count);
}

void test_run_finish(struct vw_trainer *trainer, struct test_run *run) {
    test_run_advance(trainer, run);
    run->param_words = (uint32_t)(trainer->model.param_bytes / 4);
    run->params = test_allocate(run->param_words, 4);
    ASSERT_OK(vw_buffer_read(trainer->field.params, 0, run->params, trainer->model.param_bytes));
    vw_trainer_get_stats(trainer, &run->stats);
}

struct test_run *test_run_of(struct vw_trainer *trainer) {
    struct test_run *run = test_allocate(1, sizeof *run);
    test_run_finish(trainer, run);
    return run;
}

struct test_run *test_run(const struct vw_scene *scene, const struct vw_config *config, bool validate,
                          uint32_t steps_per_submission) {
    struct vw_trainer *trainer = test_trainer_create(scene, config, validate, steps_per_submission);
    struct test_run *run = test_run_of(trainer);
    test_release(trainer);
    return run;
}

struct test_run *test_run_in_parts(const struct vw_scene *scene, const struct vw_config *config) {
    char *folder = temporary_folder_create();
    const char *path = temporary_path(folder, "checkpoint");
    struct test_run *parts = test_allocate(1, sizeof *parts);
    struct vw_trainer *first = test_trainer_create(scene, config, true, 3),
                      *second = test_trainer_create(scene, config, true, 3);
    uint64_t step;
    vw_trainer_stop_after(first, 2 * config->epochs);
    test_run_advance(first, parts);
    ASSERT_OK(vw_trainer_save_checkpoint(first, path));
    ASSERT_OK(vw_trainer_load_checkpoint(second, path, UINT64_MAX, &step));
    test_run_finish(second, parts);
    test_release(first);
    test_release(second);
    temporary_folder_remove(folder);
    return parts;
}

bool test_same_bits(double a, double b) { return !memcmp(&a, &b, sizeof a); }

void test_run_assert_same(const struct test_run *a, const struct test_run *b) {
    assert_int_equal(a->count, b->count);
    for (uint32_t i = 0; i < a->count; i++) {
        const struct vw_step_record *x = &a->records[i], *y = &b->records[i];
        if (x->step != y->step || x->epoch != y->epoch || x->view != y->view ||
            !test_same_bits(x->train_loss, y->train_loss) || !test_same_bits(x->val_psnr, y->val_psnr) ||
            !test_same_bits(x->val_l1, y->val_l1) || memcmp(a->views[i], b->views[i], sizeof a->views[i]))
            fail_msg("row %u differs: step %llu, val_psnr %.17g and %.17g, train_loss %.17g and %.17g", i,
                     (unsigned long long)x->step, x->val_psnr, y->val_psnr, x->train_loss, y->train_loss);
    }
    assert_int_equal(a->param_words, b->param_words);
    assert_memory_equal(a->params, b->params, 4 * a->param_words);
}

static void destroy_submissions(void *submissions) { vw_submissions_destroy(&(struct vw_submissions *){submissions}); }

struct vw_submissions *test_submissions(void) {
    struct vw_submissions *submissions = NULL;
    ASSERT_OK(vw_submissions_create(test_gpu(), &submissions));
    return test_own(submissions, destroy_submissions);
}
