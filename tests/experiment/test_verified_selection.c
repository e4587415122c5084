// A verified selection on a small scene, held against what its retrainings reach on single photos: which scores make
// which list, and which photos judge it.

#include "base/statistics.h"
#include "experiment/retrain.h"
#include "experiment/verified_selection.h"
#include "run/scoring.h"
#include "support/ledger_chain.h"
#include "support/small_run.h"
#include "viewworth/run.h"

enum { PHOTOS = 10, JUDGES = 5, IMAGES = PHOTOS + JUDGES, SEEDS = 2, RUN_SEED = 3, KEPT = 8 };

static const char recipe[] =
    "{\"viewworth_recipe\": 1, \"seed\": 3, \"image\": {\"width_px\": 16, \"height_px\": 12},"
    " \"box\": {\"centre\": [0, 0, 0], \"half_extent\": 1},"
    " \"shapes\": [{\"kind\": \"sphere\", \"centre\": [0, 0, 0], \"radius\": 0.6, \"texture\": {\"kind\": \"checker\","
    "   \"colour\": [0.9, 0.2, 0.1], \"second_colour\": [0.2, 0.3, 0.9], \"cell\": 0.3}}],"
    " \"cameras\": [{\"path\": \"orbit\", \"centre\": [0, 0, 0], \"radius\": 2.5, \"count\": 10,"
    "   \"field_of_view_deg\": 50, \"split\": \"train\"}, {\"path\": \"orbit\", \"centre\": [0, 0, 0], \"radius\": 2.5,"
    "   \"count\": 5, \"start_deg\": 20, \"field_of_view_deg\": 50, \"split\": \"val\"}],"
    " \"defects\": [{\"kind\": \"wrong_pose\", \"strength\": 60, \"views\": [4]}]}";

struct fixture {
    char *folder;
    const char *scene, *out;
    struct vw_config config;
    struct vw_scored_run run;
    struct vw_verified_selection verified;
    uint8_t halves[IMAGES];
    uint32_t sizes[VW_HALVES];
};

// Writes chain and scores anew after the steps were changed.
static void seal(const struct fixture *f) {
    AUTO_FREE char *path = vw_format_text("%s/ledger.db", f->out);
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    struct vw_scoring scoring = {0};
    chain_rewrite(path);
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    ASSERT_OK(vw_scoring_make(ledger, &f->config, &scoring));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-26T00:00:00Z", scoring.scores, scoring.score_count));
    vw_scoring_free(&scoring);
    assert_int_equal(remove(temporary_path(f->out, "SHA256SUMS")), 0); // it names the chain's head of before
}

// Changes the ledger so that half A sees the field better after steps on the first half of the photos, half B after
// those on the others.
static void set_halves_apart(const struct fixture *f) {
    static const double BETTER = 0.02, WORSE = 0.04;
    const char *ledger = temporary_path(f->out, "ledger.db");
    char sql[512];
    for (uint32_t v = PHOTOS; v < IMAGES; v++) {
        snprintf(sql, sizeof sql,
                 "UPDATE view SET mse = CASE WHEN (SELECT s.image_id FROM step s WHERE s.step = view.step) %s %d THEN"
                 " %g ELSE %g END WHERE image_id = %u",
                 f->halves[v] == VW_HALF_A ? "<" : ">=", PHOTOS / 2, BETTER, WORSE, v);
        sql_change(ledger, sql);
    }
    snprintf(sql, sizeof sql,
             "UPDATE step SET (val_psnr, val_psnr_pooled) = (SELECT avg(db), avg(db) FROM (SELECT step, iif(mse = %g, "
             "%.17g, %.17g) AS db FROM view) AS v WHERE v.step = step.step)",
             BETTER, vw_psnr_db(BETTER), vw_psnr_db(WORSE));
    sql_change(ledger, sql);
    seal(f);
}

static int set_up(void **state) {
    struct fixture *f = vw_allocate(1, sizeof *f);
    f->folder = temporary_folder_create();
    f->scene = temporary_file(f->folder, "scene.json", recipe);
    f->out = temporary_path(f->folder, "out");
    f->config = small_config(RUN_SEED, 6);
    const struct vw_run_params params = {
        .scene = {.path = f->scene}, .config = &f->config, .out = f->out, .report.no_thumbnails = true};
    struct vw_run *run = small_run_make(&params);
    vw_run_close(&run);
    ASSERT_OK(vw_scored_run_open(f->out, &f->run));
    ASSERT_OK(vw_halves_split(f->run.images, f->run.image_count, RUN_SEED, f->halves, f->sizes));
    vw_scored_run_close(&f->run);
    set_halves_apart(f);
    ASSERT_OK(vw_scored_run_open(f->out, &f->run));
    const struct vw_verified_selection_params verified = {.run = &f->run, .seeds = SEEDS};
    ASSERT_OK(vw_verified_selection_make(&verified, &f->verified));
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    AUTO_FREE struct fixture *f = *state;
    vw_verified_lists_free(&f->verified.lists);
    vw_scored_run_close(&f->run);
    temporary_folder_remove(f->folder);
    return 0;
}

// Checks that the list is the best three quarters by the scores of a half, or by those that the run recorded.
static void check_list(struct fixture *f, const struct vw_verified_list *list, int half) {
    const struct vw_selection_params params = {.rule = VW_SELECT_TOP, .amount = 75, .percent = true};
    struct vw_selection expected = {0};
    struct vw_value_input input;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0;
    ASSERT_OK(vw_scoring_load(f->run.recorded.ledger, &f->config, &input));
    if (half == VW_HALF_BOTH) ASSERT_OK(vw_scored_run_select(&f->run, &params, &expected));
    else {
        ASSERT_OK(vw_halves_score(f->run.recorded.ledger, &input, f->halves, (uint8_t)half, &scores, &score_count));
        ASSERT_OK(vw_selection_make(scores, score_count, f->run.images, f->run.image_count, &params, &expected));
        vw_sort_places(expected.image_ids, expected.count);
    }
    assert_int_equal(expected.count, KEPT);
    assert_int_equal(list->selections[half].count, expected.count);
    assert_memory_equal(list->selections[half].image_ids, expected.image_ids,
                        expected.count * sizeof *expected.image_ids);
    vw_selection_free(&expected);
    vw_scoring_unload(&input);
}

static void check_gain(const struct vw_verified_selection *verified, const struct vw_retrainer *retrainer,
                       const uint8_t *halves, uint32_t place) {
    double gain_db = 0;
    for (uint32_t v = PHOTOS; v < IMAGES; v++)
        for (uint32_t s = 0; s < SEEDS; s++)
            for (int side = 0; side < 2; side++) {
                const struct vw_selection *selection =
                    &verified->lists.of[side ? place : 0].selections[halves[v] ? VW_HALF_A : VW_HALF_B];
                const struct vw_retrain_params retraining = {
                    .views = selection->image_ids, .view_count = selection->count, .seed = RUN_SEED + 1 + s};
                struct vw_retrain_view view = {.image_id = v};
                ASSERT_OK(vw_retrainer_find_views(retrainer, &retraining, &view, 1));
                gain_db += (side ? 1 : -1) * view.psnr_db / (JUDGES * SEEDS);
            }
    assert_near(verified->gains[place].gain_db, gain_db, 1e-9); // rounding of sums
}

TEST_WITHIN(a_half_judges_what_the_other_selects, set_up, tear_down) {
    struct fixture *f = *state;
    AUTO(vw_session_close) struct vw_session session = {0};
    AUTO(vw_retrainer_close) struct vw_retrainer retrainer = {0};
    uint32_t halved = UINT32_MAX;
    assert_true(f->sizes[VW_HALF_A] == 3 && f->sizes[VW_HALF_B] == 2 && f->verified.half_sizes[VW_HALF_A] == 3 &&
                f->verified.half_sizes[VW_HALF_B] == 2);
    assert_int_equal(f->verified.first_seed, RUN_SEED + 1);
    assert_int_equal(vw_first_seed_after((uint64_t)INT64_MAX - 9), 0); // there is no room after it
    ASSERT_OK(vw_session_open(&(struct vw_session_params){.scene = {.path = f->scene}}, &session));
    const struct vw_retrainer_params params = {
        .session = &session, .config = &f->config, .out = f->out, .averaged_epochs = VW_TRUTH_EPOCHS};
    ASSERT_OK(vw_retrainer_open(&params, &retrainer));
    assert_true(f->verified.lists.count > 3);
    for (uint32_t c = 1; c < f->verified.lists.count; c++) {
        check_gain(&f->verified, &retrainer, f->halves, c);
        if (strcmp(f->verified.lists.of[c].name, "top:75%:dv_psnr") == 0) halved = c;
    }
    assert_true(halved != UINT32_MAX);
    const struct vw_verified_list *list = &f->verified.lists.of[halved];
    for (int half = 0; half < VW_SCORINGS; half++) check_list(f, list, half);
    assert_int_equal(list->selections[VW_HALF_A].image_ids[PHOTOS / 2 - 1], PHOTOS / 2 - 1);
    assert_int_equal(list->selections[VW_HALF_B].image_ids[KEPT - PHOTOS / 2], PHOTOS / 2);
}
