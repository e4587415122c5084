// vw_ledger_compare: steps that were taken again are held against the recorded ones, bit for bit.
#include "support/ledger_sql.h"

enum { RECORD_COUNT = 1 + 4 * TEST_TRAIN_COUNT };

static struct test_recording *take_steps(void) {
    struct test_recording *recording = test_record(&test_four_epochs);
    test_corruption(recording);
    return recording;
}

static struct vw_ledger *record_all(const char *path) {
    AUTO_FREE struct test_recording *recording = take_steps();
    struct vw_ledger *ledger = test_ledger_create(path);
    ASSERT_OK(vw_ledger_append(ledger, recording->records, RECORD_COUNT, test_validation_views));
    test_ledger_finish(ledger, "finished");
    return ledger;
}

FOLDER_TEST(the_same_steps_compare_equal) {
    const char *path = temporary_path(*state, "ledger.db");
    struct vw_ledger *ledger = record_all(path);
    AUTO_FREE struct test_recording *again = take_steps();
    AUTO_FREE char *final_hash = sql_ask(path, SQL_FINAL_HASH);
    for (uint32_t first = 0; first <= RECORD_COUNT; first++)
        for (uint32_t count = 0; count <= RECORD_COUNT - first; count++)
            ASSERT_OK(vw_ledger_compare(ledger, &again->records[first], count, test_validation_views));
    assert_answer(path, SQL_FINAL_HASH, final_hash); // it only looks
    assert_answer(path, "SELECT count(*) FROM step", "21");

    vw_ledger_close(&ledger);
    ASSERT_OK(vw_ledger_open(path, &ledger));
    ASSERT_OK(vw_ledger_compare(ledger, again->records, RECORD_COUNT, test_validation_views));
    vw_ledger_close(&ledger);
}

FOLDER_TEST(only_recorded_steps_can_be_compared) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    AUTO_FREE struct test_recording *recording = take_steps();
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_create(path);
    assert_int_equal(vw_ledger_compare(ledger, recording->records, 1, test_validation_views), VW_ERROR_USAGE);
    ASSERT_OK(vw_ledger_append(ledger, recording->records, 6, test_validation_views));
    ASSERT_OK(vw_ledger_compare(ledger, recording->records, 6, test_validation_views));
    assert_int_equal(vw_ledger_compare(ledger, recording->records, 7, test_validation_views), VW_ERROR_USAGE);
    assert_int_equal(vw_ledger_compare(ledger, &recording->records[6], 1, test_validation_views), VW_ERROR_USAGE);
    recording->records[3].step++;
    assert_int_equal(vw_ledger_compare(ledger, &recording->records[2], 3, test_validation_views), VW_ERROR_USAGE);
}

static double next_double(double value) { return nextafter(value, 1e300); }

// Changes one thing about a step that has a value, reals by one unit in the last place; NULL when there are
// no more.
static const char *change_field(struct test_recording *recording, uint32_t step, uint32_t *views, uint32_t which) {
    struct vw_step_record *record = &recording->records[step];
    struct vw_view_error *errors = &recording->errors[2 * step];
    switch (which) {
    case 0: return record->epoch++, "epoch";
    case 1: return record->view ^= 1, "view";
    case 2: return record->view = VW_RECORD_UNTRAINED, "view of the untrained field";
    case 3: return record->train_loss = next_double(record->train_loss), "train_loss";
    case 4: return record->validated = false, "validated";
    case 5: return record->nonfinite = true, "nonfinite";
    case 6: return record->clamped_count++, "clamped_count";
    case 7: return record->floored_views++, "floored_views";
    case 8: return record->val_psnr = next_double(record->val_psnr), "val_psnr";
    case 9: return record->val_psnr_pooled = next_double(record->val_psnr_pooled), "val_psnr_pooled";
    case 10: return record->val_l1 = next_double(record->val_l1), "val_l1";
    case 11: return errors[0].mse = next_double(errors[0].mse), "mse of the first view";
    case 12: return errors[0].l1 = next_double(errors[0].l1), "l1 of the first view";
    case 13: return errors[1].mse = next_double(errors[1].mse), "mse of the last view";
    case 14: return errors[1].l1 = next_double(errors[1].l1), "l1 of the last view";
    case 15: return record->view_count--, "view_count";
    case 16: return views[1]++, "image_id of the last view";
    default: return NULL;
    }
}

FOLDER_TEST(each_change_of_a_step_is_found) {
    const uint32_t steps[] = {3, 9, 18};
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record_all(temporary_path(*state, "ledger.db"));
    for (size_t s = 0; s < VW_ARRAY_COUNT(steps); s++)
        for (uint32_t which = 0;; which++) {
            AUTO_FREE struct test_recording *again = take_steps();
            uint32_t views[TEST_VALIDATION_COUNT];
            memcpy(views, test_validation_views, sizeof views);
            const char *field = change_field(again, steps[s], views, which);
            if (field) {
                // The comparison begins some steps before it; a change of the views' ids shows at once, as it is one of
                // all steps.
                uint32_t first = views[1] == test_validation_views[1] ? steps[s] - 2 : steps[s];
                AUTO_FREE char *name = vw_format_text("step %u", steps[s]);
                ASSERT_CASE_FAILS(field, vw_ledger_compare(ledger, &again->records[first], RECORD_COUNT - first, views),
                                  VW_ERROR_MISMATCH, name);
            }
            if (!field) break;
        }
}

// Values that the ledger does not keep, because the step has none, cannot differ.
FOLDER_TEST(steps_without_a_value_compare_by_what_is_kept) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record_all(temporary_path(*state, "ledger.db"));
    AUTO_FREE struct test_recording *again = take_steps();
    again->records[7].val_psnr = again->records[7].train_loss = -1; // flagged
    again->records[8].val_psnr = NAN;                               // a view of it is not finite
    again->records[12].floored_views++;                             // not validated
    ASSERT_OK(vw_ledger_compare(ledger, again->records, RECORD_COUNT, test_validation_views));
    again->records[7].clamped_count++;
    ASSERT_FAILS(vw_ledger_compare(ledger, again->records, RECORD_COUNT, test_validation_views), VW_ERROR_MISMATCH,
                 "step 7,");
    again->records[7].clamped_count--;
    again->records[8].val_psnr = again->errors[2 * 8].mse = 1; // became finite
    ASSERT_FAILS(vw_ledger_compare(ledger, again->records, RECORD_COUNT, test_validation_views), VW_ERROR_MISMATCH,
                 "step 8,");
}
