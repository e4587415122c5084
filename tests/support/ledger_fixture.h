// The fixture of the tests around the ledger: a folder of their own, a small scene, and a fake trainer.
#ifndef VIEWWORTH_TESTS_SUPPORT_LEDGER_FIXTURE_H
#define VIEWWORTH_TESTS_SUPPORT_LEDGER_FIXTURE_H

#include "support/temporary_folder.h"

#include <ftw.h>
#include <math.h>
#include <unistd.h>

#include "base/random.h"
#include "viewworth/ledger.h"
#include "viewworth/value.h"

#define HEX_A "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
#define HEX_B "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"

static inline struct vw_ledger_run test_run(const char *config_json) {
    return (struct vw_ledger_run){
        .run_id = HEX_A,
        .scene_hash = HEX_B,
        .scene_path = "scenes/small.json",
        .seed = 9223372036854775807,
        .config_json = config_json,
        .subset_hash = HEX_A,
        .device = "fake device",
        .driver = "fake driver 1.0",
        .shader_hash = HEX_B,
        .version = "0.1.0",
        .started_utc = "2026-11-21T03:04:05Z",
        .scene_options_json = "{\"downscale\":2}",
        .effects_json = "[{\"name\":\"distortion\",\"on\":false}]",
        .plan_json = "{\"accuracy\":\"draft\"}",
    };
}

// Views 0 and 4 validate, 7 is for testing, the others train; 2 and 5 are corrupted.
enum { TEST_IMAGE_COUNT = 8, TEST_TRAIN_COUNT = 5, TEST_VALIDATION_COUNT = 2 };
static const uint32_t test_train_views[TEST_TRAIN_COUNT] = {1, 2, 3, 5, 6};
static const uint32_t test_validation_views[TEST_VALIDATION_COUNT] = {0, 4};
static const struct vw_ledger_image test_images[TEST_IMAGE_COUNT] = {
    {0, "images/0.png", "val", NULL, HEX_A, "clean"},      {1, "images/1.png", "train", "alice", HEX_A, "clean"},
    {2, "images/2.png", "train", "bob", HEX_A, "blur"},    {3, "images/3.png", "train", NULL, HEX_A, "clean"},
    {4, "images/4.png", "val", NULL, HEX_A, "clean"},      {5, "images/5.png", "train", "bob", HEX_A, "occluder"},
    {6, "images/6.png", "train", "alice", HEX_A, "clean"}, {7, "images/7.png", "test", NULL, HEX_A, NULL},
};

// Returns a validated step on an image; its pooled PSNR is twice its PSNR, and its L1 a hundredth.
static inline struct vw_step_record test_step(uint64_t step, uint32_t epoch, uint32_t view, double psnr) {
    return (struct vw_step_record){
        step, epoch, view, .validated = true, .val_psnr = psnr, .val_psnr_pooled = 2 * psnr, .val_l1 = psnr / 100};
}

// Returns what is scored of steps on test_images; an epoch is burn-in.
static inline struct vw_value_input test_value_input(const struct vw_step_record *records, uint64_t count) {
    return (struct vw_value_input){records, count, .burn_in_epochs = 1, .images = test_images,
                                   .image_count = TEST_IMAGE_COUNT};
}

// A trainer whose photos are worth what `worth_db` says: each visit of train photo i moves val_psnr by worth_db[i] plus
// noise of +-noise_db, L1 by a hundredth of it the other way, and the pooled PSNR by twice it. Gives 1 + epochs *
// TEST_TRAIN_COUNT records.
struct test_trainer {
    double worth_db[TEST_TRAIN_COUNT];
    double noise_db;
    double first_epoch_factor; // deltas of epoch 0 are this much larger
    uint32_t epochs;
    uint64_t seed;
};

static const struct test_trainer test_four_epochs = {
    .worth_db = {0.5, -0.2, 0.1, -0.3, 0.2}, .noise_db = 0.05, .first_epoch_factor = 3, .epochs = 4};

static inline uint32_t test_train(const struct test_trainer *trainer, struct vw_step_record *records,
                                  struct vw_view_error *errors) {
    uint32_t count = 1 + trainer->epochs * TEST_TRAIN_COUNT;
    double psnr = 12.0, pooled = 11.0, l1 = 0.3;
    for (uint32_t step = 0; step < count; step++) {
        uint32_t epoch = step ? (step - 1) / TEST_TRAIN_COUNT : 0, order[TEST_TRAIN_COUNT], words[4];
        vw_random_order(trainer->seed, epoch, TEST_TRAIN_COUNT, order);
        vw_random_words(trainer->seed, VW_RANDOM_JITTER, step, 0, 0, words);
        uint32_t train = step ? order[(step - 1) % TEST_TRAIN_COUNT] : 0;
        double delta = step ? trainer->worth_db[train] + trainer->noise_db * (2.0 * vw_random_unit(words[0]) - 1.0) : 0;
        if (epoch == 0) delta *= trainer->first_epoch_factor;
        psnr += delta;
        pooled += 2 * delta;
        l1 -= delta / 100;
        // The second view is floored at 100 dB; SQLite keeps no negative zero. The first makes their mean PSNR.
        errors[2 * step] = (struct vw_view_error){.mse = pow(10, (100 - 2 * psnr) / 10), .l1 = l1};
        errors[2 * step + 1] = (struct vw_view_error){.mse = -0.0, .l1 = 0.125};
        records[step] = (struct vw_step_record){
            .step = step,
            .epoch = epoch,
            .view = step ? test_train_views[train] : (uint32_t)VW_RECORD_UNTRAINED,
            .train_loss = step ? 0.2 : NAN,
            .validated = true,
            .clamped_count = step,
            .floored_views = (uint32_t)(step % 3),
            .val_psnr = psnr,
            .val_psnr_pooled = pooled,
            .val_l1 = l1,
            .views = &errors[2 * step],
            .view_count = TEST_VALIDATION_COUNT,
        };
    }
    return count;
}

enum { TEST_EPOCHS_MOST = 40, TEST_RECORDS_MOST = 1 + TEST_EPOCHS_MOST * TEST_TRAIN_COUNT };

// The records that a fake trainer hands out.
struct test_recording {
    struct vw_step_record records[TEST_RECORDS_MOST];
    struct vw_view_error errors[2 * TEST_RECORDS_MOST];
    uint32_t count;
};

// Trains, and returns the recording, to be freed.
static inline struct test_recording *test_record(const struct test_trainer *trainer) {
    struct test_recording *recording = vw_allocate(1, sizeof *recording);
    assert_non_null(recording);
    recording->count = test_train(trainer, recording->records, recording->errors);
    return recording;
}

// Spoils steps so that they carry no value: 7 and 8 are not finite, 12 was not validated.
static inline void test_corruption(struct test_recording *recording) {
    recording->records[7].nonfinite = true;
    recording->errors[2 * 8].mse = INFINITY;
    struct vw_step_record *unvalidated = &recording->records[12];
    unvalidated->validated = false;
    unvalidated->val_psnr = unvalidated->val_psnr_pooled = unvalidated->val_l1 = NAN;
    unvalidated->views = NULL;
}

enum { TEST_SCORE_COUNT = 3 };
static const struct vw_ledger_score test_scores[TEST_SCORE_COUNT] = {
    {1, "dv_psnr", 1.5, "dB", 0.25, 3, 1, 2, 1, 2},
    {2, "dv_psnr", -0.0, "dB", NAN, 1, NAN, NAN, 0, 0},
    {1, "dv_loss", 0.015, "mean absolute error", 0.0025, 3, 0.01, 0.02, 1, 1},
};

// All train photos, and two of them.
static const uint32_t test_bobs[] = {2, 5};
enum { TEST_RETRAINING_COUNT = 3 };
static const struct vw_ledger_retraining test_retraining_store[TEST_RETRAINING_COUNT] = {
    {7, 2, test_train_views, TEST_TRAIN_COUNT, 17.5},
    {8, 2, test_bobs, 2, 15.25},
    {9, 2, test_train_views, 3, NAN},
};

static inline struct vw_ledger *test_ledger_create(const char *path) {
    struct vw_ledger_run run = test_run("{\"burn_in_epochs\": 1}");
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger));
    return ledger;
}

static inline struct vw_ledger *test_ledger_open(const char *path) {
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_open(path, &ledger));
    return ledger;
}

static inline struct vw_ledger *test_ledger_open_to_append(const char *path) {
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    return ledger;
}

static inline void test_ledger_finish(struct vw_ledger *ledger, const char *status) {
    uint32_t score_count = strcmp(status, "finished") == 0 ? TEST_SCORE_COUNT : 0;
    if (score_count) ASSERT_OK(vw_ledger_set_field(ledger, HEX_B));
    ASSERT_OK(vw_ledger_finish(ledger, status, "2026-11-21T04:00:00Z", test_scores, score_count));
    if (score_count)
        ASSERT_OK(
            vw_ledger_add_retrainings(ledger, test_retraining_store, TEST_RETRAINING_COUNT, test_scores, score_count));
}

// Appends a corrupted run in batches of `batch` steps.
static inline void test_ledger_append(struct vw_ledger *ledger, const struct test_trainer *trainer,
                                      uint32_t submission) {
    struct test_recording *recording = test_record(trainer);
    test_corruption(recording);
    for (uint32_t first = 0; first < recording->count; first += submission) {
        uint32_t some = recording->count - first < submission ? recording->count - first : submission;
        ASSERT_OK(vw_ledger_append(ledger, &recording->records[first], some, test_validation_views));
    }
    free(recording);
}

// Records a finished run as folder/name; its path is to be freed.
static inline char *test_ledger_record(const char *folder, const char *name, const struct test_trainer *trainer,
                                       uint32_t submission) {
    char *path = vw_path_join(folder, name);
    struct vw_ledger *ledger = test_ledger_create(path);
    test_ledger_append(ledger, trainer, submission);
    test_ledger_finish(ledger, "finished");
    vw_ledger_close(&ledger);
    assert_null(ledger);
    return path;
}

static inline void test_count_view(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error) {
    (void)step, (void)image_id, (void)error;
    ++*(uint64_t *)context;
}

// Reads all that is in a ledger, then verifies it.
static inline enum vw_status test_ledger_read(const char *path, uint64_t *step_count) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    const struct vw_ledger_image *images = NULL;
    AUTO_FREE struct vw_step_record *records = NULL;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    AUTO_FREE struct vw_ledger_retraining *retrainings = NULL;
    uint64_t view_count = 0;
    uint32_t image_count = 0, score_count = 0, retraining_count = 0;
    enum vw_status status = vw_ledger_open(path, &ledger);
    if (!status) status = vw_ledger_get_images(ledger, &images, &image_count);
    if (!status) status = vw_ledger_get_steps(ledger, &records, step_count);
    if (!status) status = vw_ledger_get_scores(ledger, &scores, &score_count);
    if (!status) status = vw_ledger_get_retrainings(ledger, &retrainings, &retraining_count);
    if (!status) status = vw_ledger_each_view(ledger, test_count_view, &view_count);
    if (!status) status = vw_ledger_verify(ledger);
    if (!status) assert_true(view_count >= *step_count); // every step is whole
    return status;
}

static inline const struct vw_ledger_score *test_find_score(const struct vw_ledger_score *scores, uint32_t count,
                                                            const char *method, uint32_t image_id) {
    for (uint32_t i = 0; i < count; i++)
        if (scores[i].image_id == image_id && strcmp(scores[i].method, method) == 0) return &scores[i];
    fail_msg("no score %s of image %u", method, image_id);
    return NULL;
}

#endif
