// Which effects scenes call for: recipes whose truth is known, real photos, and what verdicts depend on.
#include "support/cmocka_test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/detection_cases.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "base/file.h"
#include "train/trainer.h"
#include "detect/decide.h"
#include "base/memory.h"

static const char scenes_folder[] = VW_SOURCE_FOLDER "/scenes";

static struct vw_scene *open_scene(const char *path) {
    struct vw_scene *scene = NULL;
    ASSERT_OK(vw_scene_open(&(struct vw_scene_params){.path = path, .gpu = test_gpu()}, &scene));
    return scene;
}

static struct vw_scene *open_recipe(const char *name) {
    char *path = vw_path_join(scenes_folder, name);
    struct vw_scene *scene = open_scene(path);
    free(path);
    return scene;
}

static void recipes_call_for_their_effects(void **state) {
    (void)state;
    detection_check(1, 1);
}

// A third of the courtyard's photos are corrupted, three of them by exposure: defects are no image formation.
static void corrupted_photos_call_for_nothing(void **state) {
    (void)state;
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    struct vw_scene *scene = open_recipe("courtyard.json");
    for (int points = 1; points >= 0; points--) { // without, the pilot run tells
        if (!points) scene->point_count = scene->track_count = 0;
        ASSERT_OK(vw_effects_decide(test_gpu(), scene, "auto", verdicts, &count));
        for (uint32_t i = 0; i < count; i++)
            assert_int_equal(verdicts[i].called_for, !strcmp(verdicts[i].name, "occupancy"));
    }
    vw_scene_close(&scene);
}

// The same scene on the same device: the same evidence, bit for bit.
static void evidence_repeats_bit_for_bit(void **state) {
    (void)state;
    struct vw_effect_verdict verdicts[2][VW_EFFECT_COUNT_MAX];
    uint32_t count;
    struct vw_scene *scene = open_recipe("clean.json");
    scene->point_count = scene->track_count = 0;
    for (int i = 0; i < 2; i++) ASSERT_OK(vw_effects_decide(test_gpu(), scene, "auto", verdicts[i], &count));
    for (uint32_t i = 0; i < count; i++) assert_true(test_same_bits(verdicts[0][i].evidence, verdicts[1][i].evidence));
    vw_scene_close(&scene);
}

// Without a device, and where --effects leaves nothing open, there is no pilot run; what only it could tell is unknown,
// and off.
static void no_pilot_run_without_a_device_or_with_none(void **state) {
    (void)state;
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    struct vw_scene *scene = open_recipe("clean.json");
    for (int i = 0; i < 2; i++) {
        ASSERT_OK(vw_effects_decide(i ? test_gpu() : NULL, scene, i ? "none" : "auto", verdicts, &count));
        assert_string_equal(verdicts[count - 1].name, "occupancy");
        assert_true(isnan(verdicts[count - 1].evidence));
        assert_false(verdicts[count - 1].called_for);
    }
    vw_scene_close(&scene);
}

// A scene that calls for nothing: `auto` and `none` are the same run, bit for bit.
static void auto_is_none_where_nothing_is_called_for(void **state) {
    (void)state;
    struct vw_scene *scene = detection_plain_scene();
    const char *const choices[] = {"auto", "none"};
    struct test_run *runs[2];
    uint8_t ids[2][VW_HASH_BYTES];
    for (int i = 0; i < 2; i++) {
        struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
        struct vw_config config = test_config();
        struct vw_trainer *trainer = NULL;
        uint32_t count;
        strcpy(config.effects, choices[i]);
        ASSERT_OK(vw_effects_decide(test_gpu(), scene, choices[i], verdicts, &count));
        ASSERT_OK(vw_trainer_create(&(struct vw_trainer_params){.gpu = test_gpu(),
                                                                .scene = scene,
                                                                .config = &config,
                                                                .effects = verdicts,
                                                                .effect_count = count,
                                                                .validate = true},
                                    &trainer));
        runs[i] = vw_allocate(1, sizeof **runs);
        test_run_finish(trainer, runs[i]);
        ASSERT_OK(vw_trainer_run_id(trainer, ids[i]));
        vw_trainer_destroy(&trainer);
    }
    assert_memory_equal(ids[0], ids[1], 32);
    test_run_assert_same(runs[0], runs[1]);
    for (int i = 0; i < 2; i++) test_run_free(runs[i]);
    vw_scene_close(&scene);
}

// With the effect off, masks are ignored; what no lens or file can give stays left out.
static void masks_are_ignored_with_the_effect_off(void **state) {
    (void)state;
    struct vw_scene *scene = test_scene();
    struct vw_view *view = &scene->views[0];
    size_t pixels = (size_t)view->image.width_px * view->image.height_px;
    view->has_mask = true;
    scene->masked_view_count = 1;
    view->mask = vw_allocate(pixels, 1);
    memset(view->mask, VW_MASK_KEEP, pixels);
    view->mask[0] = VW_MASK_HIDE;
    view->mask[1] = VW_MASK_BEYOND_LENS;
    assert_false(vw_view_keeps(view, 0, 0) || vw_view_keeps(view, 1, 0));
    assert_true(vw_view_can_use(view, 0, 0) && !vw_view_can_use(view, 1, 0));
    struct vw_config config = test_config();
    config.epochs = 1;
    config.rays = 2000; // so that the masked pixels are met
    struct test_run *obeyed = test_run(scene, &config, false, 0), *ignored, *unmasked;
    strcpy(config.effects, "-masks");
    ignored = test_run(scene, &config, false, 0);
    view->mask[0] = VW_MASK_KEEP;
    view->has_mask = false;
    scene->masked_view_count = 0;
    strcpy(config.effects, "auto");
    unmasked = test_run(scene, &config, false, 0);
    test_run_assert_same(ignored, unmasked);
    assert_int_not_equal(memcmp(obeyed->params, ignored->params, 4 * obeyed->param_words), 0);
    test_run_free(obeyed);
    test_run_free(ignored);
    test_run_free(unmasked);
    vw_scene_close(&scene);
}

// ---- Real photos, where they are ------------------------------------------------------------------------------------

struct real_scene {
    const char *name, *choice, *called_for; // effects, each between spaces
    const char *why;
};
static const struct real_scene real_scenes[] = {
    {"fox", "auto", " distortion ",
     "a phone's lens bends; a room bounds every ray; one phone in one light: gains within 3 %"},
    {"sacre_coeur", "auto", " distortion sky appearance appearance_code ",
     "eleven tourists' cameras, days and weathers, under open sky; one facade at one depth, without content far behind "
     "it"},
    {"statue_of_liberty", "auto", " distortion masks appearance appearance_code ",
     "masks leave the statue alone, which is bounded and has no sky; light and cameras differ most"},
    {"statue_of_liberty", "-masks", " distortion masks sky appearance appearance_code ",
     "without its masks a third of it is sky"},
    {"chair_synthetic", "auto", " background occupancy ",
     "a rendered chair in a transparent void: one exposure, no lens, little in the box"},
};

static uint32_t check_real(const struct real_scene *real, const char *path) {
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    uint32_t count, mistakes = 0;
    struct vw_scene *scene = open_scene(path);
    ASSERT_OK(vw_effects_decide(test_gpu(), scene, real->choice, verdicts, &count));
    print_message("%s, --effects %s: %s\n", real->name, real->choice, real->why);
    for (uint32_t i = 0; i < count; i++) {
        char *word = vw_format_text(" %s ", verdicts[i].name);
        bool expected = strstr(real->called_for, word) != NULL;
        print_message("    %-16s %-4s %.4f (%g)%s\n", verdicts[i].name, verdicts[i].called_for ? "yes" : "no",
                      verdicts[i].evidence, verdicts[i].threshold,
                      verdicts[i].called_for == expected ? "" : " MISTAKE");
        mistakes += verdicts[i].called_for != expected;
        free(word);
    }
    vw_scene_close(&scene);
    return mistakes;
}

static void real_scenes_call_for_their_effects(void **state) {
    (void)state;
    uint32_t mistakes = 0, found = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(real_scenes); i++) {
        const char *path = real_scene_path(real_scenes[i].name);
        found += path != NULL;
        if (path) mistakes += check_real(&real_scenes[i], path);
    }
    if (mistakes) fail_msg("%u verdicts are not as expected", mistakes);
    if (!found) skip();
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recipes_call_for_their_effects),
        cmocka_unit_test(corrupted_photos_call_for_nothing),
        cmocka_unit_test(evidence_repeats_bit_for_bit),
        cmocka_unit_test(no_pilot_run_without_a_device_or_with_none),
        cmocka_unit_test(auto_is_none_where_nothing_is_called_for),
        cmocka_unit_test(masks_are_ignored_with_the_effect_off),
        cmocka_unit_test(real_scenes_call_for_their_effects),
    };
    if (argc > 1) cmocka_set_test_filter(argv[1]);
    return cmocka_run_group_tests(tests, NULL, test_gpu_close);
}
