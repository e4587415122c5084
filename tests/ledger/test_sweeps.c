// The file of a sweep: measurements come back after it is opened again, an edited one is refused, metrics are a plain
// table, and another kind of file is refused.
#include "support/ledger_fixture.h"

#include "ledger/sweeps.h"
#include "support/ledger_sql.h"

static char *path_in(void **state) { return vw_path_join(*state, "tradeoff.db"); }

static struct vw_sweeps *open_sweeps(void **state) {
    struct vw_sweeps *sweeps = NULL;
    AUTO_FREE char *path = path_in(state);
    ASSERT_OK(vw_sweeps_open(path, &sweeps));
    return sweeps;
}

static void assert_measured(struct vw_sweeps *sweeps, const char *id, const char *quantity, double wanted) {
    bool found = false;
    double value = -1;
    ASSERT_OK(vw_sweeps_find(sweeps, id, quantity, &found, &value));
    assert_true(found);
    assert_true(isnan(wanted) ? isnan(value) : value == wanted);
}

static void keep(struct vw_sweeps *sweeps, const char *id, const char *quantity, double value) {
    const struct vw_measurement measurements[] = {{quantity, value}, {"beside", value}};
    ASSERT_OK(vw_sweeps_keep(sweeps, id, measurements, 2));
}

FOLDER_TEST(what_was_measured_comes_back) {
    struct vw_sweeps *sweeps = open_sweeps(state);
    bool found = true;
    double value = -1;
    ASSERT_OK(vw_sweeps_find(sweeps, HEX_A, "train_ms", &found, &value));
    assert_false(found);
    keep(sweeps, HEX_A, "train_ms", 1.0 / 3);
    keep(sweeps, HEX_A, "value_ms", NAN);
    keep(sweeps, HEX_B, "train_ms", 1.0 / 3);
    keep(sweeps, HEX_A, "train_ms", 5); // measured again, all that belongs together is replaced
    vw_sweeps_close(&sweeps);
    assert_null(sweeps);
    sweeps = open_sweeps(state);
    assert_measured(sweeps, HEX_A, "train_ms", 5);
    assert_measured(sweeps, HEX_A, "beside", 5);
    assert_measured(sweeps, HEX_A, "value_ms", NAN);
    assert_measured(sweeps, HEX_B, "train_ms", 1.0 / 3);
    vw_sweeps_close(&sweeps);
}

FOLDER_TEST(what_was_edited_is_not_taken) {
    static const char *const edits[] = {"UPDATE measurement SET value = 2", "UPDATE measurement SET value = NULL",
                                        "UPDATE measurement SET row_hash = 'none'"};
    AUTO(vw_sweeps_close) struct vw_sweeps *sweeps = open_sweeps(state);
    AUTO_FREE char *path = path_in(state);
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
        bool found = false;
        double value;
        keep(sweeps, HEX_A, "train_ms", 1);
        sql_change(path, edits[i]);
        ASSERT_CASE_FAILS(edits[i], vw_sweeps_find(sweeps, HEX_A, "train_ms", &found, &value), VW_ERROR_MISMATCH, path,
                          "train_ms");
        sql_change(path, "DELETE FROM measurement"); // the remedy
    }
}

// Every column with a value of its own, so that none is written in another's place.
FOLDER_TEST(metrics_are_a_plain_table) {
    const struct vw_sweep_metrics metrics[] = {
        {"base", "base", "", 1, 30, 540, 1, 2, 3, 4, 5, 6, 1, "dv_psnr", 0, .1, .2, .3, .4, .5, .6, .7, .8, .9, 1.5},
        {"rays-62", "rays", "62", 0,   30,  540, 1,   2,   3,   4,   5,   6,  0,
         "dv_loss", 1,      NAN,  NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN}};
    struct vw_sweeps *sweeps = open_sweeps(state);
    ASSERT_OK(vw_sweeps_set_metrics(sweeps, HEX_A, metrics, 1));
    ASSERT_OK(vw_sweeps_set_metrics(sweeps, HEX_B, metrics, 1));
    ASSERT_OK(vw_sweeps_set_metrics(sweeps, HEX_A, metrics, 2)); // replaces
    vw_sweeps_close(&sweeps);
    AUTO_FREE char *path = path_in(state);
    assert_answer(path, "SELECT count(*) FROM metric", "3");
    assert_answer(
        path,
        "SELECT configuration || parameter || value || base || epochs || steps || train_ms || value_ms || "
        "scoring_ratio || run_seconds ||"
        " device_mib || val_psnr || psnr_pareto_front || method || score_pareto_front || seed_pearson || seed_spearman "
        "|| agreement_pearson ||"
        " agreement_spearman || all_pixels_pearson || all_pixels_spearman || auc || lds || lds_ci_low || lds_ci_high"
        " FROM metric WHERE place = 0 AND sweep_id LIKE 'a%'",
        "basebase1305401.02.03.04.05.06.01dv_psnr00.10.20.30.40.50.60.70.80.91.5");
    assert_answer(path,
                  "SELECT configuration || score_pareto_front || coalesce(auc, '-') || coalesce(lds_ci_high, '-') FROM "
                  "metric WHERE place = 1",
                  "rays-621--");
}

FOLDER_TEST(what_is_no_such_file_is_refused) {
    static const char text[] = "these are not metrics, though the file is there and is longer than the magic bytes";
    struct vw_sweeps *sweeps = NULL;
    AUTO_FREE char *path = path_in(state);
    ASSERT_OK(vw_file_write(path, text, sizeof text));
    assert_int_equal(vw_sweeps_open(path, &sweeps), VW_ERROR_INPUT);
    assert_null(sweeps);
    unlink(path);
    vw_ledger_close(&(struct vw_ledger *){test_ledger_create(path)});
    ASSERT_FAILS(vw_sweeps_open(path, &sweeps), VW_ERROR_INPUT, path);
}
