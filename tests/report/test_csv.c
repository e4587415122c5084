// scores.csv: header, order, ranks, quoting, and reals that read back to the same double.
#include "support/ledger_fixture.h"

#include "report/tables.h"

static const struct vw_ledger_image images[] = {
    {0, "b,comma.png", "train", "alice", HEX_A, NULL},
    {3, "a\"quote\".png", "train", NULL, HEX_A, NULL},
    {4, "c.png", "train", "line\nbreak", HEX_A, NULL},
    {9, "d.png", "train", "bob", HEX_A, NULL},
};

static char *made(const struct vw_ledger_score *scores, uint32_t count) {
    struct vw_csv_text text = {0};
    ASSERT_OK(vw_report_make_csv("scores.csv", scores, count, images, VW_ARRAY_COUNT(images), &text));
    return text.text;
}

TEST(rows_are_ranked_within_their_method) {
    const struct vw_ledger_score scores[] = {
        {0, "z_first", 0.5, "dB", 0.125, 3, 0.25, 0.75, 2, 3}, {3, "z_first", 0.5, "dB", NAN, 1, NAN, NAN, 0, 0},
        {4, "z_first", -2, "dB", 1, 3, -4, NAN, 3, 4},         {9, "z_first", 7, "dB", 0, 3, 7, 7, 1, 1},
        {0, "a_second", -1, "m", 0.5, 2, -2, 1e-300, 1, 2},    {3, "a_second", 1e-300, "m", 0.5, 2, -1, 1, 1, 2},
    };
    char *text = made(scores, VW_ARRAY_COUNT(scores));
    assert_string_equal(text,
                        "name,provider,method,value,unit,stderr,visits,rank,ci_low,ci_high,rank_ci_low,rank_ci_high\n"
                        "d.png,bob,z_first,7,dB,0,3,1,7,7,1,1\n"
                        "\"a\"\"quote\"\".png\",,z_first,0.5,dB,,1,2,,,,\n" // a tie: by name
                        "\"b,comma.png\",alice,z_first,0.5,dB,0.125,3,3,0.25,0.75,2,3\n"
                        "c.png,\"line\nbreak\",z_first,-2,dB,1,3,4,-4,,3,4\n"
                        "\"a\"\"quote\"\".png\",,a_second,1e-300,m,0.5,2,1,-1,1,1,2\n"
                        "\"b,comma.png\",alice,a_second,-1,m,0.5,2,2,-2,1e-300,1,2\n");
    free(text);
    text = made(NULL, 0);
    assert_string_equal(text, "name,provider,method,value,unit,stderr,visits,rank,ci_low,ci_high,"
                              "rank_ci_low,rank_ci_high\n");
    free(text);
}

TEST(reals_read_back_and_are_short) {
    const struct {
        double value;
        const char *shortest; // NULL: only reads back
    } reals[] = {{0.1, "0.1"},
                 {1.0 / 3, "0.3333333333333333"},
                 {0.1 + 0.2, "0.30000000000000004"},
                 {5e-324, NULL},
                 {-1.7976931348623157e308, "-1.7976931348623157e+308"},
                 {123456789.125, "123456789.125"},
                 {M_PI, NULL}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(reals); i++) {
        const struct vw_ledger_score score = {9, "m", reals[i].value, "dB", NAN, 1, NAN, NAN, 0, 0};
        char *text = made(&score, 1), *field = strstr(text, ",m,") + 3;
        *strchr(field, ',') = 0;
        assert_true(strtod(field, NULL) == reals[i].value);
        if (reals[i].shortest) assert_string_equal(field, reals[i].shortest);
        free(text);
    }
}

TEST(failures_name_the_file) {
    const struct vw_ledger_score score = {5, "m", 1, "dB", NAN, 1, NAN, NAN, 0, 0};
    struct vw_csv_text text = {0};
    enum vw_status status = vw_report_make_csv("scores.csv", &score, 1, images, VW_ARRAY_COUNT(images), &text);
    ASSERT_FAILS(status, VW_ERROR_INPUT, "image 5");
    assert_non_null(strstr(vw_error_message(), "scores.csv"));
}
