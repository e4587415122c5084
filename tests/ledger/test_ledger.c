// The ledger as an outsider sees it: its rows, its chain recomputed from raw SQL, and what does not open as one.
#include "support/ledger_chain.h"

#include <sys/stat.h>

enum { RECORD_COUNT = 1 + 4 * TEST_TRAIN_COUNT };

FOLDER_TEST(rows_read_back) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    struct vw_ledger *ledger = test_ledger_open(path);
    struct vw_ledger_run run, expected = test_run("{\"burn_in_epochs\": 1}");
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    assert_string_equal(run.run_id, expected.run_id);
    assert_string_equal(run.scene_path, expected.scene_path);
    assert_string_equal(run.config_json, expected.config_json);
    assert_string_equal(run.driver, expected.driver);
    assert_string_equal(run.started_utc, expected.started_utc);
    assert_string_equal(run.scene_options_json, expected.scene_options_json);
    assert_string_equal(run.effects_json, expected.effects_json);
    assert_string_equal(run.plan_json, expected.plan_json);
    assert_string_equal(run.status, "finished");
    assert_true(run.seed == expected.seed);
    assert_int_equal(vw_ledger_next_step(ledger), RECORD_COUNT);

    const struct vw_ledger_image *images = NULL, *again = NULL;
    uint32_t image_count = 0;
    ASSERT_OK(vw_ledger_get_images(ledger, &images, &image_count));
    assert_int_equal(image_count, TEST_IMAGE_COUNT);
    for (uint32_t i = 0; i < image_count; i++) {
        assert_int_equal(images[i].image_id, test_images[i].image_id);
        assert_string_equal(images[i].name, test_images[i].name);
        assert_string_equal(images[i].split, test_images[i].split);
        assert_true(!images[i].ground_truth == !test_images[i].ground_truth &&
                    !images[i].provider == !test_images[i].provider);
    }
    assert_string_equal(images[5].ground_truth, "occluder");
    ASSERT_OK(vw_ledger_get_images(ledger, &again, &image_count));
    assert_ptr_equal(images, again); // lent until closed

    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    const struct vw_step_record *written = recording->records;
    AUTO_FREE struct vw_step_record *read = NULL;
    uint64_t count = 0;
    ASSERT_OK(vw_ledger_get_steps(ledger, &read, &count));
    assert_int_equal(count, RECORD_COUNT);
    for (uint32_t i = 0; i < count; i++) {
        bool nonfinite = i == 7 || i == 8, valued = !nonfinite && i != 12;
        assert_int_equal(read[i].step, i);
        assert_int_equal(read[i].epoch, written[i].epoch);
        assert_int_equal(read[i].view, written[i].view);
        assert_int_equal(read[i].nonfinite, nonfinite);
        assert_int_equal(read[i].validated, valued);
        assert_int_equal(read[i].clamped_count, i);
        assert_int_equal(read[i].floored_views, read[i].nonfinite || !read[i].validated ? 0 : i % 3);
        assert_true(valued ? read[i].val_psnr == written[i].val_psnr : isnan(read[i].val_psnr));
        assert_true(valued ? read[i].val_psnr_pooled == written[i].val_psnr_pooled : isnan(read[i].val_psnr_pooled));
        assert_true(valued ? read[i].val_l1 == written[i].val_l1 : isnan(read[i].val_l1));
        assert_true(i && !nonfinite ? read[i].train_loss == 0.2 : isnan(read[i].train_loss));
        assert_null(read[i].views);
    }
    vw_ledger_close(&ledger);
    vw_ledger_close(&ledger); // NULL is fine
}

static bool same_real(double a, double b) { return a == b || (isnan(a) && !isfinite(b)); }

FOLDER_TEST(scores_read_back) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(path);
    AUTO_FREE struct vw_ledger_score *read = NULL;
    uint32_t count = 0;
    const struct vw_ledger_score *expected[] = {&test_scores[0], &test_scores[1],
                                                &test_scores[2]}; // dv_psnr was written first
    ASSERT_OK(vw_ledger_get_scores(ledger, &read, &count));
    assert_int_equal(count, TEST_SCORE_COUNT);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(read[i].image_id, expected[i]->image_id);
        assert_string_equal(read[i].method, expected[i]->method);
        assert_string_equal(read[i].unit, expected[i]->unit);
        assert_int_equal(read[i].visits, expected[i]->visits);
        assert_true(read[i].value == expected[i]->value);
        assert_true(same_real(read[i].standard_error, expected[i]->standard_error));
        assert_true(same_real(read[i].ci_low, expected[i]->ci_low) && same_real(read[i].ci_high, expected[i]->ci_high));
        assert_int_equal(read[i].rank_ci_low, expected[i]->rank_ci_low);
        assert_int_equal(read[i].rank_ci_high, expected[i]->rank_ci_high);
    }
}

FOLDER_TEST(retrainings_come_back_until_the_run_goes_on) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    AUTO_FREE struct vw_ledger_retraining *read = NULL;
    struct vw_step_record next = {.step = 1 + 4 * TEST_TRAIN_COUNT, .view = 1, .nonfinite = true};
    uint32_t count = 0;
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open_to_append(path);
    ASSERT_OK(vw_ledger_add_retrainings(ledger, test_retraining_store + 1, 1, test_scores, TEST_SCORE_COUNT));
    ASSERT_OK(vw_ledger_get_retrainings(ledger, &read, &count));
    assert_int_equal(count, TEST_RETRAINING_COUNT + 1);
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_ledger_retraining *expected = &test_retraining_store[i < TEST_RETRAINING_COUNT ? i : 1];
        assert_true(read[i].seed == expected->seed);
        assert_true(read[i].epochs == expected->epochs && read[i].image_count == expected->image_count);
        assert_memory_equal(read[i].image_ids, expected->image_ids, expected->image_count * sizeof(uint32_t));
        assert_true(read[i].val_psnr == expected->val_psnr || (isnan(read[i].val_psnr) && isnan(expected->val_psnr)));
    }
    ASSERT_OK(vw_ledger_verify(ledger));
    assert_answer(path, "SELECT status || ' ' || finished_utc FROM run", "finished 2026-11-21T04:00:00Z");
    ASSERT_OK(vw_ledger_append(ledger, &next, 1, test_validation_views));
    assert_answer(path, "SELECT count(*) FROM retraining", "0");
    assert_int_equal(vw_ledger_add_retrainings(ledger, test_retraining_store, 1, NULL, 0), VW_ERROR_USAGE);
}

FOLDER_TEST(tables_are_as_contracted) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    const char *tables[][2] = {
        {"run", "run_id,scene_hash,scene_path,seed,config_json,subset_hash,device,driver,shader_hash,version,started_"
                "utc,finished_utc,"
                "status,row_hash,final_hash,scene_options_json,effects_json,plan_json,field_sha256"},
        {"image", "image_id,scene_hash,name,split,provider,sha256,ground_truth"},
        {"step",
         "run_id,step,epoch,image_id,train_loss,val_psnr,val_psnr_pooled,val_l1,nonfinite,row_hash,clamped,floored"},
        {"view", "run_id,step,image_id,mse,l1"},
        {"score", "run_id,image_id,method,value,unit,stderr,visits,ci_low,ci_high,rank_ci_low,rank_ci_high"},
        {"retraining", "run_id,retraining,seed,epochs,image_ids,val_psnr"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        AUTO_FREE char *sql = vw_format_text(
            "SELECT group_concat(name) FROM (SELECT name FROM pragma_table_info('%s') ORDER BY cid)", tables[i][0]);
        assert_answer(path, sql, tables[i][1]);
    }
    assert_answer(path, "SELECT image_id FROM step WHERE step = 0", "NULL");
    assert_answer(
        path,
        "SELECT count(*) FROM step WHERE step IN (7, 8) AND nonfinite = 1 AND train_loss IS NULL AND val_psnr IS NULL"
        " AND val_psnr_pooled IS NULL AND val_l1 IS NULL",
        "2");
    assert_answer(path, "SELECT count(*) FROM step WHERE nonfinite = 1", "2");
    assert_answer(path, "SELECT count(*) FROM step WHERE step = 12 AND val_psnr IS NULL AND train_loss = 0.2", "1");
    assert_answer(path, "SELECT count(*) FROM view WHERE step IN (7, 8, 12)", "0");
    assert_answer(path, "SELECT count(*) FROM view", "36"); // 2 for each of the other 18 steps
    assert_answer(path, "SELECT group_concat(image_id) FROM view WHERE step = 3", "0,4");
    assert_answer(path, "SELECT status || ' ' || finished_utc FROM run", "finished 2026-11-21T04:00:00Z");
    assert_answer(path, "SELECT seed FROM run", "9223372036854775807");
    assert_answer(path, "SELECT stderr FROM score WHERE image_id = 2", "NULL");
    assert_answer(
        path, "SELECT rank_ci_low IS NULL AND rank_ci_high IS NULL AND ci_low IS NULL FROM score WHERE image_id = 2",
        "1");
    assert_answer(path, "SELECT count(*) FROM score", "3");
    assert_answer(path, "PRAGMA user_version", "3");
    assert_answer(path, "PRAGMA journal_mode", "delete");
    assert_answer(path, "PRAGMA integrity_check", "ok");
    assert_answer(path, "SELECT count(*) FROM pragma_foreign_key_check", "0");
}

FOLDER_TEST(chain_holds_whatever_the_submissions) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6),
                   *other = test_ledger_record(*state, "other.db", &test_four_epochs, 1);
    assert_true(chain_holds(path));
    assert_true(chain_holds(other));
    AUTO_FREE char *head = sql_ask(path, SQL_FINAL_HASH);
    assert_answer(other, SQL_FINAL_HASH, head);
}

// Columns that may differ between two runs of one identity leave the chain of steps alone and change the final hash.
FOLDER_TEST(chain_of_steps_is_the_run) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6),
                   *other = vw_path_join(*state, "other.db");
    struct vw_ledger_run run = test_run("{\"burn_in_epochs\": 1, \"epochs\": 9}");
    run.scene_path = "elsewhere/small.json";
    run.scene_options_json = "{}";
    run.effects_json = "[]";
    run.plan_json = NULL; // nothing was chosen
    run.started_utc = "2027-01-01T00:00:00Z";
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_create(other, &run, test_images, TEST_IMAGE_COUNT, &ledger));
    test_ledger_append(ledger, &test_four_epochs, 6);
    test_ledger_finish(ledger, "finished");
    vw_ledger_close(&ledger);
    assert_true(chain_holds(other));
    AUTO_FREE char *heads = sql_ask(path, SQL_CHAIN);
    assert_answer(other, SQL_CHAIN, heads);
    AUTO_FREE char *final_hash = sql_ask(path, SQL_FINAL_HASH), *other_final_hash = sql_ask(other, SQL_FINAL_HASH);
    assert_string_not_equal(final_hash, other_final_hash);
}

FOLDER_TEST(creating_needs_a_free_place) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    AUTO_FREE char *head = sql_ask(path, SQL_FINAL_HASH);
    struct vw_ledger_run run = test_run("{}");
    struct vw_ledger *ledger = NULL;
    ASSERT_FAILS(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger), VW_ERROR_USAGE, path,
                 "name another folder");
    assert_null(ledger);
    assert_answer(path, SQL_FINAL_HASH, head);

    AUTO_FREE char *missing = vw_path_join(*state, "missing/ledger.db");
    ASSERT_FAILS(vw_ledger_create(missing, &run, test_images, TEST_IMAGE_COUNT, &ledger), VW_ERROR_IO, missing);
}

// An image table that breaks a rule (two images of one name) fails after the run has been begun: nothing may stay.
FOLDER_TEST(a_failed_creation_leaves_nothing) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger_image images[2] = {test_images[0], test_images[1]};
    images[1].name = images[0].name;
    struct vw_ledger_run run = test_run("{}");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(vw_ledger_create(path, &run, images, 2, &ledger), VW_ERROR_IO);
    assert_null(ledger);
    assert_int_equal(rmdir(*state), 0); // empty
    assert_int_equal(mkdir(*state, 0777), 0);
}

FOLDER_TEST(only_ledgers_open) {
    const char *path = temporary_path(*state, "ledger.db");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT); // missing
    assert_false(vw_file_exists(path));
    char text[200];
    memset(text, 'a', sizeof text); // longer than a database header
    temporary_write(path, text, sizeof text);
    ASSERT_FAILS(vw_ledger_open(path, &ledger), VW_ERROR_INPUT, "not a viewworth ledger"); // text
    temporary_write(path, "", 0);
    sql_change(path, "CREATE TABLE run (a); INSERT INTO run VALUES (1); PRAGMA user_version = 0");
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT); // someone else's database
    sql_change(path, "INSERT INTO run VALUES (2); PRAGMA user_version = 3");
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT);

    AUTO_FREE char *recorded = test_ledger_record(*state, "recorded.db", &test_four_epochs, 6);
    sql_change(recorded, "UPDATE run SET seed = 1; PRAGMA user_version = 4");
    ASSERT_FAILS(vw_ledger_open(recorded, &ledger), VW_ERROR_INPUT, "newer viewworth");
    sql_run(recorded, "DROP TABLE lasting_view; PRAGMA user_version = 3");
    ASSERT_FAILS(vw_ledger_open(recorded, &ledger), VW_ERROR_INPUT, "or lacks one");
    assert_null(ledger);
}
