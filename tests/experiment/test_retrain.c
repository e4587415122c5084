// Retrainings on some photos: at equal steps or equal epochs, measured at the end or over the ends of several epochs.
#include "support/cmocka_test.h"

#include "experiment/retrain.h"
#include "run/plan/plan.h"
#include "support/ledger_fixture.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "train/shared_submissions.h"

enum { PHOTOS = 6 };

struct fixture {
    char *folder;
    struct vw_session session;
    struct vw_config config;
    struct vw_retrainer retrainer;
};

static int set_up(void **state) {
    struct fixture *f = vw_allocate(1, sizeof *f);
    f->folder = temporary_folder_create();
    f->config = small_config(0, 3);
    static const char *const preferred[] = {NULL}; // again
    const struct vw_session_params params = {.scene = {.path = SMALL_SCENE}, .devices = {NULL, preferred, 1}};
    ASSERT_OK(vw_session_open(&params, &f->session));
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    AUTO_FREE struct fixture *f = *state;
    vw_retrainer_close(&f->retrainer);
    vw_session_close(&f->session);
    temporary_folder_remove(f->folder);
    return 0;
}

// Opens the retrainer anew; without a folder as `out` it recalls nothing.
static void open_retrainer(struct fixture *f, struct vw_retrainer_params params) {
    params.session = &f->session;
    params.config = &f->config;
    vw_retrainer_close(&f->retrainer);
    f->retrainer = (struct vw_retrainer){0};
    ASSERT_OK(vw_retrainer_open(&params, &f->retrainer));
    assert_int_equal(f->retrainer.train_count, PHOTOS);
}

// Returns the result of one retraining on the first `count` photos; 0 epochs: those of the config.
static struct vw_retrain_result retrain(struct fixture *f, enum vw_equal equal, uint32_t averaged_epochs,
                                        uint32_t count, uint32_t epochs) {
    struct vw_retrain_result result;
    open_retrainer(f,
                   (struct vw_retrainer_params){.out = f->folder, .equal = equal, .averaged_epochs = averaged_epochs});
    const struct vw_retrain_params retraining = {
        .views = f->retrainer.train_views, .view_count = count, .seed = 3, .epochs = epochs};
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &result));
    return result;
}

TEST_WITHIN(one_step_has_no_time, set_up, tear_down) {
    struct fixture *f = *state;
    struct vw_estimate estimate = {0};
    uint32_t view = 0;
    vw_config_set_epochs(&f->config, 1);
    ASSERT_OK(vw_session_decide_effects(&f->config, &f->session));
    ASSERT_OK(vw_estimate_take_steps(&(struct vw_trainer_params){.gpu = f->session.devices[0].gpu,
                                                                 .scene = f->session.scene,
                                                                 .config = &f->config,
                                                                 .effects = f->session.effects,
                                                                 .effect_count = f->session.effect_count,
                                                                 .train_views = &view,
                                                                 .train_view_count = 1},
                                     &estimate));
    assert_int_equal(estimate.steps, 1);
    assert_true(isnan(estimate.seconds_per_step));
}

TEST_WITHIN(all_photos_are_the_same_in_both_ways, set_up, tear_down) {
    struct vw_retrain_result steps = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS, 0);
    struct vw_retrain_result epochs = retrain(*state, VW_EQUAL_EPOCHS, 1, PHOTOS, 0);
    assert_true(isfinite(steps.val_psnr) && steps.val_psnr == epochs.val_psnr && steps.test_l1 == epochs.test_l1);
}

// With half of the photos, equal steps are twice the epochs.
TEST_WITHIN(equal_steps_train_longer_than_equal_epochs, set_up, tear_down) {
    struct vw_retrain_result steps = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS / 2, 0);
    struct vw_retrain_result epochs = retrain(*state, VW_EQUAL_EPOCHS, 1, PHOTOS / 2, 0);
    struct vw_retrain_result longer = retrain(*state, VW_EQUAL_EPOCHS, 1, PHOTOS / 2, 6);
    assert_true(steps.val_psnr > epochs.val_psnr + 0.5 * (longer.val_psnr - epochs.val_psnr));
}

TEST_WITHIN(results_are_means_over_the_ends_of_the_last_epochs, set_up, tear_down) {
    struct vw_retrain_result second = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS - 1, 2);
    struct vw_retrain_result third = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS - 1, 3);
    struct vw_retrain_result mean = retrain(*state, VW_EQUAL_STEPS, 2, PHOTOS - 1, 3);
    assert_true(second.val_psnr != third.val_psnr);
    assert_true(fabs(mean.val_psnr - 0.5 * (second.val_psnr + third.val_psnr)) < 1e-9); // rounding of doubles
    assert_true(fabs(mean.test_l1 - 0.5 * (second.test_l1 + third.test_l1)) < 1e-9);
    struct vw_retrain_result first = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS - 1, 1);
    struct vw_retrain_result all = retrain(*state, VW_EQUAL_STEPS, 9, PHOTOS - 1, 3); // there are no more than three
    assert_true(fabs(all.val_psnr - (first.val_psnr + second.val_psnr + third.val_psnr) / 3) < 1e-9);
}

// tiny.json has two validation photos, 6 and 7.
TEST_WITHIN(single_photos_add_up_to_the_result, set_up, tear_down) {
    struct fixture *f = *state;
    struct vw_retrain_view views[] = {{6, 0}, {7, 0}};
    struct vw_retrain_result result = retrain(f, VW_EQUAL_STEPS, 2, PHOTOS - 1, 0);
    const struct vw_retrain_params retraining = {
        .views = f->retrainer.train_views, .view_count = PHOTOS - 1, .seed = 3};
    ASSERT_OK(vw_retrainer_find_views(&f->retrainer, &retraining, views, 2));
    assert_true(views[0].psnr_db != views[1].psnr_db);
    assert_true(fabs(0.5 * (views[0].psnr_db + views[1].psnr_db) - result.val_psnr) < 1e-9); // rounding of doubles
}

TEST_WITHIN(without_photos_the_untrained_field_is_measured, set_up, tear_down) {
    struct vw_retrain_result none = retrain(*state, VW_EQUAL_STEPS, 2, 0, 0);
    struct vw_retrain_result again = retrain(*state, VW_EQUAL_EPOCHS, 1, 0, 1);
    struct vw_retrain_result all = retrain(*state, VW_EQUAL_STEPS, 1, PHOTOS, 0);
    assert_true(none.val_psnr == again.val_psnr && none.val_psnr < all.val_psnr);
}

// Asked before each retraining begins.
struct observer {
    const struct vw_session *session;
    uint32_t trainers[3]; // on both devices, and how often it was asked
};

static bool count_trainers(void *context) {
    struct observer *observer = context;
    for (uint32_t d = 0; d < 2; d++) observer->trainers[d] = observer->session->devices[d].submissions->member_count;
    observer->trainers[2]++;
    return false;
}

TEST_WITHIN(several_are_on_all_devices_in_turn, set_up, tear_down) {
    struct fixture *f = *state;
    struct observer observer = {.session = &f->session};
    struct vw_retrain_params retrainings[4];
    struct vw_retrain_result results[4];
    open_retrainer(
        f, (struct vw_retrainer_params){.out = f->folder, .together = 2, .interrupt = {count_trainers, &observer}});
    for (uint32_t i = 0; i < 4; i++)
        retrainings[i] =
            (struct vw_retrain_params){.views = f->retrainer.train_views, .view_count = PHOTOS - i, .seed = 3};
    ASSERT_OK(vw_retrain(&f->retrainer, retrainings, 4, results));
    assert_int_equal(observer.trainers[2], 4);
    assert_int_equal(observer.trainers[0], 2);
    assert_int_equal(observer.trainers[1], 1); // the last one is not made yet
    f->session.device_count = 1;               // the same results on one device
    assert_int_equal(remove(temporary_path(f->folder, "retrainings.db")), 0);
    for (uint32_t i = 0; i < 4; i++)
        assert_true(retrain(f, VW_EQUAL_STEPS, 1, PHOTOS - i, 0).val_psnr == results[i].val_psnr);
    assert_int_equal(f->retrainer.recalled, 0);
    f->session.device_count = 2;
}

// Asking for photos makes no other retraining: its result and its id stay.
TEST_WITHIN(photos_that_were_left_out_can_be_measured, set_up, tear_down) {
    struct fixture *f = *state;
    struct vw_retrain_result plain = retrain(f, VW_EQUAL_STEPS, 2, PHOTOS - 2, 0), measured, recalled;
    struct vw_retrain_view left_out[] = {{f->retrainer.train_views[PHOTOS - 2], 0},
                                         {f->retrainer.train_views[PHOTOS - 1], 0}},
                           again[] = {left_out[0], left_out[1]}, val[] = {{6, 0}, {7, 0}}, found[] = {{6, 0}, {7, 0}};
    struct vw_retrain_params retraining = {
        .views = f->retrainer.train_views, .view_count = PHOTOS - 2, .seed = 3, .photos = left_out, .photo_count = 2};
    char id[VW_HASH_HEX_BYTES], plain_id[VW_HASH_HEX_BYTES];
    vw_retrainer_name(&f->retrainer, &retraining, id);
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &measured));
    assert_int_equal(f->retrainer.made, 2); // the first one did not measure them
    assert_true(measured.val_psnr == plain.val_psnr && measured.test_l1 == plain.test_l1);
    assert_true(left_out[0].psnr_db > 3 && left_out[0].psnr_db != left_out[1].psnr_db);
    retraining.photos = again;
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &recalled));
    assert_int_equal(f->retrainer.made, 2);
    assert_true(again[0].psnr_db == left_out[0].psnr_db && again[1].psnr_db == left_out[1].psnr_db);
    retraining.photos = val; // measured in the same way as validation photos are
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &recalled));
    ASSERT_OK(vw_retrainer_find_views(&f->retrainer, &retraining, found, 2));
    assert_true(val[0].psnr_db == found[0].psnr_db && val[1].psnr_db == found[1].psnr_db);
    retraining.photo_count = 0;
    vw_retrainer_name(&f->retrainer, &retraining, plain_id);
    assert_string_equal(id, plain_id);
}

// An epoch takes one step on each photo: its gains add up to what the epoch gains, and come back from the store.
TEST_WITHIN(steps_gain_what_the_epoch_gains, set_up, tear_down) {
    struct fixture *f = *state;
    struct vw_retrain_view gains[PHOTOS], again[PHOTOS];
    struct vw_retrain_result first = retrain(f, VW_EQUAL_STEPS, 1, PHOTOS, 1), untrained, result;
    for (uint32_t i = 0; i < PHOTOS; i++) gains[i].image_id = again[i].image_id = f->retrainer.train_views[i];
    struct vw_retrain_params retraining = {.views = f->retrainer.train_views,
                                           .view_count = PHOTOS,
                                           .seed = 3,
                                           .epochs = 1,
                                           .photos = gains,
                                           .photo_count = PHOTOS,
                                           .photos_of = VW_RETRAIN_PHOTOS_GAINS};
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &result));
    assert_int_equal(f->retrainer.made, 2);
    assert_true(result.val_psnr == first.val_psnr); // validation changes nothing
    ASSERT_OK(vw_retrain(&f->retrainer, &(struct vw_retrain_params){.seed = 3}, 1, &untrained));
    double sum = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) sum += gains[i].psnr_db;
    double gained = result.val_psnr - untrained.val_psnr; // by other pixels: within a tenth
    assert_true(fabs(gained) > 0.01 && fabs(sum - gained) < 0.1 * fabs(gained));
    retraining.photos = again;
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &result));
    assert_int_equal(f->retrainer.made, 3);
    for (uint32_t i = 0; i < PHOTOS; i++) assert_true(again[i].psnr_db == gains[i].psnr_db);
    retraining.photos_of = VW_RETRAIN_PHOTOS_PSNR; // same training, but its gains cannot answer this
    ASSERT_OK(vw_retrain(&f->retrainer, &retraining, 1, &result));
    for (uint32_t i = 0; i < PHOTOS; i++) assert_true(again[i].psnr_db > 3 && again[i].psnr_db != gains[i].psnr_db);
}

// ---- Recorded results ----------------------------------------------------------------------------------------------

TEST_WITHIN(a_recorded_retraining_is_compared_bit_for_bit, set_up, tear_down) {
    struct fixture *f = *state;
    struct vw_retrain_result result, other;
    AUTO(vw_retraining_store_close) struct vw_retraining_store *store = NULL;
    for (int recalled = 0; recalled < 2; recalled++) {
        open_retrainer(f, (struct vw_retrainer_params){.out = f->folder});
        const struct vw_retrain_params on_all = {.views = f->retrainer.train_views, .view_count = PHOTOS, .seed = 3};
        ASSERT_OK(vw_retrain(&f->retrainer, &on_all, 1, &result));
        assert_int_equal(f->retrainer.recalled, recalled);
    }
    open_retrainer(f, (struct vw_retrainer_params){0});
    const struct vw_retrain_params on_all = {.views = f->retrainer.train_views, .view_count = PHOTOS, .seed = 3};
    ASSERT_OK(vw_retrain(&f->retrainer, &on_all, 1, &result));
    assert_int_equal(f->retrainer.made, 1);
    ASSERT_OK(vw_retraining_store_open_to_read(temporary_path(f->folder, "retrainings.db"), &store));
    ASSERT_OK(vw_retrainer_compare(&f->retrainer, store, &on_all, &result));
    other = result;
    other.test_l1 = nextafter(other.test_l1, 1);
    ASSERT_FAILS(vw_retrainer_compare(&f->retrainer, store, &on_all, &other), VW_ERROR_MISMATCH, "made again");
}
