// Lists of words with commas between.
#include "base/text.h"
#include "support/cmocka_test.h"

TEST(words_come_in_order) {
    const char *rest = "rays,val-rays,,+sky";
    static const char *const expected[] = {"rays", "val-rays", "", "+sky"};
    struct vw_word word;
    for (size_t i = 0; i < 4; i++) {
        assert_true(vw_word_list_next(&rest, &word));
        assert_true(vw_word_is(word, expected[i]));
    }
    assert_false(vw_word_list_next(&rest, &word));
    assert_null(rest);
}

TEST(an_empty_list_and_a_last_comma_give_an_empty_word) {
    const char *empty = "", *ended = "a,";
    struct vw_word word;
    assert_true(vw_word_list_next(&empty, &word) && word.length == 0);
    assert_false(vw_word_list_next(&empty, &word));
    assert_true(vw_word_list_next(&ended, &word) && vw_word_is(word, "a"));
    assert_true(vw_word_list_next(&ended, &word) && word.length == 0);
    assert_false(vw_word_list_next(&ended, &word));
}

TEST(a_word_is_found_whole) {
    assert_true(vw_word_list_has("rays,val-rays", "rays"));
    assert_true(vw_word_list_has("samples,val-rays", "val-rays"));
    assert_false(vw_word_list_has("val-rays", "rays"));
    assert_false(vw_word_list_has("rays", "val-rays"));
    assert_false(vw_word_list_has("rays", "ray"));
    assert_false(vw_word_list_has(NULL, "rays"));
}
