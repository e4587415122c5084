// Every field of train/fields/ through the whole trainer, with even samples, importance samples and a coarse network:
// it learns, the same run has the same bits however its steps are grouped, validation is pure, a snapshot in a file
// carries on, and what it cannot do is refused by name. What splats alone have is in renderers/test_splats_training.c.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/fields/registry.h"

// Each field, alone and with importance samples and a rate that decays; a coarse network; splats with squares of a part
// of the photo, of all of it and beyond it.
static const struct form {
    enum vw_field field;
    bool places, coarse;
    uint32_t squares, harmonics;
    double beta1, ssim_weight, share; // share: of its first loss, with which it ends; SSIM falls slowly
    const char *effects;              // splats'
} forms[] = {
    {VW_FIELD_HASH, .share = 0.6},
    {VW_FIELD_HASH, .places = true, .share = 0.7}, // fewer samples
    {VW_FIELD_MLP, .share = 0.6},
    {VW_FIELD_MLP, .places = true, .share = 0.7},
    {VW_FIELD_MLP, .places = true, .coarse = true, .share = 0.7},
    {VW_FIELD_SPLATS, .squares = 2, .harmonics = 1, .share = 0.8},
    {VW_FIELD_SPLATS, .squares = 4, .share = 0.8, .effects = "sky,appearance"},
    {VW_FIELD_SPLATS, .squares = 9, .harmonics = 3, .beta1 = 0.9, .share = 0.8, .effects = "background"},
    {VW_FIELD_SPLATS, .squares = 3, .harmonics = 1, .ssim_weight = 0.2, .share = 0.92},
    {VW_FIELD_SPLATS, .squares = 9, .harmonics = 1, .ssim_weight = 1.0, .share = 0.92, .effects = "sky,appearance"},
    {VW_FIELD_SPLATS, .squares = 3, .harmonics = 1, .ssim_weight = 0.2, .share = 0.92, .effects = "sky,uncertainty"},
};
enum { FORMS = VW_ARRAY_COUNT(forms) };

static struct vw_config config_of_form(size_t index) {
    const struct form *form = &forms[index];
    struct vw_config config = test_config_of(form->field);
    if (form->field == VW_FIELD_SPLATS) {
        config.rays = form->squares * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
        config.harmonics = form->harmonics;
        config.beta1 = form->beta1;
        config.ssim_weight = form->ssim_weight;
        strcpy(config.effects, form->effects ? form->effects : "none");
    }
    if (!form->places) return config;
    config.samples = 8;
    config.importance_samples = 12;
    config.learning_rate_decay = form->coarse ? 1.0 : 0.3;
    if (form->coarse) config.coarse_network = VW_COARSE_NETWORK_OWN;
    return config;
}

// Losses of the first few steps and of the last few; of splats two epochs, since the squares of a step differ more.
TEST_CASES(every_form_learns_whatever_its_submissions, form, FORMS) {
    bool splats = forms[form].field == VW_FIELD_SPLATS;
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of_form(form);
    config.epochs = splats ? 16 : 12;
    if (splats) config.learning_rate_decay = 1.0; // so few steps need their rates to the end
    struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7);
    double first = 0.0, last = 0.0;
    test_run_assert_same(one, many);
    for (uint32_t i = 0; i < (splats ? 10 : 2); i++) {
        first += one->records[1 + i].train_loss;
        last += one->records[one->count - 1 - i].train_loss;
    }
    if (!(last < forms[form].share * first)) fail_msg("form %zu: loss %g, at last %g", form, first, last);
    assert_int_equal(one->stats.nonfinite_steps, 0);
}

// Each part in a trainer of its own, from the checkpoint of the one before.
TEST_CASES(a_run_in_parts_is_the_run, i, 2 * FORMS) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of_form(i / 2);
    bool splats = config.field == VW_FIELD_SPLATS;
    config.burn_in_epochs = 0;
    if (splats && i % 2) return; // which have no codes
    if (!splats) {
        config.beta1 = 0.9;
        strcpy(config.effects,
               i % 2 ? "sky,appearance_encoder,transient" : "sky,appearance,appearance_code,visibility");
    }
    test_run_assert_same(test_run(scene, &config, true, 0), test_run_in_parts(scene, &config));
}

// Validates once more, after the run's end.
static void assert_validates_alike(struct vw_trainer *trainer, const struct vw_view_error expected[TEST_VALS]) {
    struct vw_submission *submission = trainer->submissions->submissions[0];
    struct vw_view_error views[TEST_VALS];
    vw_submission_begin(submission);
    vw_validation_record(&trainer->validation, submission, 0);
    test_submit(submission);
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
        struct vw_config config = config_of_form(form), other = config_of_form((form + FORMS - 1) % FORMS);
        if (!forms[form].effects) strcpy(config.effects, "sky"); // which the file has, too
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
        test_release(trainer);
        test_release(loaded);
        test_release(wrong);
    }
}

TEST_GROUP(NULL, test_gpu_close)
