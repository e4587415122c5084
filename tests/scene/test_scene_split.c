// Splits: the choice of views that train, validate or test; name lists and providers.
#include "scene/name_index.h"
#include "support/cmocka_test.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

FOLDER_TEST(every_eighth_view_validates) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 18});
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state)), "vtttTtttvtttTtttvt");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .test_list = "none")), "vtttttttvtttttttvt");
}

FOLDER_TEST(two_are_left_to_train) {
    static const char *const expected[] = {"tt", "vtt", "vttt", "vtttT"};
    for (uint32_t count = 2; count <= 5; count++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = count});
        check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state)), expected[count - 2]);
    }
    tiny_scene_write(*state, &(struct tiny_scene){.count = 1});
    tiny_folder_refused(*state, *state, "a single photo", "at least 2");
}

FOLDER_TEST(three_files_split_the_views) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_test.json", .first = 5, .count = 2});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 2});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state)), "tttvvTT");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = temporary_path(*state, "transforms_val.json"))),
                 "tt"); // one file is read alone
}

FOLDER_TEST(half_of_test_validates) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state)), "vtt"); // train alone has no opinion
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_test.json", .first = 3, .count = 5});
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state)), "tttvvvTT");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .test_list = "none")), "tttvvvtt");
}

FOLDER_TEST(a_view_in_two_split_files_is_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 4});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 2});
    tiny_folder_refused(*state, "transforms_val.json", "frame 0", "images/03.png", "train and val");
}

FOLDER_TEST(lists_win) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    const char *train = temporary_file(*state, "train.txt", "\n  images/00.png \r\n\n./images/02.png\t\nimages/02.png");
    const char *val = temporary_file(*state, "val.txt", "images/04.png\n");
    const char *test = temporary_file(*state, "test.txt", "images/07.png\n");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .train_list = train, .val_list = val, .test_list = test)),
                 "txtxvxxT");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .train_list = train)),
                 "txtxTxxx"); // the rule fills what has no list
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .val_list = val)), "ttttvttt");
}

// Lists may name a photo by its bare name where no other has it.
FOLDER_TEST(lists_may_use_bare_names) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    const char *val = temporary_file(*state, "val.txt", "04.png\n./05.png\n");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .val_list = val)), "ttttvvtt");
    tiny_photo_write(temporary_path(*state, "other/04.png"), 4);
    temporary_file(
        *state, "transforms.json",
        "{\"fl_x\": 7, \"frames\": ["
        "{\"file_path\": \"images/04.png\", \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},"
        "{\"file_path\": \"other/04.png\", \"transform_matrix\": [[1,0,0,1],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},"
        "{\"file_path\": \"images/05.png\", \"transform_matrix\": [[1,0,0,2],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .val_list = val), VW_ERROR_INPUT, "val.txt:1", "04.png");
    val = temporary_file(*state, "val.txt", "other/04.png\n");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .val_list = val)), "tvt");
}

FOLDER_TEST(lists_win_over_files) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 3});
    const char *train = temporary_file(*state, "train.txt", "images/01.png\nimages/03.png\n");
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .train_list = train)), "xtxtvv"); // claimed from val
}

FOLDER_TEST(a_split_without_photos_is_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 4});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 4, .count = 1});
    assert_int_equal(remove(temporary_path(*state, "images/04.png")), 0);
    tiny_folder_refused(*state, "transforms_val.json", "1 frames", "images/04.png");
}

FOLDER_TEST(only_phototourism_has_a_pool) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    check_splits(tiny_scene_open(SCENE_PARAMS(.path = *state, .pool = "all")), "vttt");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .pool = "list"), VW_ERROR_USAGE, "--pool list", "transforms");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .pool = "some"), VW_ERROR_USAGE, "--pool some");
}

FOLDER_TEST(bad_lists_are_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    const char *train = temporary_file(*state, "train.txt", "images/00.png\nimages/01.png\n");
    const char *overlap = temporary_file(*state, "val.txt", "images/02.png\nimages/01.png\n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .train_list = train, .val_list = overlap), VW_ERROR_INPUT,
                       "val.txt:2", "images/01.png", "train and val");
    const char *unknown = temporary_file(*state, "unknown.txt", "\nimages/1.png\n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .test_list = unknown), VW_ERROR_INPUT, "unknown.txt:2",
                       "images/1.png");
    const char *empty = temporary_file(*state, "empty.txt", " \n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .train_list = empty), VW_ERROR_INPUT, "empty.txt", "has no names",
                       "--train");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .val_list = empty), VW_ERROR_INPUT, "empty.txt", "--val");
    const char *one = temporary_file(*state, "one.txt", "images/00.png\n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .train_list = one), VW_ERROR_INPUT, *state, "only one view");
    const char *all =
        temporary_file(*state, "all.txt", "00.png\n01.png\n02.png\n03.png\n04.png\n05.png\n06.png\n07.png\n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .val_list = all), VW_ERROR_INPUT, "no view is left to train");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .train_list = "no/list"), VW_ERROR_INPUT, "no/list");
}

FOLDER_TEST(providers_are_read) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    const char *csv = temporary_file(*state, "p.csv",
                                     "name,provider\r\nimages/02.png,\"Smith, \"\"Jo\"\"\"\nimages/00.png, anna \t\n"
                                     "images/03.png,anna\n\nimages/01.png,Żółć 李 Ö. d'Arc-№ 5\n");
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .providers = csv));
    assert_string_equal(scene->views[0].provider, "anna");
    assert_string_equal(scene->views[3].provider, "anna");
    assert_string_equal(scene->views[1].provider, "Żółć 李 Ö. d'Arc-№ 5");
    assert_string_equal(scene->views[2].provider, "Smith, \"Jo\"");
}

FOLDER_TEST(bad_providers_are_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    static const struct refused_text cases[] = {
        {"", "p.csv:1", "header"},
        {"provider,name\n", "p.csv:1", "header"},
        {"name,provider\nimages/00.png\n", "p.csv:2", "two fields"},
        {"name,provider\nimages/00.png,a,b\n", "p.csv:2", "two fields"},
        {"name,provider\n\nimages/00.png,\"a\n", "p.csv:3", "quote is not closed"},
        {"name,provider\nimages/00.png,\"a\nb\"\n", "p.csv:2", "U+000A"},
        {"name,provider\n\"images/9\n9.png\",a\nimages/00.png,a,b\n", "p.csv:2", "images/9?9.png"},
        {"name,provider\nimages/00.png,a\"b\n", "p.csv:2", "a quote within a field"},
        {"name,provider\nimages/99.png,a\n", "p.csv:2", "images/99.png"},
        {"name,provider\nimages/00.png,a\nimages/00.png,b\n", "p.csv:3", "images/00.png"},
        {"name,provider\nimages/00.png,a\xff\n", "p.csv:2", "not UTF-8"},
        // Characters that cannot be seen: a control character, zero width, joiners, directions, spaces, fillers, tags.
        {"name,provider\nimages/00.png,a\xc2\x85\n", "p.csv:2", "U+0085"},
        {"name,provider\nimages/00.png,an\u200bna\n", "p.csv:2", "U+200B"},
        {"name,provider\nimages/00.png,anna\u200d\n", "p.csv:2", "U+200D"},
        {"name,provider\nimages/00.png,\ufeffanna\n", "p.csv:2", "U+FEFF"},
        {"name,provider\nimages/00.png,\u202eanna\n", "p.csv:2", "U+202E"},
        {"name,provider\nimages/00.png,an\u00adna\n", "p.csv:2", "U+00AD"},
        {"name,provider\nimages/00.png,anna\u00a0\n", "p.csv:2", "U+00A0"},
        {"name,provider\nimages/00.png,a\u2003b\n", "p.csv:2", "U+2003"},
        {"name,provider\nimages/00.png,a\u3000b\n", "p.csv:2", "U+3000"},
        {"name,provider\nimages/00.png,anna\u3164\n", "p.csv:2", "U+3164"},
        {"name,provider\nimages/00.png,anna\ufe0f\n", "p.csv:2", "U+FE0F"},
        {"name,provider\nimages/00.png,anna\u2800\n", "p.csv:2", "U+2800"},
        {"name,provider\nimages/00.png,anna\U000e0041\n", "p.csv:2", "U+E0041"},
        {"name,provider\nimages/00.png,anna\ue000\n", "p.csv:2", "U+E000"},
        {"name,provider\nimages/00.png,anna\ufff9\n", "p.csv:2", "U+FFF9"},
        // The same by class: the replaced object, a note without a head, fillers, any symbol, U+FFFD for lost letters.
        {"name,provider\nimages/00.png,anna\ufffc\n", "p.csv:2", "U+FFFC"},
        {"name,provider\nimages/00.png,anna\U0001d159\n", "p.csv:2", "U+1D159"},
        {"name,provider\nimages/00.png,anna\U00016fe4\n", "p.csv:2", "U+16FE4"},
        {"name,provider\nimages/00.png,anna\U00013442\n", "p.csv:2", "U+13442"},
        {"name,provider\nimages/00.png,anna\u2591\n", "p.csv:2", "U+2591"},
        {"name,provider\nimages/00.png,anna\ufffd\n", "p.csv:2", "U+FFFD"},
        // Names that look alike: case, sharp s, composition, width, spaces, hyphens.
        {"name,provider\nimages/00.png,anna\nimages/01.png,bob\nimages/02.png,Anna\n", "p.csv:4", "\"anna\" of line 2"},
        {"name,provider\nimages/00.png,STRASSE\nimages/01.png,Straße\n", "p.csv:3", "\"STRASSE\" of line 2"},
        {"name,provider\nimages/00.png,Zo\u00eb\nimages/01.png,Zoe\u0308\n", "p.csv:3", "of line 2"},
        {"name,provider\nimages/00.png,Anna\nimages/01.png,\uff21nna\n", "p.csv:3", "of line 2"},
        {"name,provider\nimages/00.png,a b\nimages/01.png,a  b\n", "p.csv:3", "of line 2"},
        {"name,provider\nimages/00.png,a-b\nimages/01.png,a\u2010b\n", "p.csv:3", "of line 2"},
    };
    ASSERT_TEXTS_REFUSED(*state, "p.csv", cases, tiny_scene_try(SCENE_PARAMS(.path = *state, .providers = path)));
}

// ---- Names ---------------------------------------------------------------------------------------------------------

// Finding names: exactly, and by what they end with.
static const char *const names[] = {"images/a.png", "b.png",       NULL,           "./c.png", "images/left/d.png",
                                    "c.png",        "right/d.png", "xright/d.png", "a.png",   "images/e.png"};

static struct vw_name_index index_names(void) {
    struct vw_name_index index = {0};
    ASSERT_OK(vw_name_index_make(names, sizeof *names, 0, VW_ARRAY_COUNT(names), &index));
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
    ASSERT_OK(vw_name_index_make(many, sizeof *many, 0, COUNT, &index));
    for (int i = 0; i < COUNT; i += 13) {
        int first = 0, endings = 0, last = -1;
        while (strcmp(many[first], many[i]) != 0) first++;
        for (int j = 0; j < COUNT; j++)
            if (strcmp(strchr(many[j], '/'), strchr(many[i], '/')) == 0) endings++, last = j;
        assert_int_equal(find(&index, many[i]), first);
        assert_int_equal(find_ending(&index, strchr(many[i], '/') + 1), endings == 1 ? last : -1);
    }
}
