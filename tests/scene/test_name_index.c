// Finding names: exactly, and by what they end with.
#include "support/cmocka_test.h"

#include "scene/name_index.h"

static const char *const names[] = {"images/a.png", "b.png",       NULL,           "./c.png", "images/left/d.png",
                                    "c.png",        "right/d.png", "xright/d.png", "a.png",   "images/e.png"};

static const char *name_at(const void *context, size_t place) { return ((const char *const *)context)[place]; }

static struct vw_name_index index_names(void) {
    struct vw_name_index index = {0};
    ASSERT_OK(vw_name_index_make(name_at, names, sizeof names / sizeof *names, &index));
    assert_int_equal(index.count, sizeof names / sizeof *names - 1); // a place without a name has no entry
    return index;
}

static int find(const struct vw_name_index *index, const char *name) {
    size_t place = 0;
    return vw_name_index_find(index, name, &place) ? (int)place : -1;
}

static int find_ending(const struct vw_name_index *index, const char *name) {
    size_t place = 0;
    return vw_name_index_find_ending(index, name, &place) ? (int)place : -1;
}

TEST(a_name_is_found_whole_and_at_its_first_place) {
    AUTO(vw_name_index_clear) struct vw_name_index index = index_names();
    assert_int_equal(find(&index, "images/a.png"), 0);
    assert_int_equal(find(&index, "a.png"), 8);
    assert_int_equal(find(&index, "./././b.png"), 1);
    assert_int_equal(find(&index, "c.png"), 3); // places 3 and 5 are the same name
    assert_int_equal(find(&index, ".png"), -1);
    assert_int_equal(find(&index, "images/a.pn"), -1);
    assert_int_equal(find(&index, ""), -1);
}

TEST(an_ending_is_found_only_behind_a_slash_and_only_if_it_is_of_one_name) {
    AUTO(vw_name_index_clear) struct vw_name_index index = index_names();
    assert_int_equal(find_ending(&index, "a.png"), 0); // the name a.png itself does not end with /a.png
    assert_int_equal(find_ending(&index, "./e.png"), 9);
    assert_int_equal(find_ending(&index, "left/d.png"), 4);
    assert_int_equal(find_ending(&index, "d.png"), -1);       // three
    assert_int_equal(find_ending(&index, "right/d.png"), -1); // whole, and after a letter
    assert_int_equal(find_ending(&index, "b.png"), -1);
    assert_int_equal(find_ending(&index, ""), -1);
}

// Against looking at every name.
TEST(many_names_are_all_found) {
    enum { COUNT = 3000 };
    static char texts[COUNT][24];
    static const char *many[COUNT];
    AUTO(vw_name_index_clear) struct vw_name_index index = {0};
    for (int i = 0; i < COUNT; i++) {
        snprintf(texts[i], sizeof texts[i], "%d/%d.png", i % 7, i * 31 % 2500);
        many[i] = texts[i];
    }
    ASSERT_OK(vw_name_index_make(name_at, many, COUNT, &index));
    for (int i = 0; i < COUNT; i += 13) {
        int first = 0, endings = 0, last = -1;
        while (strcmp(many[first], many[i]) != 0) first++;
        for (int j = 0; j < COUNT; j++)
            if (strcmp(strchr(many[j], '/'), strchr(many[i], '/')) == 0) endings++, last = j;
        assert_int_equal(find(&index, many[i]), first);
        assert_int_equal(find_ending(&index, strchr(many[i], '/') + 1), endings == 1 ? last : -1);
    }
}
