// The step logs of other trainers: what is read, every refusal with its line, damaged files, and that a run of ours
// comes back.
#include "support/ledger_fixture.h"

#include <time.h>

#include "ledger/step_log.h"
#include "viewworth/value.h"

static const char *write_log(const char *folder, const char *text) { return temporary_file(folder, "log.csv", text); }

static struct vw_step_log read_log(const char *path) {
    struct vw_step_log log;
    ASSERT_OK(vw_step_log_read(path, &log));
    return log;
}

static void check_record(const struct vw_step_record *record, uint64_t step, uint32_t epoch, uint32_t view, double psnr,
                         double l1) {
    assert_true(record->step == step && record->epoch == epoch && record->view == view);
    assert_true(isnan(psnr) ? isnan(record->val_psnr) : record->val_psnr == psnr);
    assert_true(isnan(l1) ? isnan(record->val_l1) : record->val_l1 == l1);
    assert_int_equal(record->validated, !isnan(psnr));
    assert_true(isnan(record->val_psnr_pooled) && isnan(record->train_loss) && record->view_count == 0);
}

// Photos b.png and "a, too.png" in two epochs; a.png is the second by name.
FOLDER_TEST(columns_come_in_any_order) {
    static const char *const texts[] = {
        "step,epoch,photo,psnr,l1\n0,0,,10,0.5\n1,0,b.png,11,0.4\n2,0,\"a, "
        "too.png\",10.5,0.45\n3,1,b.png,12,0.25\n",
        "l1,psnr,photo,epoch,step\r\n0.5,10,,0,0\r\n\r\n0.4,11,b.png,0,1\r\n0.45,10.5,\"a, "
        "too.png\",0,2\r\n0.25,12,b.png,1,3",
        "\xef\xbb\xbfnote,photo,step,lr,epoch,l1,psnr\n,,0,1,0,0.5,10\n\"a "
        "\"\"b\"\"\nc\",b.png,1,x,0,.4,1.1e1\n,\"a, "
        "too.png\",2,,0,45e-2,10.5\n"
        ",b.png,3,,1,0.25,12\n",
        "step,epoch,photo,psnr,l1\n0,0,ignored.png,10,0.5\n1,0,b.png,11,0.4\n2,0,\"a, "
        "too.png\",10.5,0.45\n3,1,b.png,12,0.25\n",
        "step,epoch,photo,psnr,l1\n0,9,,10,0.5\n1,7,b.png,11,0.4\n2,7,\"a, "
        "too.png\",10.5,0.45\n3,8,b.png,12,0.25\n", // epochs from 7
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(texts); i++) {
        AUTO(vw_step_log_clear) struct vw_step_log log = read_log(write_log(*state, texts[i]));
        assert_int_equal(log.image_count, 2);
        assert_string_equal(log.images[0].name, "a, too.png");
        assert_string_equal(log.images[1].name, "b.png");
        for (uint32_t image = 0; image < 2; image++) {
            assert_int_equal(log.images[image].image_id, image);
            assert_string_equal(log.images[image].split, "train");
        }
        assert_int_equal(log.epochs, 2);
        assert_int_equal(log.record_count, 4);
        check_record(&log.records[0], 0, 0, VW_RECORD_UNTRAINED, 10, 0.5);
        check_record(&log.records[1], 1, 0, 1, 11, 0.4);
        check_record(&log.records[2], 2, 0, 0, 10.5, 0.45);
        check_record(&log.records[3], 3, 1, 1, 12, 0.25);
    }
}

// A log may begin with step 1, with a photo or, for the state before training, without one.
FOLDER_TEST(the_untrained_state_may_be_missing) {
    struct vw_step_log log = read_log(write_log(*state, "step,epoch,photo,psnr,l1\n1,0,a,11,0.4\n2,1,a,12,0.3\n"));
    assert_int_equal(log.record_count, 3);
    check_record(&log.records[0], 0, 0, VW_RECORD_UNTRAINED, NAN, NAN);
    check_record(&log.records[1], 1, 0, 0, 11, 0.4);
    vw_step_log_clear(&log);
    log = read_log(write_log(*state, "step,epoch,photo,psnr,l1\n1,0,,11,0.4\n2,0,a,12,0.3\n"));
    assert_int_equal(log.record_count, 3);
    check_record(&log.records[1], 1, 0, VW_RECORD_UNTRAINED, 11, 0.4);
    check_record(&log.records[2], 2, 0, 0, 12, 0.3);
    vw_step_log_clear(&log);
}

FOLDER_TEST(values_may_be_missing_or_not_finite) {
    AUTO(vw_step_log_clear)
    struct vw_step_log log =
        read_log(write_log(*state, "step,epoch,photo,psnr,l1\n0,0,,10,0.5\n1,0,a,,\n2,0,b,nan,0.4\n3,0,a,12,inf\n"
                                   "4,0,b,-Infinity,NaN\n5,0,a,-1e4,1e4\n"));
    static const bool flagged[] = {false, false, true, true, true, false};
    for (uint32_t i = 0; i < log.record_count; i++) {
        assert_int_equal(log.records[i].nonfinite, flagged[i]);
        assert_int_equal(log.records[i].validated, !flagged[i]); // step 1 has a share
        assert_int_equal(isnan(log.records[i].val_psnr), flagged[i]);
    }
    check_record(&log.records[5], 5, 0, 0, -1e4, 1e4); // the most that is read
}

// Steps between two validations share the change, those at both ends have no values, and a flagged step keeps none.
FOLDER_TEST(steps_share_a_change) {
    AUTO(vw_step_log_clear)
    struct vw_step_log log =
        read_log(write_log(*state, "step,epoch,photo,psnr,l1\n1,0,a,,\n2,0,b,10,0.5\n3,0,a,,\n4,0,b,nan,0.4\n5,0,a,,\n"
                                   "6,0,b,16,0.125\n7,0,a,17,0.5\n8,0,b,,\n9,0,a,19,0.25\n10,0,b,,\n"));
    static const double psnr[] = {NAN, NAN, 10, 12, NAN, 14, 16, 17, 18, 19, NAN},
                        l1[] = {NAN, NAN, 0.5, 0.375, NAN, 0.25, 0.125, 0.5, 0.375, 0.25, NAN};
    assert_int_equal(log.record_count, VW_ARRAY_COUNT(psnr));
    for (uint32_t i = 0; i < log.record_count; i++)
        check_record(&log.records[i], i, 0, i ? i % 2 ? 0 : 1 : VW_RECORD_UNTRAINED, psnr[i], l1[i]);
    assert_int_equal(log.shared_count, 3);
    assert_int_equal(log.validated_every, 4);
}

FOLDER_TEST(malformed_lines_are_refused) {
#define HEADER "step,epoch,photo,psnr,l1\n"
    static const struct {
        const char *text, *said;
    } cases[] = {
        {"", "log.csv:1: the header lacks the column step"},
        {"step,epoch,photo,l1\n0,0,a,1\n", "log.csv:1: the header lacks the column psnr"},
        {"\n\nstep;epoch;photo;psnr;l1\n", "log.csv:3: the header lacks the column step"},
        {"Step,epoch,photo,psnr,l1\n", "log.csv:1: the header lacks the column step"},
        {"step,epoch,photo,psnr,l1,psnr\n", "log.csv:1: the header has more than one column psnr"},
        {HEADER, "log.csv: no step has a photo"},
        {HEADER "0,0,,10,0.5\n", "log.csv: no step has a photo"},
        {HEADER "0,0,,10,0.5\n1,0,a,11\n", "log.csv:3: 4 fields, but the header has 5 columns"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,0.4,7\n", "log.csv:3: 6 fields, but the header has 5 columns"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,0.4\n2,0,a", "log.csv:4: 3 fields"}, // cut off
        {HEADER "0,0,,10,0.5\n1,0,\"a,11,0.4\n2,0,a,12,0.3\n", "log.csv:3: a quote is not closed"},
        {HEADER "0,0,,10,0.5\n1,0,a\"b,11,0.4\n", "log.csv:3: a quote within a field"},
        {HEADER "0,0,,10,0.5\nx,0,a,11,0.4\n", "log.csv:3: field step: \"x\" is not a whole number"},
        {HEADER "0,0,,10,0.5\n-1,0,a,11,0.4\n", "log.csv:3: field step: \"-1\" is not a whole number"},
        {HEADER "0,0,,10,0.5\n1.0,0,a,11,0.4\n", "log.csv:3: field step: \"1.0\" is not a whole number"},
        {HEADER "0,0,,10,0.5\n,0,a,11,0.4\n", "log.csv:3: field step: \"\" is not a whole number"},
        {HEADER "0,0,,10,0.5\n99999999999999999999,0,a,11,0.4\n",
         "log.csv:3: field step: \"99999999999999999999\" is too large"},
        {HEADER "5,0,a,10,0.5\n", "log.csv:2: field step: the first step is 5"},
        {HEADER "0,0,,10,0.5\n2,0,a,11,0.4\n", "log.csv:3: field step: step 2 follows step 0"},
        {HEADER "1,0,a,10,0.5\n3,0,a,11,0.4\n", "log.csv:3: field step: step 3 follows step 1"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,0.4\n1,0,a,11,0.4\n", "log.csv:4: field step: step 1 follows step 1; sort"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,0.4\n2,0,a,11,0.4\n\n1,0,a,11,0.4\n",
         "log.csv:6: field step: step 1 follows step 2; sort"},
        {HEADER "0,0,,10,0.5\n1,one,a,11,0.4\n", "log.csv:3: field epoch: \"one\" is not a whole number"},
        {HEADER "0,0,,10,0.5\n1,4294967295,a,11,0.4\n", "log.csv:3: field epoch: \"4294967295\" is too large"},
        {HEADER "1,3,a,11,0.4\n2,5,a,11,0.4\n3,7,a,11,0.4\n",
         "log.csv:4: field epoch: \"7\" is an epoch too late: by step N at most N epochs"},
        {HEADER "0,0,,10,0.5\n1,1,a,11,0.4\n2,0,a,11,0.4\n",
         "log.csv:4: field epoch: \"0\" is smaller than in the row before"},
        {HEADER "0,0,,10,0.5\n1,3,a,11,0.4\n2,5,a,11,0.4\n3,4,a,11,0.4\n", "log.csv:5: field epoch: \"4\" is smaller"},
        {HEADER "0,0,,10,0.5\n1,0,,11,0.4\n", "log.csv:3: field photo: \"\" is empty"},
        {HEADER "0,0,,10,0.5\n1,0,\"a\nb\",11,0.4\n", "log.csv:3: field photo: \"a?b\" is not a valid name"},
        {HEADER "0,0,,10,0.5\n1,0,\xff,11,0.4\n", "log.csv:3: field photo"},
        {HEADER "0,0,,10,0.5\n1,0,a,11 dB,0.4\n", "log.csv:3: field psnr: \"11 dB\" is not a number"},
        {HEADER "0,0,,10,0.5\n1,0,a, 11,0.4\n", "log.csv:3: field psnr: \" 11\" is not a number"},
        {HEADER "0,0,,10,0.5\n1,0,a,1e999,0.4\n", "log.csv:3: field psnr: \"1e999\" is too large"},
        {HEADER "0,0,,10,0.5\n1,0,a,1e200,0.4\n", "log.csv:3: field psnr: \"1e200\" is too large"},
        {HEADER "0,0,,10,0.5\n1,0,a,-10000.1,0.4\n", "log.csv:3: field psnr: \"-10000.1\" is too large"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,10001\n", "log.csv:3: field l1: \"10001\" is too large"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,-0.4\n", "log.csv:3: field l1: \"-0.4\" is negative"},
        {HEADER "0,0,,10,0.5\n1,0,a,11,\n", "log.csv:3: field l1: \"\" is empty, but the other value is not"},
        {HEADER "0,0,,10,0.5\n1,0,a,,0.4\n", "log.csv:3: field psnr: \"\" is empty, but the other value is not"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        AUTO(vw_step_log_clear) struct vw_step_log log;
        ASSERT_CASE_FAILS(cases[i].text, vw_step_log_read(write_log(*state, cases[i].text), &log), VW_ERROR_INPUT,
                          cases[i].said);
    }
    struct vw_step_log log;
    assert_int_equal(vw_step_log_read(temporary_path(*state, "none.csv"), &log), VW_ERROR_INPUT);
    vw_step_log_clear(&log);
}

// ---- Damage ---------------------------------------------------------------------------------------------------------

// Checks that a log that is read is fit for the ledger, and that a refused one leaves a message of one line.
static void check_any(const char *path) {
    AUTO(vw_step_log_clear) struct vw_step_log log;
    vw_fail(VW_ERROR_USAGE, "no message yet");
    if (vw_step_log_read(path, &log)) {
        assert_true(strcmp(vw_error_message(), "no message yet") != 0 && !strpbrk(vw_error_message(), "\r\n"));
    } else {
        assert_true(log.image_count > 0 && log.record_count > 1 && log.epochs > 0);
        for (uint32_t i = 0; i < log.record_count; i++) {
            const struct vw_step_record *record = &log.records[i];
            assert_true(record->step == i && record->epoch < log.epochs);
            assert_true(record->view < log.image_count || record->view == VW_RECORD_UNTRAINED);
            assert_true(record->validated == (isfinite(record->val_psnr) && isfinite(record->val_l1)));
        }
    }
}

FOLDER_TEST(damaged_files_do_no_harm) {
    static const char whole[] =
        "step,epoch,photo,psnr,l1,note\r\n0,0,,10,0.5,\"a \"\"b\"\"\r\nc\"\r\n1,0,a.png,11,0.4,\n2,0,b.png,nan,,\n"
        "3,1,\"a.png\",12,0.25,x\n4,1,b.png,12.5,0.2,y\n";
    static const char bytes[] = ",\"\n\r0-9eE.xnaN\t\xff";
    const char *path = temporary_path(*state, "damaged.csv");
    char damaged[sizeof whole];
    for (size_t length = 0; length < sizeof whole; length++) { // cut off anywhere
        temporary_write(path, whole, length);
        check_any(path);
    }
    const uint64_t seed = 3;
    for (uint32_t round = 0; round < 4000; round++) {
        uint32_t words[4];
        memcpy(damaged, whole, sizeof whole);
        for (uint32_t i = 0; i <= round % 3; i++) {
            vw_random_words(seed, VW_RANDOM_JITTER, round, i, 0, words);
            damaged[words[0] % (sizeof whole - 1)] =
                words[1] % 8 ? bytes[words[2] % (sizeof bytes - 1)] : (char)words[3];
        }
        temporary_write(path, damaged, sizeof whole - 1);
        check_any(path); // a failure is repeated by the seed: rounds are functions of it
    }
}

// ---- Whole runs -----------------------------------------------------------------------------------------------------

static void print_run(FILE *stream, const void *context) {
    const struct test_recording *recording = context;
    fputs("step,epoch,photo,psnr,l1\n", stream);
    for (uint32_t i = 0; i < recording->count; i++) {
        const struct vw_step_record *record = &recording->records[i];
        fprintf(stream, "%u,%u,%s,", i, record->epoch,
                record->view == VW_RECORD_UNTRAINED ? "" : test_images[record->view].name);
        if (record->nonfinite) fputs("nan", stream);
        else vw_csv_write_real(stream, record->val_psnr);
        fputc(',', stream);
        if (record->nonfinite) fputs("nan", stream);
        else vw_csv_write_real(stream, record->val_l1);
        fputc('\n', stream);
    }
}

// Scores of the log are those of the run, bit for bit, and there is none of what the log does not hold.
FOLDER_TEST(a_run_comes_back) {
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    recording->records[9].nonfinite = true;
    recording->records[9].val_psnr = recording->records[9].val_psnr_pooled = recording->records[9].val_l1 = NAN;
    const char *path = temporary_path(*state, "run.csv");
    ASSERT_OK(vw_csv_write_file(path, print_run, recording));
    AUTO(vw_step_log_clear) struct vw_step_log log = read_log(path);
    assert_int_equal(log.record_count, recording->count);
    assert_int_equal(log.image_count, TEST_TRAIN_COUNT);
    struct vw_value_input ours = test_value_input(recording->records, recording->count);
    struct vw_value_input imported = test_value_input(log.records, log.record_count);
    imported.images = log.images;
    imported.image_count = log.image_count;
    AUTO_FREE struct vw_ledger_score *expected = NULL, *scores = NULL;
    uint32_t expected_count = 0, count = 0;
    ASSERT_OK(vw_value_score(&ours, &expected, &expected_count));
    ASSERT_OK(vw_value_score(&imported, &scores, &count));
    static const char *const methods[] = {"dv_psnr", "dv_loss"};
    for (size_t m = 0; m < VW_ARRAY_COUNT(methods); m++)
        for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) {
            const struct vw_ledger_score *a =
                test_find_score(expected, expected_count, methods[m], test_train_views[i]);
            const struct vw_ledger_score *b =
                test_find_score(scores, count, methods[m], i); // both in the order of the names
            assert_true(a->value == b->value && a->standard_error == b->standard_error && a->visits == b->visits);
        }
    for (uint32_t i = 0; i < count; i++) assert_null(strstr(scores[i].method, "pooled"));
}

static void print_long(FILE *stream, const void *context) {
    const uint32_t *count = context;
    fputs("step,epoch,photo,psnr,l1\n", stream);
    for (uint32_t i = 0; i <= *count; i++)
        fprintf(stream, "%u,%u,photos/%05u.jpg,%.17g,%.17g\n", i, i / 2000, i * 7 % 2000, 20 + sin(i),
                0.1 + 0.01 * sin(i));
}

// CPU time, so that a busy machine does not fail it; the limit is many times what it takes (0.1 s).
FOLDER_TEST(long_logs_are_quick) {
    const uint32_t count = 100000;
    const char *path = temporary_path(*state, "long.csv");
    ASSERT_OK(vw_csv_write_file(path, print_long, &count));
    clock_t start = clock();
    struct vw_step_log log = read_log(path);
    double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    assert_int_equal(log.record_count, count + 1);
    assert_int_equal(log.image_count, 2000);
    vw_step_log_clear(&log);
    print_message("100,000 lines are read in %.2f s\n", seconds);
    assert_true(seconds < 3);
}

// Every row a new photo, and a new epoch for the first `epochs` of them.
struct wide_log {
    uint32_t rows, epochs;
};

static void print_wide(FILE *stream, const void *context) {
    const struct wide_log *wide = context;
    fputs("step,epoch,photo,psnr,l1\n", stream);
    for (uint32_t i = 1; i <= wide->rows; i++) {
        uint32_t epoch = i < wide->epochs ? i : wide->epochs;
        fprintf(stream, "%u,%u,%u,20,0.1\n", i, epoch + (epoch > 5), i);
    }
}

// 2^13 photos in 2^13 epochs are the most: what they need must not grow with the square of a small file. Numbers of
// epochs may have gaps.
FOLDER_TEST(epochs_are_passes_over_the_photos) {
    struct vw_step_log log = {0};
    const char *path = temporary_path(*state, "wide.csv");
    ASSERT_OK(vw_csv_write_file(path, print_wide, &(struct wide_log){8192, 8192}));
    ASSERT_OK(vw_step_log_read(path, &log));
    vw_step_log_clear(&log);
    ASSERT_OK(vw_csv_write_file(path, print_wide, &(struct wide_log){8193, 8192}));
    ASSERT_FAILS(vw_step_log_read(path, &log), VW_ERROR_INPUT, "wide.csv: 8193 photos in 8192 epochs are too many");
    vw_step_log_clear(&log);
}
