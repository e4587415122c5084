// --splits: the splits of an earlier run are those of a scene with more or fewer photos; broken files are refused.
#include "support/cmocka_test.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/splits_file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

#define WITH_SPLITS(file) SCENE_PARAMS(.path = *state, .splits = (file))

// Writes the splits of an open scene to splits.json; returns its path.
static const char *keep_splits(const char *folder, const struct vw_scene *scene) {
    AUTO_FREE char *text = NULL;
    ASSERT_OK(vw_splits_file_make(scene, &text));
    return temporary_file(folder, "splits.json", text);
}

// Checks that the scene has a note that begins so.
static void check_note(const struct vw_scene *scene, const char *beginning) {
    bool found = false;
    for (uint32_t i = 0; i < scene->note_count; i++) found |= !strncmp(scene->notes[i], beginning, strlen(beginning));
    if (!found) fail_msg("no note begins with: %s", beginning);
}

static void check_same_hash(const struct vw_scene *a, const struct vw_scene *b) {
    assert_memory_equal(a->hash, b->hash, sizeof a->hash);
}

FOLDER_TEST(splits_are_kept) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 14});
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    check_splits(scene, "vtttTtttvtttTt");
    struct vw_scene *again = tiny_scene_open(WITH_SPLITS(keep_splits(*state, scene)));
    check_splits(again, "vtttTtttvtttTt");
    check_same_hash(scene, again);
    assert_int_equal(again->note_count, 0);
}

FOLDER_TEST(excluded_photos_stay_excluded) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 10});
    const char *train = temporary_file(*state, "train.txt", "images/01.png\nimages/02.png\n");
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state, .train_list = train));
    check_splits(scene, "vttxTxxxvx");
    check_splits(tiny_scene_open(WITH_SPLITS(keep_splits(*state, scene))), "vttxTxxxvx");
}

FOLDER_TEST(other_photos_do_not_move) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 14});
    const char *splits = keep_splits(*state, tiny_scene_open(SCENE_PARAMS(.path = *state)));
    tiny_scene_write(*state, &(struct tiny_scene){.first = 3, .count = 11});
    struct vw_scene *fewer = tiny_scene_open(WITH_SPLITS(splits));
    check_splits(fewer, "tTtttvtttTt"); // the rule would say vtttTtttvtt
    check_note(fewer, "3 photos that ");
    tiny_scene_write(*state, &(struct tiny_scene){.count = 16});
    struct vw_scene *more = tiny_scene_open(WITH_SPLITS(splits));
    check_splits(more, "vtttTtttvtttTttt");
    check_note(more, "2 photos that ");
}

// Photos of one colour whose numbers differ by 16 are equal.
FOLDER_TEST(added_near_duplicates_join) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 14});
    const char *splits = keep_splits(*state, tiny_scene_open(SCENE_PARAMS(.path = *state)));
    tiny_scene_write(*state, &(struct tiny_scene){.count = 22});
    struct vw_scene *scene = tiny_scene_open(WITH_SPLITS(splits));
    check_splits(scene, "vtttTtttvtttTtttvtttTt"); // 16 is a copy of 0, and 20 of 4
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 3);
    check_note(scene, "6 photos that ");
    check_same_hash(scene, tiny_scene_open(WITH_SPLITS(splits)));
}

FOLDER_TEST(added_photos_override_the_scene) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 4});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 4, .count = 3});
    const char *splits = temporary_file(*state, "splits.json",
                                        "{\"train\": [\"images/00.png\"], \"test\": [\"./images/01.png\"], "
                                        "\"val\": [\"images/04.png\"], \"excluded\": [\"images/05.png\"]}");
    check_splits(tiny_scene_open(WITH_SPLITS(splits)), "tTttvxt");
}

FOLDER_TEST(bad_splits_are_refused) {
    static const struct {
        const char *text, *place, *said;
    } cases[] = {
        {"", "splits.json:1:", "not valid JSON"},
        {"{\"train\": [],\n \"val\": [}", "splits.json:2:", "not valid JSON"},
        {"{\"train\": [], \"train\": []}", "splits.json:1:", "duplicate"},
        {"[]", "splits.json: ", "expected an object"},
        {"{\"train\": [], \"val\": [], \"test\": [], \"tests\": []}", "tests", "unknown key"},
        {"{\"train\": [], \"val\": []}", "test: ", "is missing"},
        {"{\"train\": [], \"val\": {}, \"test\": []}", "val: ", "is not a list"},
        {"{\"train\": [], \"val\": [], \"test\": [], \"excluded\": 1}", "excluded: ", "is not a list"},
        {"{\"train\": [\"images/00.png\", 1], \"val\": [], \"test\": []}", "train[1]: ", "expected a text"},
        {"{\"train\": [null], \"val\": [], \"test\": []}", "train[0]: ", "expected a text"},
        {"{\"train\": [\"images/00.png\"], \"val\": [], \"test\": [\"./images/00.png\"]}", "test[0]: images/00.png",
         "two splits, train and test"},
        {"{\"train\": [\"gone.png\", \"images/00.png\"], \"val\": [\"gone.png\"], \"test\": []}", "val[0]: gone.png",
         "two splits, train and val"},
        {"{\"train\": [\"other/00.png\"], \"val\": [\"00.png\"], \"test\": []}", "splits.json: ", "names a photo of"},
        {"{\"train\": [\"images/00.png\\u0000\"], \"val\": [], \"test\": []}", "splits.json:1:", "not valid JSON"},
        {"{\"train\": [], \"val\": [\"images/00.png\", \"images/01.png\", \"images/02.png\"], \"test\": []}",
         "only one view", "left to train"},
    };
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *splits = temporary_file(*state, "splits.json", cases[i].text);
        print_message("%s\n", cases[i].text);
        tiny_scene_refused(WITH_SPLITS(splits), VW_ERROR_INPUT, cases[i].place, cases[i].said);
    }
    tiny_scene_refused(WITH_SPLITS("no/splits.json"), VW_ERROR_INPUT, "no/splits.json");
}

FOLDER_TEST(splits_exclude_lists) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    const char *splits = keep_splits(*state, tiny_scene_open(SCENE_PARAMS(.path = *state)));
    const char *list = temporary_file(*state, "list.txt", "images/01.png\n");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .splits = splits, .train_list = list), VW_ERROR_USAGE, "--splits",
                       "leave out --train");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .splits = splits, .val_list = list), VW_ERROR_USAGE, "--val");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .splits = splits, .test_list = list), VW_ERROR_USAGE, "--test");
}
