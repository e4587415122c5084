// What the tests around the ledger share: a folder of their own, a small scene, and a fake trainer.
#ifndef VIEWWORTH_TESTS_LEDGER_FIXTURE_H
#define VIEWWORTH_TESTS_LEDGER_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <ftw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "viewworth/ledger.h"
#include "viewworth/memory.h"
#include "viewworth/random.h"

#define ASSERT_OK(call)                                                                                                                    \
    do {                                                                                                                                   \
        enum vw_status status_of_call = (call);                                                                                            \
        if (status_of_call) fail_msg("%s gave %d: %s", #call, (int)status_of_call, vw_error_message());                                    \
    } while (0)

#define HEX_A "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
#define HEX_B "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"

static inline char *test_folder_create(void) {
    const char *parent = getenv("TMPDIR");
    char *folder = vw_format_text("%s/viewworth-test-XXXXXX", parent ? parent : "/tmp");
    assert_non_null(folder);
    assert_non_null(mkdtemp(folder));
    return folder;
}

static inline int test_remove_entry(const char *path, const struct stat *info, int type, struct FTW *place) {
    (void)info, (void)type, (void)place;
    return remove(path);
}

static inline void test_folder_destroy(char *folder) {
    nftw(folder, test_remove_entry, 8, FTW_DEPTH | FTW_PHYS);
    free(folder);
}

// cmocka set-up and tear-down: the state is a fresh folder.
static inline int test_set_up(void **state) {
    *state = test_folder_create();
    return 0;
}
static inline int test_tear_down(void **state) {
    test_folder_destroy(*state);
    return 0;
}

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
    };
}

// Views 0 and 4 validate, 7 is for testing, the others train; 2 and 5 are spoiled.
enum { TEST_IMAGE_COUNT = 8, TEST_TRAIN_COUNT = 5, TEST_VALIDATION_COUNT = 2 };
static const uint32_t test_train_views[TEST_TRAIN_COUNT] = {1, 2, 3, 5, 6};
static const uint32_t test_validation_views[TEST_VALIDATION_COUNT] = {0, 4};
static const struct vw_ledger_image test_images[TEST_IMAGE_COUNT] = {
    {0, "images/0.png", "val", NULL, HEX_A, "clean"},      {1, "images/1.png", "train", "alice", HEX_A, "clean"},
    {2, "images/2.png", "train", "bob", HEX_A, "blur"},    {3, "images/3.png", "train", NULL, HEX_A, "clean"},
    {4, "images/4.png", "val", NULL, HEX_A, "clean"},      {5, "images/5.png", "train", "bob", HEX_A, "occluder"},
    {6, "images/6.png", "train", "alice", HEX_A, "clean"}, {7, "images/7.png", "test", NULL, HEX_A, NULL},
};

// A trainer whose photos are worth what `worth_db` says: each visit of train photo i moves val_psnr by worth_db[i] plus noise
// of +-noise_db, L1 by a hundredth of it the other way, and the pooled PSNR by twice it. Gives 1 + epochs * TEST_TRAIN_COUNT records.
struct test_trainer {
    double worth_db[TEST_TRAIN_COUNT];
    double noise_db;
    double first_epoch_factor; // deltas of epoch 0 are this much larger
    uint32_t epochs;
    uint64_t seed;
};

static inline uint32_t test_train(const struct test_trainer *trainer, struct vw_step_record *records, struct vw_view_error *errors) {
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
        errors[2 * step] = (struct vw_view_error){.mse = 0.01 + step, .l1 = l1};
        errors[2 * step + 1] = (struct vw_view_error){.mse = -0.0, .l1 = 0.125}; // SQLite keeps no negative zero
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

static inline const struct vw_ledger_score *test_find_score(const struct vw_ledger_score *scores, uint32_t count, const char *method,
                                                            uint32_t image_id) {
    for (uint32_t i = 0; i < count; i++)
        if (scores[i].image_id == image_id && strcmp(scores[i].method, method) == 0) return &scores[i];
    fail_msg("no score %s of image %u", method, image_id);
    return NULL;
}

#endif
