// The file of retrainings: appended rows come back after it is opened again, and other files are refused.
#include "support/ledger_fixture.h"

#include "ledger/retraining.h"
#include "support/ledger_sql.h"

static struct vw_retraining_store *open_retrainings(const char *folder) {
    struct vw_retraining_store *retrainings = NULL;
    AUTO_FREE char *path = vw_path_join(folder, "retrainings.db");
    ASSERT_OK(vw_retraining_store_open(path, &retrainings));
    return retrainings;
}

static void assert_count(const char *folder, const char *count) {
    AUTO_FREE char *path = vw_path_join(folder, "retrainings.db");
    assert_answer(path, "SELECT count(*) FROM retraining", count);
}

static const uint32_t views[] = {1, 3, 17};
static const struct vw_retrain_params retraining = {.views = views, .view_count = 3, .seed = 5, .epochs = 30};
static const struct vw_retrain_result outcome = {.val_psnr = 20.125,
                                                 .val_ssim = 0.75,
                                                 .val_l1 = 0.1,
                                                 .test_psnr = NAN,
                                                 .test_ssim = 0.625,
                                                 .test_l1 = 1.0 / 3,
                                                 .seconds = 2.5};

static const struct vw_retrain_view reached[] = {{4, 19.5}, {9, 20.75}};

FOLDER_TEST(what_single_photos_reach_comes_back) {
    struct vw_retrain_view found[] = {{9, 0}, {4, 0}};
    AUTO(vw_retraining_store_close) struct vw_retraining_store *retrainings = open_retrainings(*state);
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
    ASSERT_OK(vw_retraining_store_find_views(retrainings, HEX_A, found, 2));
    assert_true(found[0].psnr_db == 20.75 && found[1].psnr_db == 19.5);
    AUTO_FREE char *path = vw_path_join(*state, "retrainings.db");
    sql_change(path, "UPDATE view SET psnr = 30 WHERE image_id = 4");
    ASSERT_OK(vw_retraining_store_find_views(retrainings, HEX_A, found, 1));
    ASSERT_FAILS(vw_retraining_store_find_views(retrainings, HEX_A, found, 2), VW_ERROR_MISMATCH,
                 "photo 4 in table view was edited");
    bool all = true;
    found[0].image_id = 5;
    ASSERT_OK(vw_retraining_store_recall_views(retrainings, HEX_A, found, 1, &all));
    assert_false(all);
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome,
                                      &(struct vw_retrain_view){6, 18.5},
                                      1)); // a photo that was asked for later
    found[1].image_id = 6;
    ASSERT_OK(vw_retraining_store_recall_views(retrainings, HEX_A, &found[1], 1, &all));
    assert_true(all && found[1].psnr_db == 18.5);
    found[1].image_id = 4;
    assert_int_equal(vw_retraining_store_recall_views(retrainings, HEX_A, &found[1], 1, &all), VW_ERROR_MISMATCH);
    ASSERT_FAILS(vw_retraining_store_find_views(retrainings, HEX_A, found, 1), VW_ERROR_MISMATCH,
                 "photo 5 in table view is missing");
}

FOLDER_TEST(retrainings_come_back) {
    struct vw_retraining_store *retrainings = open_retrainings(*state);
    struct vw_retrain_result found_outcome = {0};
    bool found = true;
    ASSERT_OK(vw_retraining_store_find(retrainings, HEX_A, &found, &found_outcome));
    assert_false(found);
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
    vw_retraining_store_close(&retrainings);
    assert_null(retrainings);
    retrainings = open_retrainings(*state);
    assert_count(*state, "1");
    ASSERT_OK(vw_retraining_store_find(retrainings, HEX_A, &found, &found_outcome));
    assert_true(found);
    assert_true(found_outcome.val_psnr == outcome.val_psnr && found_outcome.val_l1 == outcome.val_l1);
    assert_true(found_outcome.val_ssim == outcome.val_ssim && found_outcome.test_ssim == outcome.test_ssim);
    assert_true(isnan(found_outcome.test_psnr) && found_outcome.test_l1 == outcome.test_l1 &&
                found_outcome.seconds == 2.5);
    ASSERT_OK(vw_retraining_store_find(retrainings, HEX_B, &found, &found_outcome));
    assert_false(found);
    vw_retraining_store_close(&retrainings);
}

FOLDER_TEST(the_first_outcome_of_a_retraining_stays) {
    AUTO(vw_retraining_store_close) struct vw_retraining_store *retrainings = open_retrainings(*state);
    struct vw_retrain_result other = outcome, found_outcome = {0};
    bool found = false;
    other.val_psnr = 1;
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &other, reached, 2));
    assert_count(*state, "1");
    ASSERT_OK(vw_retraining_store_find(retrainings, HEX_A, &found, &found_outcome));
    assert_true(found_outcome.val_psnr == outcome.val_psnr);
}

FOLDER_TEST(an_edited_retraining_is_not_recalled) {
    static const char *const edits[] = {
        "UPDATE retraining SET val_psnr = 20.25",  "UPDATE retraining SET test_psnr = 0",
        "UPDATE retraining SET views = '1 3 18'",  "UPDATE retraining SET val_ssim = 0.5",
        "UPDATE retraining SET test_ssim = NULL",  "UPDATE retraining SET seed = 6",
        "UPDATE retraining SET epochs = 31",       "UPDATE retraining SET seconds = NULL",
        "UPDATE retraining SET row_hash = 'none'",
    };
    AUTO(vw_retraining_store_close) struct vw_retraining_store *retrainings = open_retrainings(*state);
    AUTO_FREE char *path = vw_path_join(*state, "retrainings.db");
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
        struct vw_retrain_result found_outcome;
        bool found = false;
        ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
        ASSERT_OK(vw_retraining_store_find(retrainings, HEX_A, &found, &found_outcome));
        sql_change(path, edits[i]);
        ASSERT_CASE_FAILS(edits[i], vw_retraining_store_find(retrainings, HEX_A, &found, &found_outcome),
                          VW_ERROR_MISMATCH, path, HEX_A);
        sql_change(path, "DELETE FROM retraining"); // the remedy
    }
}

FOLDER_TEST(rows_are_plain_tables) {
    struct vw_retraining_store *retrainings = open_retrainings(*state);
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
    vw_retraining_store_close(&retrainings);
    AUTO_FREE char *path = vw_path_join(*state, "retrainings.db");
    assert_answer(path, "SELECT views || '|' || view_count || '|' || seed || '|' || epochs FROM retraining",
                  "1 3 17|3|5|30");
}

// Checks that a file with these bytes is refused, and left as it was.
static void refuse(const char *path, const void *bytes, size_t size_bytes) {
    struct vw_retraining_store *retrainings = NULL;
    size_t after_bytes = 0;
    ASSERT_OK(vw_file_write(path, bytes, size_bytes));
    assert_int_equal(vw_retraining_store_open(path, &retrainings), VW_ERROR_INPUT);
    assert_null(retrainings);
    AUTO_FREE void *after = temporary_read(path, &after_bytes);
    assert_int_equal(after_bytes, size_bytes);
    assert_memory_equal(after, bytes, size_bytes);
}

FOLDER_TEST(what_is_no_file_of_retrainings_is_refused) {
    AUTO_FREE char *path = vw_path_join(*state, "retrainings.db");
    size_t size_bytes = 0;
    struct vw_retraining_store *retrainings = open_retrainings(*state);
    ASSERT_OK(vw_retraining_store_add(retrainings, HEX_A, HEX_B, &retraining, &outcome, reached, 2));
    vw_retraining_store_close(&retrainings);
    AUTO_FREE unsigned char *damaged = temporary_read(path, &size_bytes);
    memset(damaged + 100, 0x5a, 200); // the schema's page, after the header
    refuse(path, damaged, size_bytes);
    const char text[] = "these are not retrainings, though the file is there and is longer than the magic bytes";
    refuse(path, text, sizeof text);
    refuse(path, "", 0); // the file appears with its tables, so that no killed program leaves an empty one
}

FOLDER_TEST(a_ledger_is_no_file_of_retrainings) {
    AUTO_FREE char *path = test_ledger_record(*state, "retrainings.db", &test_four_epochs, 6);
    struct vw_retraining_store *retrainings = NULL;
    assert_int_equal(vw_retraining_store_open(path, &retrainings), VW_ERROR_INPUT);
}
