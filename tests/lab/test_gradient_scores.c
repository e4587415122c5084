// Scores from gradients of a run that a folder holds: sums over its steps, the same on a repeat, and what is refused.
#include "support/ledger_chain.h"

#include "base/statistics.h"
#include "lab/methods/gradient_scores.h"
#include "run/session.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "viewworth/viewworth.h"

enum { PHOTOS = 6, EPOCHS = 12 };

struct fixture {
    struct vw_session session;
    char *folder;
};

static void make_run(struct fixture *fixture, const char *name, const struct vw_config *config, bool finishes) {
    const struct vw_run_params params = {.scene = {.path = SMALL_SCENE},
                                         .config = config,
                                         .out = temporary_path(fixture->folder, name),
                                         .report.no_thumbnails = true};
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, finishes ? UINT64_MAX : 5));
    if (finishes) ASSERT_OK(vw_run_finish(run));
    vw_run_close(&run);
}

static int set_up(void **state) {
    static struct fixture fixture;
    struct vw_config config = small_config(0, EPOCHS);
    fixture.folder = temporary_folder_create();
    make_run(&fixture, "whole", &config, true);
    make_run(&fixture, "begun", &config, false);
    ASSERT_OK(vw_session_open(&(struct vw_session_params){.scene = {.path = SMALL_SCENE}}, &fixture.session));
    *state = &fixture;
    return 0;
}

static int tear_down(void **state) {
    struct fixture *fixture = *state;
    vw_session_close(&fixture->session);
    temporary_folder_remove(fixture->folder);
    return 0;
}

static struct vw_gradient_scores_params params_of(const struct fixture *fixture, const char *name) {
    return (struct vw_gradient_scores_params){.gpu = fixture->session.devices[0].gpu,
                                              .scene = fixture->session.scene,
                                              .out = temporary_path(fixture->folder, name)};
}

static void read_scores(const struct fixture *fixture, const char *method, double scores[PHOTOS]) {
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_score *rows = NULL;
    uint32_t count = 0, found = 0;
    char path[300];
    snprintf(path, sizeof path, "%s/whole/ledger.db", fixture->folder);
    ASSERT_OK(vw_ledger_open(path, &ledger));
    ASSERT_OK(vw_ledger_get_scores(ledger, &rows, &count));
    for (uint32_t i = 0; i < count; i++) // by method and image_id
        if (!strcmp(rows[i].method, method)) scores[found++] = rows[i].value;
    assert_int_equal(found, PHOTOS);
    free(rows);
    vw_ledger_close(&ledger);
}

static double distance(const double *a, const double *b) {
    double sum = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) sum += fabs(a[i] - b[i]);
    return sum;
}

TEST(all_methods_score_all_photos) {
    const struct fixture *fixture = *state;
    const struct vw_gradient_scores_params params = params_of(fixture, "whole");
    double values[VW_GRADIENT_METHODS][PHOTOS], again[PHOTOS], credit[PHOTOS];
    double *scores[VW_GRADIENT_METHODS], *one[VW_GRADIENT_METHODS] = {[VW_GRADIENT_TRACIN_ADAM] = again};
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++) scores[m] = values[m];
    ASSERT_OK(vw_gradient_scores_make(&params, scores, NULL));
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++)
        for (uint32_t i = 0; i < PHOTOS; i++) assert_true(isfinite(values[m][i]));
    ASSERT_OK(vw_gradient_scores_make(&params, one, NULL));
    assert_memory_equal(again, values[VW_GRADIENT_TRACIN_ADAM], sizeof again);
    read_scores(fixture, "dv_psnr", credit); // the changes that the steps really made, over the same epochs
    assert_true(vw_pearson(values[VW_GRADIENT_IN_RUN_SECOND], credit, PHOTOS) > 0.99);
    double first = distance(values[VW_GRADIENT_IN_RUN_FIRST], credit),
           second = distance(values[VW_GRADIENT_IN_RUN_SECOND], credit), size = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) size += fabs(credit[i]);
    assert_true(second < 0.1 * first);
    assert_true(second < 0.01 * size);
}

static bool stop(void *context) {
    (void)context;
    return true;
}

// The first call computes; the second takes what the table says. One that is damaged or of another run counts for
// nothing.
TEST(known_scores_are_not_computed_again) {
    const struct fixture *fixture = *state;
    struct vw_gradient_scores_params params = params_of(fixture, "whole");
    double made[PHOTOS], read[PHOTOS], seconds[VW_GRADIENT_METHODS], read_seconds[VW_GRADIENT_METHODS];
    double *scores[VW_GRADIENT_METHODS] = {[VW_GRADIENT_TRACIN] = made},
           *other[VW_GRADIENT_METHODS] = {[VW_GRADIENT_TRACIN] = read};
    char path[300], edited[320], command[1400];
    snprintf(path, sizeof path, "%s/scores.csv", fixture->folder);
    snprintf(edited, sizeof edited, "%s.edited", path);
    params.store = path;
    ASSERT_OK(vw_gradient_scores_make(&params, scores, seconds));
    assert_true(seconds[VW_GRADIENT_TRACIN] > 0 && isnan(seconds[VW_GRADIENT_INFLUENCE]));
    params.interrupt.requested = stop; // a replay would ask
    ASSERT_OK(vw_gradient_scores_make(&params, other, read_seconds));
    assert_memory_equal(made, read, sizeof made);
    assert_true(seconds[VW_GRADIENT_TRACIN] == read_seconds[VW_GRADIENT_TRACIN]);
    static const char *const edits[] = {"s/^[0-9a-f]*,/ffff,/", "s/,72,/,36,/",   "3d",
                                        "2s/tracin/other/",     "$s/,[^,]*$/,x/", "1s/score/value/"};
    params.store = edited;
    for (size_t i = 0; i < VW_ARRAY_COUNT(edits); i++) {
        snprintf(command, sizeof command, "sed '%s' '%s' >'%s' && ! cmp -s '%s' '%s'", edits[i], path, edited, path,
                 edited);
        assert_int_equal(system(command), 0);
        if (vw_gradient_scores_make(&params, other, NULL) != VW_ERROR_INTERRUPTED) fail_msg("%s counts", edits[i]);
    }
    params.interrupt.requested = NULL;
    memset(read, 0, sizeof read);
    ASSERT_OK(vw_gradient_scores_make(&params, other, NULL)); // mends the last one
    params.interrupt.requested = stop;
    ASSERT_OK(vw_gradient_scores_make(&params, other, NULL));
    assert_memory_equal(made, read, sizeof made);
}

TEST(what_cannot_be_replayed_is_refused) {
    const struct fixture *fixture = *state;
    double values[PHOTOS];
    double *scores[VW_GRADIENT_METHODS] = {[VW_GRADIENT_INFLUENCE] = values};
    struct vw_gradient_scores_params params = params_of(fixture, "begun");
    ASSERT_FAILS(vw_gradient_scores_make(&params, scores, NULL), VW_ERROR_USAGE, "not finished");
    params = params_of(fixture, "whole");
    params.interrupt.requested = stop;
    assert_int_equal(vw_gradient_scores_make(&params, scores, NULL), VW_ERROR_INTERRUPTED);
    params.interrupt.requested = NULL;
    struct vw_session other = {0};
    ASSERT_OK(
        vw_session_open(&(struct vw_session_params){.scene = {.path = VW_SOURCE_FOLDER "/scenes/eight.json"}}, &other));
    params.scene = other.scene;
    ASSERT_FAILS(vw_gradient_scores_make(&params, scores, NULL), VW_ERROR_USAGE, "another scene");
    vw_session_close(&other);
}

TEST(an_edited_ledger_is_a_mismatch) {
    const struct fixture *fixture = *state;
    double values[PHOTOS];
    double *scores[VW_GRADIENT_METHODS] = {[VW_GRADIENT_IN_RUN_FIRST] = values};
    char command[700];
    snprintf(command, sizeof command, "cp -r '%s/whole' '%s/edited'", fixture->folder, fixture->folder);
    assert_int_equal(system(command), 0);
    sql_change(temporary_path(fixture->folder, "edited/ledger.db"),
               "UPDATE step SET train_loss = train_loss * 1.001 WHERE step = 40");
    chain_rewrite(temporary_path(fixture->folder, "edited/ledger.db"));
    const struct vw_gradient_scores_params params = params_of(fixture, "edited");
    ASSERT_FAILS(vw_gradient_scores_make(&params, scores, NULL), VW_ERROR_MISMATCH, "step 40");
}

TEST_GROUP(set_up, tear_down)
