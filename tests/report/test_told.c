// Reasons of advice: the words that a run has found in photos, then duplicates, then a word that names none.
#include "support/ledger_fixture.h"

#include "report/told.h"

// Tells reasons where photos 2 to 5 need a look and photo 6 is a lone view; none has a score.
static struct vw_told *tell(const char *map_json, const char *duplicates_json) {
    struct vw_ledger_run row = test_run("{}");
    const struct vw_report_run run = {.row = &row,
                                      .images = test_images,
                                      .image_count = TEST_IMAGE_COUNT,
                                      .map_json = map_json,
                                      .duplicates_json = duplicates_json};
    uint8_t marks[TEST_IMAGE_COUNT] = {0};
    for (uint32_t i = 2; i < 6; i++) marks[i] = VW_ADVICE_LOOK;
    marks[6] = VW_ADVICE_LONE;
    struct vw_told *told = NULL;
    ASSERT_OK(vw_told_make(&run, &(struct vw_advice){.marks = marks}, &told));
    return told;
}

TEST(reasons_are_those_of_the_run) {
    AUTO_FREE struct vw_told *told =
        tell("{\"reasons\":[\"blur\",\"pose\",\"blur\",null,null,\"occluder\",\"noise\",null]}",
             "{\"header\":[\"group\",\"name\"],\"rows\":[[\"1\",\"images/3.png\"],[\"1\",\"images/5.png\"]]}");
    assert_null(told[0].reason); // it validates
    assert_int_equal(told[1].advice, VW_TOLD_UNCLEAR);
    assert_string_equal(told[1].reason, "within noise"); // it fits: its render accuses nobody
    assert_int_equal(told[2].advice, VW_TOLD_LOOK);
    assert_string_equal(told[2].reason, "blur");
    assert_string_equal(told[3].reason, "duplicate");
    assert_string_equal(told[5].reason, "occluder");
    assert_int_equal(told[6].advice, VW_TOLD_KEEP);
    assert_string_equal(told[6].reason, "lone view"); // a photo to keep is not accused
}

TEST(without_them_none_is_found) {
    AUTO_FREE struct vw_told *told = tell("{\"reasons\":[null,null,\"<img>\",7]}", NULL);
    assert_string_equal(told[1].reason, "within noise");
    for (uint32_t i = 2; i < 6; i++)
        if (i != 4) assert_string_equal(told[i].reason, "no reason found");
    AUTO_FREE struct vw_told *of_earlier_version = tell(NULL, NULL);
    assert_string_equal(of_earlier_version[2].reason, "no reason found");
    assert_string_equal(vw_told_known_reason("exposure"), "exposure");
    assert_null(vw_told_known_reason("within noise"));
    assert_null(vw_told_known_reason(NULL));
}
