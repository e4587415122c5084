// Hashes of files that a run goes on from, in the chain; and that nothing is written to a ledger that was edited.
#include "support/ledger_chain.h"

static bool is_kept(struct vw_ledger *ledger, const char *name, const char *sha256) {
    bool kept = false;
    ASSERT_OK(vw_ledger_is_kept(ledger, name, sha256, &kept));
    return kept;
}

FOLDER_TEST(the_present_and_the_previous_file_are_known) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    static const char name[] = "checkpoint_0.vwc", third[] = HEX_A "", *const hashes[] = {HEX_A, HEX_B};
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_create(path);
    assert_false(is_kept(ledger, name, HEX_A));
    assert_false(is_kept(ledger, name, ""));
    ASSERT_OK(vw_ledger_keep(ledger, name, hashes[0]));
    assert_true(is_kept(ledger, name, HEX_A) && !is_kept(ledger, name, HEX_B) && !is_kept(ledger, name, ""));
    assert_false(is_kept(ledger, "checkpoint_1.vwc", HEX_A));
    ASSERT_OK(vw_ledger_keep(ledger, name, hashes[1]));
    assert_true(is_kept(ledger, name, HEX_A) && is_kept(ledger, name, HEX_B));
    ASSERT_OK(vw_ledger_keep(ledger, name, hashes[1])); // the same file again
    assert_true(is_kept(ledger, name, third) && is_kept(ledger, name, HEX_B));
    AUTO_FREE char *longer = vw_format_text("c%s", HEX_A + 1);
    ASSERT_OK(vw_ledger_keep(ledger, name, longer));
    assert_true(is_kept(ledger, name, longer) && is_kept(ledger, name, HEX_B) && !is_kept(ledger, name, HEX_A));
    char present[VW_HASH_HEX_BYTES];
    ASSERT_OK(vw_ledger_get_kept(ledger, name, present));
    assert_string_equal(present, longer);
    ASSERT_OK(vw_ledger_get_kept(ledger, "payout", present));
    assert_string_equal(present, "");
    assert_answer(path, "SELECT count(*) FROM kept", "1");
    assert_true(chain_holds(path));
}

FOLDER_TEST(a_run_that_has_ended_keeps_its_scores) {
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    char before[VW_HASH_HEX_BYTES], after[VW_HASH_HEX_BYTES];
    struct vw_ledger *ledger = test_ledger_open_to_append(path);
    vw_ledger_chain_head(ledger, before);
    test_ledger_keep(ledger);
    vw_ledger_chain_head(ledger, after);
    assert_string_not_equal(before, after); // the head represents every row
    ASSERT_OK(vw_ledger_verify(ledger));
    vw_ledger_close(&ledger);
    assert_answer(path, SQL_FINAL_HASH, after);
    assert_answer(path, "SELECT status || ' ' || (SELECT count(*) FROM score) FROM run", "finished 3");
    assert_true(chain_holds(path));
    ledger = test_ledger_open_to_append(path);
    assert_true(is_kept(ledger, "checkpoint_0.vwc", HEX_A) && is_kept(ledger, "retrainings.db/" HEX_A, HEX_A));
    vw_ledger_close(&ledger);
}

// Every later hash would vouch for the edited row.
FOLDER_TEST(an_edited_ledger_is_not_opened_to_append) {
    static const struct {
        const char *sql, *row;
    } edits[] = {
        {"UPDATE step SET train_loss = train_loss + 1 WHERE step = 3", "step 3"},
        {"UPDATE view SET mse = mse + 1 WHERE step = 5", "step 5"},
        {"UPDATE image SET provider = 'mallory' WHERE image_id = 1", "image row"},
        {"UPDATE score SET value = value + 1", "score row"},
        {"UPDATE retraining SET val_psnr = 40", "retraining row"},
        {"UPDATE kept SET sha256 = '" HEX_B "'", "table kept"},
    };
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 6);
    struct vw_ledger *ledger = test_ledger_open_to_append(path);
    ASSERT_OK(vw_ledger_keep(ledger, "checkpoint_0.vwc", HEX_A));
    vw_ledger_close(&ledger);
    for (size_t i = 0; i < VW_ARRAY_COUNT(edits); i++) {
        AUTO_FREE char *edited = vw_format_text("%s-%zu", path, i);
        AUTO_FREE char *copy = vw_format_text("cp '%s' '%s'", path, edited);
        assert_int_equal(system(copy), 0);
        sql_change(edited, edits[i].sql);
        ASSERT_FAILS(vw_ledger_open_to_append(edited, &ledger), VW_ERROR_MISMATCH, edits[i].row);
        assert_non_null(strstr(vw_error_message(), "restore the file from a copy"));
        assert_null(ledger);
        ASSERT_OK(vw_ledger_open(edited, &ledger)); // it can be read
        vw_ledger_close(&ledger);
    }
}
