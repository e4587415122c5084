// Draws that a seed varies (decision 12): order, pixels and initialisation, each alone or all together.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

enum { BASE_SEED = 5 };
static const uint64_t OTHER_SEED = INT64_MAX; // the largest allowed

// The part of a run that each kind of draws decides.
struct drawn_step {
    struct test_run *run;
    struct vw_pixel pixels[64];  // pixels of the first step
    uint64_t jitter_seed;        // seed that shaders draw from
    uint32_t order[3 * 5];       // photo by step
    struct vw_view_error *views; // errors of the untrained field
};

static struct vw_config varying(enum vw_vary vary, uint64_t seed) {
    struct vw_config config = test_config();
    config.vary = vary;
    config.seed = seed;
    config.base_seed = vary == VW_VARY_ALL || vary == VW_VARY_ALL_VALIDATION ? 0 : BASE_SEED;
    return config;
}

static void draw(const struct vw_scene *scene, const struct vw_config *config, struct drawn_step *drawn) {
    *drawn = (struct drawn_step){0};
    struct vw_trainer *trainer = test_trainer_create(scene, config, true, 64); // all steps in one submission
    drawn->jitter_seed = trainer->model.seed;
    drawn->run = test_run_of(trainer);
    ASSERT_OK(vw_buffer_read(trainer->pixels, 0, drawn->pixels, config->rays * sizeof *drawn->pixels));
    drawn->views = drawn->run->views[0];
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(drawn->order); i++) drawn->order[i] = drawn->run->records[1 + i].view;
}

// Returns whether two steps look at the same places in their photos, whichever photos these are.
static bool same_places(const struct drawn_step *a, const struct drawn_step *b) {
    for (uint32_t i = 0; i < test_config().rays; i++)
        if (a->pixels[i].x_px != b->pixels[i].x_px || a->pixels[i].y_px != b->pixels[i].y_px) return false;
    return true;
}

static bool same_start(const struct drawn_step *a, const struct drawn_step *b) {
    return !memcmp(a->views, b->views, TEST_VALS * sizeof *a->views) &&
           test_same_bits(a->run->records[0].val_psnr, b->run->records[0].val_psnr);
}

// With other pixels of validation the training stays, or is that of the seed alone.
TEST(a_seed_varies_what_it_is_told_to) {
    static const struct {
        enum vw_vary vary;
        bool order, pixels, start, params; // which of them stay
    } forms[] = {
        {VW_VARY_ALL, false, false, false, false},     {VW_VARY_ORDER, false, true, true, false},
        {VW_VARY_PIXELS, true, false, true, false},    {VW_VARY_INIT, true, true, false, false},
        {VW_VARY_VALIDATION, true, true, false, true}, {VW_VARY_ALL_VALIDATION, false, false, false, false},
    };
    struct vw_scene *scene = test_scene();
    struct drawn_step base, other, all = {0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(forms); i++) {
        struct vw_config config = varying(forms[i].vary, BASE_SEED);
        draw(scene, &config, &base);
        config.seed = OTHER_SEED;
        draw(scene, &config, &other);
        print_message("vary %s\n", vw_vary_name(forms[i].vary));
        if (forms[i].vary == VW_VARY_ALL) all = other;
        assert_int_equal(!memcmp(base.order, other.order, sizeof base.order), forms[i].order);
        assert_int_equal(same_places(&base, &other), forms[i].pixels);
        assert_int_equal(base.jitter_seed == other.jitter_seed, forms[i].pixels);
        assert_int_equal(same_start(&base, &other), forms[i].start);
        assert_int_equal(!memcmp(base.run->params, other.run->params, 4 * base.run->param_words), forms[i].params);
    }
    assert_memory_equal(all.run->params, other.run->params, 4 * other.run->param_words); // seen on other pixels
    assert_false(same_start(&all, &other));
}

// At the base seed all forms take the same run: that of the seed alone, as it was before there was a choice.
TEST(at_the_base_seed_all_forms_agree) {
    struct vw_scene *scene = test_scene();
    struct vw_config plain = test_config();
    plain.seed = BASE_SEED;
    struct test_run *run = test_run(scene, &plain, true, 4);
    for (enum vw_vary vary = VW_VARY_ORDER; vary <= VW_VARY_INIT; vary++) {
        struct vw_config config = varying(vary, BASE_SEED);
        test_run_assert_same(run, test_run(scene, &config, true, 4));
    }
}

TEST_GROUP(NULL, test_gpu_close)
