// Effects that are on, given what the evidence calls for and what --effects wants; and what older runs' configs say.
// label: host
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "viewworth/train.h"

// Asserts that the names between spaces in `expected` are on when those in `called_for` are called for.
static void assert_on(const char *called_for, const char *choice, const char *expected) {
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    vw_effects_list(decisions, &count);
    for (uint32_t i = 0; i < count; i++) {
        char *word = vw_format_text(" %s ", decisions[i].name);
        decisions[i].called_for = strstr(called_for, word) != NULL;
        free(word);
    }
    if (vw_effects_choose(choice, decisions, count) != VW_OK) fail_msg("--effects %s: %s", choice, vw_error_message());
    for (uint32_t i = 0; i < count; i++) {
        char *word = vw_format_text(" %s ", decisions[i].name);
        bool wanted = strstr(expected, word) != NULL;
        free(word);
        if (decisions[i].on != wanted)
            fail_msg("called for:%s; --effects %s: %s is %s", called_for, choice, decisions[i].name,
                     wanted ? "off" : "on");
        assert_true(vw_effects_is_on(decisions, count, decisions[i].name) == wanted);
    }
    assert_false(vw_effects_is_on(decisions, count, "no_such_effect"));
}

TEST(evidence_lists_and_signs) {
    assert_on(" sky wide_box ", "auto", " sky wide_box ");
    assert_on(" sky wide_box ", "none", "");
    assert_on(" sky wide_box ", "masks,background", " masks background ");
    assert_on(" sky wide_box ", "-sky", " wide_box ");
    assert_on(" sky wide_box ", "+masks,-sky", " masks wide_box ");
}

// Effects that are not named go with what they need, and give way to what bars them; those that are named stay as
// named.
TEST(effects_follow_others) {
    assert_on(" appearance appearance_code ", "-appearance", "");
    assert_on(" appearance appearance_code ", "-appearance,+appearance_code", " appearance_code ");
    assert_on(" wide_box ", "+unbounded", " unbounded ");
    assert_on(" wide_box ", "+unbounded,+wide_box", " unbounded wide_box ");
    assert_on("", "unbounded,wide_box,appearance_code", " unbounded wide_box appearance_code ");
}

TEST(wrong_words_are_refused) {
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    uint32_t count;
    const char *const wrong[] = {"fog", "+sky,masks", "sky,-masks", "", "+", "sky,"};
    vw_effects_list(decisions, &count);
    for (size_t i = 0; i < VW_ARRAY_COUNT(wrong); i++)
        if (vw_effects_choose(wrong[i], decisions, count) != VW_ERROR_USAGE)
            fail_msg("--effects \"%s\" is taken", wrong[i]);
}
