// Every field of train/fields/ through the whole trainer, with even samples, importance samples and a coarse network:
// it learns, the same run has the same bits however its steps are grouped, validation is pure, a snapshot in a file
// carries on, and what it cannot do is refused by name. Splats are in renderers/test_splats_training.c.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/fields/registry.h"

// Each field of the registry, alone and with importance samples and a rate that decays; at last one with a coarse
// network.
enum { FORMS = 2 * VW_FIELD_SPLATS + 1 };

static struct vw_config config_of_form(size_t form) {
    bool coarse = form == FORMS - 1;
    struct vw_config config = test_config_of(coarse ? VW_FIELD_MLP : (enum vw_field)(form / 2));
    if (form % 2 == 0 && !coarse) return config;
    config.samples = 8;
    config.importance_samples = 12;
    config.learning_rate_decay = coarse ? 1.0 : 0.3;
    if (coarse) config.coarse_network = VW_COARSE_NETWORK_OWN;
    return config;
}

TEST_CASES(every_form_learns_whatever_its_submissions, form, FORMS) {
    struct vw_config config = config_of_form(form);
    config.epochs = 12;
    test_run_assert_learns(test_scene(), &config, config.importance_samples ? 0.7 : 0.6); // fewer samples
}

// Each part in a trainer of its own, from the checkpoint of the one before.
TEST_CASES(a_run_in_parts_is_the_run, i, 2 * FORMS) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of_form(i / 2);
    config.beta1 = 0.9;
    config.burn_in_epochs = 0;
    strcpy(config.effects, i % 2 ? "sky,appearance_encoder,transient" : "sky,appearance,appearance_code,visibility");
    test_run_assert_same(test_run(scene, &config, true, 0), test_run_in_parts(scene, &config));
}

// Validates once more, after the run's end.
static void assert_validates_alike(struct vw_trainer *trainer, const struct vw_view_error expected[TEST_VALS]) {
    struct vw_submission *submission = trainer->submissions->submissions[0];
    struct vw_view_error views[TEST_VALS];
    vw_submission_begin(submission);
    vw_validation_record(&trainer->validation, submission, 0);
    ASSERT_OK(vw_submission_submit(submission));
    ASSERT_OK(vw_submission_wait(submission));
    vw_validation_read(&trainer->validation, vw_buffer_map(trainer->scalars), views);
    assert_memory_equal(views, expected, sizeof views);
}

static float *render(struct vw_trainer *trainer) {
    float *rgb = NULL;
    ASSERT_OK(vw_trainer_render(trainer, 0, &rgb));
    return test_own(rgb, free);
}

// Decision 1: validation changes nothing (training without it reaches the same params), and it is a function of the
// params alone: taken again around the rendering of a view it gives the same bits.
TEST_CASES(validation_is_pure, form, FORMS) {
    struct vw_scene *scene = test_scene();
    const struct vw_config config = config_of_form(form);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 4);
    struct test_run *with = test_run_of(trainer), *without = test_run(scene, &config, false, 4);
    assert_memory_equal(with->params, without->params, 4 * with->param_words);
    for (uint32_t i = 0; i < without->count; i++) {
        assert_false(without->records[i].validated);
        assert_true(i == 0 || test_same_bits(with->records[i].train_loss, without->records[i].train_loss));
    }
    assert_validates_alike(trainer, with->views[with->count - 1]);
    render(trainer);
    assert_validates_alike(trainer, with->views[with->count - 1]);
}

FOLDER_TEST(a_saved_field_is_the_trained_one) {
    const char *path = temporary_path(*state, "field.vwf");
    struct vw_scene *scene = test_scene();
    const struct vw_image *image = &scene->views[0].image;
    for (size_t form = 0; form < FORMS; form++) {
        const struct vw_config config = config_of_form(form), other = config_of_form((form + FORMS - 1) % FORMS);
        struct vw_trainer *trainer = test_trainer_create(scene, &config, false, 0),
                          *loaded = test_trainer_create(scene, &config, false, 0),
                          *wrong = test_trainer_create(scene, &other, false, 0);
        struct test_run *run = test_run_of(trainer);
        ASSERT_OK(vw_trainer_save_field(trainer, path));
        ASSERT_OK(vw_trainer_load_field(loaded, path));
        ASSERT_FAILS(vw_trainer_load_field(wrong, path), VW_ERROR_INPUT, "field.vwf");
        uint32_t *params = test_allocate(run->param_words, 4);
        ASSERT_OK(vw_buffer_read(loaded->field.params, 0, params, 4 * run->param_words));
        assert_memory_equal(params, run->params, 4 * run->param_words);
        assert_memory_equal(render(trainer), render(loaded), 3 * sizeof(float) * image->width_px * image->height_px);
    }
}

TEST_GROUP(NULL, test_gpu_close)
