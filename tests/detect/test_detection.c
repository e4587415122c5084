// Effects that scenes call for: recipes whose truth is known, real photos, and what decisions depend on.
#include "support/cmocka_test.h"

#include <jansson.h>

#include "base/file.h"
#include "base/memory.h"
#include "detect/decide.h"
#include "detect/effects_text.h"
#include "detect/pilots.h"
#include "support/detection_cases.h"
#include "support/exposed_scene.h"
#include "support/plain_config.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/trainer.h"

static const char scenes_folder[] = VW_SOURCE_FOLDER "/scenes";

static struct vw_scene *open_scene(const char *path) { return test_scene_open((struct vw_scene_params){.path = path}); }

static struct vw_scene *open_recipe(const char *name) { return open_scene(temporary_path(scenes_folder, name)); }

static struct vw_config small_config(void) {
    struct vw_config config = plain_config();
    config.levels = 4;
    config.growth = 1.8;
    config.width = 16;
    config.samples = 16;
    config.rays = 48;
    config.pilot_steps = 96;
    return config;
}

static struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
static uint32_t count;

static void decide(const struct vw_scene *scene, const struct vw_config *config) {
    ASSERT_OK(vw_effects_decide(test_gpu(), scene, config, decisions, &count));
}

static const struct vw_effect_decision *decision_on(const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(decisions[i].name, name)) return &decisions[i];
    fail_msg("no effect %s", name);
    return NULL;
}

TEST(recipes_show_their_facts) { detection_check(1, 1, false); }

TEST(a_line_names_effects_with_their_reasons) {
    struct vw_effect_decision named[] = {
        {.name = "distortion", .evidence_stderr = NAN, .called_for = true, .on = true},
        {.name = "masks", .evidence_stderr = NAN, .called_for = true},
        {.name = "sky", .evidence = 1.74, .evidence_stderr = 0.27},
        {.name = "unbounded", .evidence = 2.24, .evidence_stderr = 0.3, .called_for = true, .on = true},
        {.name = "visibility", .evidence_stderr = NAN, .on = true},
        {.name = "pose", .evidence_stderr = NAN}};
    char line[VW_EFFECT_LINE_BYTES];
    vw_effects_to_line(named, VW_ARRAY_COUNT(named), line);
    assert_string_equal(
        line,
        "distortion (files), unbounded (+2.2 dB), visibility (--effects); called for, but off: masks; tried: sky");
    vw_effects_to_line(named + 5, 1, line);
    assert_string_equal(line, "none");
}

// Without points, too: pilots need none. The search is greedy: what gains beside nothing is told beside what was
// chosen.
TEST(a_bright_sky_is_measured) {
    struct vw_config config = small_config();
    struct vw_scene *scene = detection_sky_scene();
    scene_forget_points(scene);
    strcpy(config.effects, "-unbounded,-appearance");
    decide(scene, &config);
    const struct vw_effect_decision *sky = decision_on("sky");
    assert_true(sky->called_for && sky->on);
    assert_true(sky->evidence_low >= sky->threshold && sky->evidence > sky->evidence_low);
    assert_true(sky->evidence_stderr > 0 && isfinite(sky->ms_per_step));
    assert_non_null(
        strstr(sky->measured_on,
               "2 x 96 steps of 48 rays on 18 train photos, scored on 8 of them held out; beside no effect"));
    assert_true(isnan(decision_on("unbounded")->evidence));
    const struct vw_effect_decision *visibility = decision_on("visibility");
    assert_true(isnan(visibility->evidence) && !visibility->on); // nobody asked for it
}

// If no further effect surely gains, those that seem to are tried once more, with twice the steps.
TEST(doubts_take_longer_pilots) {
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    decide(open_recipe("table.json"), &config);
    assert_non_null(strstr(decision_on("sky")->measured_on, "2 x 256 steps"));
    assert_non_null(strstr(decision_on("unbounded")->measured_on, "2 x 512 steps"));
}

// Decides effects of the scene with a sky by pilots of so many steps.
static void decide_in(uint32_t steps, const char *effects) {
    struct vw_config config = small_config();
    config.pilot_steps = steps;
    strcpy(config.effects, effects);
    struct vw_scene *scene = detection_sky_scene();
    scene_forget_points(scene); // which would tell of appearance
    decide(scene, &config);
}

// The shortest trainings show that a sky gains most. Unbounded takes its place once it is not surely worse.
TEST(unbounded_replaces_a_sky) {
    for (int longer = 0; longer < 2; longer++) {
        decide_in(longer ? 23 : 16, "-appearance");
        const struct vw_effect_decision *sky = decision_on("sky"), *unbounded = decision_on("unbounded");
        assert_true(sky->evidence_low >= sky->threshold && unbounded->evidence_low < unbounded->threshold);
        assert_non_null(strstr(unbounded->measured_on, "beside sky, taken unless surely worse"));
        assert_int_equal(sky->on, !longer);
        assert_int_equal(unbounded->on, longer);
        assert_int_equal(strstr(sky->measured_on, "; unbounded was taken instead") != NULL, longer);
    }
}

// A sky is hidden where unbounded is on, and not measured.
TEST(a_hidden_sky_goes) {
    decide_in(8, "+unbounded,-appearance");
    const struct vw_effect_decision *sky = decision_on("sky");
    assert_true(isnan(sky->evidence) && !sky->on);
}

// Pilots leave out what a run with pose refuses: no other effect would have to be named beside it.
TEST(pose_is_beside_what_pilots_call_for) {
    decide_in(8, "+pose,-appearance");
    const struct vw_effect_decision *unbounded = decision_on("unbounded");
    assert_true(decision_on("pose")->on);
    assert_true(isnan(unbounded->evidence) && !unbounded->on);
    assert_true(isfinite(decision_on("sky")->evidence));
}

// Pilots do not try what a run switches off beside an effect that is named: they could measure no gain.
TEST(what_goes_off_beside_a_named_effect_is_not_tried) {
    decide_in(8, "+appearance_encoder,-sky,-unbounded,-wide_box");
    const struct vw_effect_decision *not_tried = decision_on("appearance"); // the only one left
    assert_true(isnan(not_tried->evidence) && !not_tried->on);
}

// ---- By points ------------------------------------------------------------------------------------------------------

// The points tell that photos differ in exposure, and how much they gain by it; nothing else is needed, and a choice
// that names the effect needs not even them.
TEST(exposures_are_told_by_points) {
    static const struct {
        const char *recipe, *effects;
        double least_db, most_db; // evidence
    } cases[] = {{"exposure.json", "auto", 4.0, 6.0},
                 {"exposure.json", "-sky", 4.0, 6.0},
                 {"exposure.json", "+appearance", NAN, NAN},
                 {"exposure.json", "none", NAN, NAN},
                 {"clean.json", "auto", 0.0, 0.02},
                 {"corner.json", "auto", 4.0, 6.0}}; // one photo alone is darker, and one brighter
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        ASSERT_OK(vw_effects_find_facts(open_recipe(cases[i].recipe), cases[i].effects, decisions, &count));
        const struct vw_effect_decision *appearance = decision_on("appearance");
        if (isnan(cases[i].least_db)) {
            assert_true(isnan(appearance->evidence) && !appearance->called_for);
            continue;
        }
        if (!(appearance->evidence >= cases[i].least_db && appearance->evidence <= cases[i].most_db))
            fail_msg("%s: %g dB", cases[i].recipe, appearance->evidence);
        assert_int_equal(appearance->called_for, cases[i].least_db > 0);
        assert_int_equal(appearance->on, cases[i].least_db > 0);
        assert_true(appearance->evidence_low <= appearance->evidence);
        assert_non_null(strstr(appearance->measured_on, "exposures, at 22 dB, by "));
    }
}

// The gain is that of the mean reduction over photos, at an error of 22 dB; observations are independent.
TEST(the_gain_by_exposures_is_that_of_errors) {
    const struct vw_scene *scene = exposed_scene((struct exposed_scene_params){.gains = 0.3, .noise = 0.02});
    const struct vw_exposure *exposures;
    struct vw_photometric_evidence evidence;
    double mean = 0, variance = 0, level = pow(10, -2.2);
    ASSERT_OK(vw_scene_estimate_exposures(scene, &exposures));
    ASSERT_OK(vw_photometric_measure(scene, &evidence));
    for (uint32_t v = 0; v < EXPOSED_TRAINS; v++) {
        mean += (exposures[v].error_without - exposures[v].error_with) / EXPOSED_TRAINS;
        variance += pow(exposures[v].reduction_stderr / EXPOSED_TRAINS, 2);
    }
    assert_int_equal(evidence.photo_count, EXPOSED_TRAINS);
    assert_int_equal(evidence.observation_count, EXPOSED_TRAINS * EXPOSED_POINTS);
    assert_near(evidence.gain_db, 10 * log10((level + mean) / level), 1e-9);
    assert_near(evidence.low_db, 10 * log10((level + mean - 1.645 * sqrt(variance)) / level), 1e-9);
    assert_true(evidence.gain_db > 0.1 && evidence.stderr_db > 0.001);
}

// Without points, a gain and a bias fitted to one half of a photo held out tell of the other half whether photos differ
// in exposure.
FOLDER_TEST(photos_held_out_tell_exposures) {
    static const struct {
        const char *recipe, *effects;
        bool exposed;
    } cases[] = {{"tower.json", "+sky,-unbounded,-wide_box", true},
                 {"clean.json", "-sky,-unbounded,-wide_box", false},
                 {"cutout.json", "-sky,-unbounded,-wide_box", true}};
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    config.pilot_steps = 256;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        strcpy(config.effects, cases[i].effects);
        json_t *recipe = json_load_file(temporary_path(scenes_folder, cases[i].recipe), 0, NULL);
        const char *path = temporary_path(*state, cases[i].recipe);
        if (cases[i].exposed)
            json_object_set_new(recipe, "exposure", json_pack("{s:f,s:f}", "gain", 0.5, "tint", 0.05));
        json_object_set_new(recipe, "points", json_string("none"));
        assert_int_equal(json_dump_file(recipe, path, 0), 0);
        json_decref(recipe);
        decide(open_scene(path), &config);
        const struct vw_effect_decision *appearance = decision_on("appearance");
        if ((appearance->evidence_low >= 0.1) != cases[i].exposed)
            fail_msg("%s: a bound of %g dB", cases[i].recipe, appearance->evidence_low);
        assert_int_equal(appearance->called_for, cases[i].exposed);
    }
}

// Points that fill the box and the photos rule out what lies beyond. Each of the three shares alone leaves it open.
TEST(points_rule_out_what_lies_beyond) {
    static const struct {
        const char *recipe;
        bool ruled_out;
    } cases[] = {{"clean.json", true},
                 {"corner.json", true},
                 {"sky.json", false},        // photos without points
                 {"unbounded.json", false}}; // observations outside, and an inner region that is small
    struct vw_config config = small_config();
    config.pilot_steps = 8;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_scene *scene = open_recipe(cases[i].recipe);
        struct vw_point_evidence points;
        ASSERT_OK(vw_point_evidence_find(scene, &points));
        assert_true(points.known);
        decide(scene, &config);
        const struct vw_effect_decision *unbounded = decision_on("unbounded");
        assert_int_equal(isnan(unbounded->evidence), cases[i].ruled_out);
        assert_int_equal(strncmp(unbounded->measured_on, "ruled out: ", 11) == 0, cases[i].ruled_out);
        assert_false(cases[i].ruled_out && unbounded->called_for);
        scene->point_count = 63; // too few to tell
        ASSERT_OK(vw_point_evidence_find(scene, &points));
        assert_false(points.known);
    }
}

// Counts cells by hand: a photo of 8 x 8 cells with points in its left half and one in its lower right corner.
TEST(bare_cells_are_counted) {
    struct vw_scene *scene = test_scene();
    struct vw_point_evidence points;
    enum { POINTS = 64 };
    uint32_t train = scene->split_count[VW_SPLIT_TRAIN], width_px = scene->views[0].camera.width_px,
             height_px = scene->views[0].camera.height_px;
    scene->points = vw_allocate(POINTS, sizeof *scene->points);
    scene->tracks = vw_allocate(POINTS, sizeof *scene->tracks);
    scene->point_count = scene->track_count = POINTS;
    for (uint32_t p = 0; p < POINTS; p++) {
        scene->points[p] = (struct vw_point){.first_track = p, .track_count = 1};
        if (p % 4 == 3) scene->points[p].position_world[0] = 2.0 * scene->box.half_extent_world;
        scene->tracks[p] = (struct vw_track){.view = 0,
                                             .x_px = (float)(p % 4 + 0.5f) / 8.0f * (float)width_px,
                                             .y_px = (float)(p / 8 + 0.5f) / 8.0f * (float)height_px};
    }
    scene->tracks[POINTS - 1].x_px = (float)width_px - 0.5f;
    scene->tracks[POINTS - 1].y_px = (float)height_px - 0.5f;
    ASSERT_OK(vw_point_evidence_find(scene, &points));
    // Bare in view 0: columns 5 to 7 of eight rows, without the corner and its three neighbours; all of the others.
    double bare = (3.0 * 8 - 4) / 64.0 + (train - 1.0);
    assert_true(fabs(points.bare_share - bare / train) < 1e-12);
    assert_true(fabs(points.outside_share - 0.25) < 1e-12);
}

// Two searches have equal bits, whatever the seed of the run; a block that fills the box calls for nothing.
TEST(decisions_repeat_bit_for_bit) {
    struct vw_effect_decision both[2][VW_EFFECT_COUNT_MAX];
    struct vw_scene *scene = detection_plain_scene();
    struct vw_config config = small_config();
    config.pilot_steps = 32;
    scene_forget_points(scene); // which would rule out what lies beyond
    for (int i = 0; i < 2; i++) {
        config.seed = 7 * (uint64_t)i;
        decide(scene, &config);
        memcpy(both[i], decisions, sizeof decisions);
    }
    for (uint32_t i = 0; i < count; i++) {
        assert_true(test_same_bits(both[0][i].evidence, both[1][i].evidence));
        assert_true(test_same_bits(both[0][i].evidence_low, both[1][i].evidence_low));
        assert_int_equal(both[0][i].called_for, both[1][i].called_for);
    }
    assert_true(isfinite(decision_on("sky")->evidence));
    assert_true(isfinite(decision_on("appearance")->evidence));   // by pilots, without points
    assert_true(isnan(decision_on("appearance_code")->evidence)); // nothing calls for it
}

// An effect that splats cannot have would otherwise take the place of one that they can have.
TEST(splats_try_what_they_can_have) {
    struct vw_scene *scene = detection_plain_scene();
    struct vw_config config = vw_config_of_field(VW_FIELD_SPLATS);
    config.pilot_steps = 8;
    scene_forget_points(scene);
    decide(scene, &config);
    assert_true(isfinite(decision_on("sky")->evidence));
    assert_true(isnan(decision_on("unbounded")->evidence));
    assert_true(isnan(decision_on("wide_box")->evidence));
}

// Folds leave out different photos, evenly, and learn from none that judges them; photos of val and test are in
// neither.
TEST(folds_share_no_photo) {
    struct vw_scene *scene = open_recipe("clean.json");
    struct vw_pilots pilots;
    struct vw_config config = small_config();
    uint32_t judged[64] = {0};
    ASSERT_OK(vw_pilots_open(&(struct vw_pilots_params){.scene = scene, .planned = &config, .steps = 8}, &pilots));
    assert_int_equal(pilots.photo_count, scene->split_count[VW_SPLIT_TRAIN]);
    for (uint32_t f = 0; f < PILOT_FOLDS; f++) {
        const struct vw_pilot_fold *fold = &pilots.folds[f];
        assert_int_equal(fold->held_out_count, PILOT_HELD_OUT_MIN);
        assert_int_equal(fold->held_out_count + fold->train_count, pilots.photo_count);
        for (uint32_t i = 0; i < fold->held_out_count; i++) {
            assert_int_equal(judged[fold->held_out[i]]++, 0);
            assert_int_equal(scene->views[fold->held_out[i]].split, VW_SPLIT_TRAIN);
            for (uint32_t j = 0; j < fold->train_count; j++)
                assert_int_not_equal(fold->train_views[j], fold->held_out[i]);
        }
    }
}

// Pilots train splats for a run of splats, and otherwise a hash grid, for which what only the field mlp has is off.
TEST(pilots_train_the_field_of_the_run) {
    struct vw_config planned = vw_config_of_field(VW_FIELD_MLP);
    planned.mlp_depth = 2;
    planned.frequencies = 4;
    planned.importance_samples = 8;
    planned.coarse_network = VW_COARSE_NETWORK_OWN;
    struct vw_config splats = vw_config_of_field(VW_FIELD_SPLATS);
    splats.splats = 100000;
    splats.harmonics = 3;
    splats.ssim_weight = 0.3;
    const struct vw_config *configs[] = {&planned, &splats};
    const enum vw_field fields[] = {VW_FIELD_HASH, VW_FIELD_SPLATS};
    for (size_t i = 0; i < VW_ARRAY_COUNT(configs); i++) {
        ASSERT_OK(vw_config_check(configs[i]));
        const struct vw_config pilot = vw_pilots_config(configs[i], 8);
        assert_int_equal(pilot.field, fields[i]);
        ASSERT_OK(vw_config_check(&pilot));
    }
    assert_int_equal(vw_pilots_config(&splats, 8).splats, PILOT_SPLATS);
    assert_true(vw_pilots_config(&splats, 8).ssim_weight == 0.3);
}

// Six pilots, of two trainings each, look at no more than a tenth of the rays of the run, unless that leaves too few
// steps.
TEST(pilots_keep_to_a_tenth) {
    struct vw_scene *scene = open_recipe("clean.json");
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    const uint32_t photos = scene->split_count[VW_SPLIT_TRAIN];
    assert_int_equal(vw_pilot_steps(scene, &config), 256);
    config.epochs = 10000 / photos;
    double run_rays = (double)config.epochs * photos * config.rays, steps = vw_pilot_steps(scene, &config);
    assert_true(steps > 256 && steps < 1024);
    assert_true(6 * PILOT_FOLDS * steps * PILOT_RAYS <= 0.1 * run_rays);
    assert_true(6 * PILOT_FOLDS * (steps + 1) * PILOT_RAYS > 0.1 * run_rays);
    config.epochs = 50000 / photos;
    assert_int_equal(vw_pilot_steps(scene, &config), 1024);
    assert_int_equal(vw_pilot_steps_in_doubt(scene, &config), 2048);
    config.pilot_steps = 8;
    assert_int_equal(vw_pilot_steps(scene, &config), 8);
    assert_int_equal(vw_pilot_steps_in_doubt(scene, &config), 8); // as the user says
    config.pilot_steps = VW_PILOT_STEPS_AUTO;
    config.epochs = 511 / photos;
    assert_int_equal(vw_pilot_steps_in_doubt(scene, &config), 256); // never longer than the run
}

// The effect chooses the box that the field sees; beside unbounded it does nothing.
TEST(a_wide_box_is_seen) {
    const struct {
        const char *effects;
        double widening;
    } cases[] = {{"none", 1.0}, {"wide_box", 2.0}};
    struct vw_scene *scene = test_scene();
    scene_forget_points(scene);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config = test_config();
        struct vw_trainer *trainer = NULL;
        strcpy(config.effects, cases[i].effects);
        trainer = test_trainer_open((struct vw_trainer_params){.gpu = test_gpu(), .scene = scene, .config = &config});
        const struct vw_box *box = vw_trainer_effect_box(trainer);
        assert_int_equal(box != NULL, i);
        if (box) assert_true(box->half_extent_world == cases[i].widening * scene->box.half_extent_world);
        test_release(trainer);
    }
}

// Without pilots, effects that only they could judge are unknown, and off.
TEST(no_pilots_where_they_cannot_tell) {
    struct vw_scene *scene = open_recipe("clean.json"), *few = test_scene();
    const struct {
        bool device, photos;
        const char *effects;
        uint32_t steps;
    } cases[] = {{false, true, "auto", 8}, {true, true, "none", 8}, {true, true, "auto", 0}, {true, false, "auto", 8}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_config config = small_config();
        strcpy(config.effects, cases[i].effects);
        config.pilot_steps = cases[i].steps;
        ASSERT_OK(vw_effects_decide(cases[i].device ? test_gpu() : NULL, cases[i].photos ? scene : few, &config,
                                    decisions, &count));
        const struct vw_effect_decision *sky = decision_on("sky");
        assert_true(isnan(sky->evidence) && !sky->called_for && !sky->on);
    }
    assert_true(few->split_count[VW_SPLIT_TRAIN] < 8);
}

// With the effect off, masks are ignored; what no lens or file can give stays left out.
TEST(masks_are_ignored_with_the_effect_off) {
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
}

// ---- Real photos, where they are ------------------------------------------------------------------------------------

TEST(real_scenes_show_their_facts) {
    static const struct {
        const char *name, *called_for; // each between spaces
    } real_scenes[] = {{"fox", " distortion appearance "},
                       {"sacre_coeur", " distortion appearance "},
                       {"statue_of_liberty", " distortion masks appearance "},
                       {"chair_synthetic", " background "}};
    uint32_t found = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(real_scenes); i++) {
        const char *path = real_scene_path(real_scenes[i].name);
        if (!path) continue;
        struct vw_scene *scene = open_scene(path);
        found++;
        ASSERT_OK(vw_effects_find_facts(scene, "auto", decisions, &count));
        for (uint32_t e = 0; e < count; e++) {
            char *word = vw_format_text(" %s ", decisions[e].name);
            assert_int_equal(decisions[e].called_for, strstr(real_scenes[i].called_for, word) != NULL);
            free(word);
        }
    }
    if (!found) skip();
}

TEST_GROUP(NULL, test_gpu_close)
