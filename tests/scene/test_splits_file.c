// --splits: the splits of an earlier run are those of a scene with more or fewer photos. --val-weights: weights of
// validation photos. Broken files are refused.
#include "support/cmocka_test.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "scene/splits_file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

#define VAL_00 "{\"train\": [\"images/01.png\"], \"val\": [\"images/00.png\"], \"test\": [], "
#define WITH_WEIGHTS(file) SCENE_PARAMS(.path = *state, .val_weights = (file))
#define WITH_SPLITS(file) SCENE_PARAMS(.path = *state, .splits = (file))

// Writes the splits of an open scene to splits.json; returns its path.
static const char *keep_splits(const char *folder, const struct vw_scene *scene) {
    AUTO_FREE char *text = NULL;
    ASSERT_OK(vw_splits_file_make(scene, &text));
    return temporary_file(folder, "splits.json", text);
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
    check_note(fewer, "skipped 3 photos that ");
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
    static const struct refused_text cases[] = {
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
        {VAL_00 "\"weights\": [2]}", "weights: ", "is not an object"},
        {VAL_00 "\"weights\": {\"images/01.png\": 2}}", "weights: images/01.png", "is not in val"},
        {VAL_00 "\"weights\": {\"images/00.png\": -1}}", "weights: that of images/00.png", "not a weight"},
        {VAL_00 "\"weights\": {\"images/00.png\": \"2\"}}", "weights: that of images/00.png", "not a weight"},
        {VAL_00 "\"weights\": {\"images/00.png\": 0}}", "splits.json: ", "all validation photos"},
    };
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    ASSERT_TEXTS_REFUSED(*state, "splits.json", cases, tiny_scene_try(WITH_SPLITS(path)));
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

// ---- --val-weights --------------------------------------------------------------------------------------------------

FOLDER_TEST(weights_are_read_and_kept_with_the_splits) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 17});
    struct vw_scene *plain = tiny_scene_open(SCENE_PARAMS(.path = *state));
    const char *file = temporary_file(*state, "weights.csv", "name,weight\n08.png,2.5\nimages/16.png,0\n");
    struct vw_scene *scene = tiny_scene_open(WITH_WEIGHTS(file));
    for (uint32_t v = 0; v < scene->view_count; v++)
        assert_true(scene->views[v].weight == (v == 8 ? 2.5 : v == 16 ? 0 : 1) && plain->views[v].weight == 1);
    check_note(scene, "validation photos are weighted by ");
    assert_true(memcmp(scene->hash, plain->hash, sizeof plain->hash) != 0);
    const char *splits = keep_splits(*state, scene);
    struct vw_scene *again = tiny_scene_open(WITH_SPLITS(splits));
    check_same_hash(scene, again);
    assert_true(again->views[8].weight == 2.5 && again->views[16].weight == 0);
    file = temporary_file(*state, "none.csv", "name,weight\n");
    check_same_hash(plain, tiny_scene_open(SCENE_PARAMS(.path = *state, .splits = splits, .val_weights = file)));
}

FOLDER_TEST(equal_weights_change_nothing) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 14});
    struct vw_scene *plain = tiny_scene_open(SCENE_PARAMS(.path = *state));
    struct vw_scene *scene =
        tiny_scene_open(WITH_WEIGHTS(temporary_file(*state, "weights.csv", "name,weight\n00.png,0.3\n08.png,0.3\n")));
    check_same_hash(plain, scene);
    assert_int_equal(scene->note_count, 0);
}

FOLDER_TEST(bad_weights_are_refused) {
    static const struct refused_text cases[] = {
        {"name,value\n00.png,1\n", "weights.csv:1: ", "header must be name,weight"},
        {"", "weights.csv:1: ", "header must be name,weight"},
        {"name,weight\n00.png\n", "weights.csv:2: ", "two fields"},
        {"name,weight\n00.png,1\ngone.png,1\n", "weights.csv:3: gone.png", "not in the scene"},
        {"name,weight\n01.png,1\n", "weights.csv:2: 01.png", "split train"},
        {"name,weight\n04.png,1\n", "weights.csv:2: 04.png", "split test"},
        {"name,weight\n00.png,1\nimages/00.png,1\n", "weights.csv:3: images/00.png", "has a weight already"},
        {"name,weight\n00.png,-1\n", "weights.csv:2: ", "\"-1\" is not a weight"},
        {"name,weight\n00.png,inf\n", "weights.csv:2: ", "is not a weight"},
        {"name,weight\n00.png,nan\n", "weights.csv:2: ", "is not a weight"},
        {"name,weight\n00.png,2x\n", "weights.csv:2: ", "is not a weight"},
        {"name,weight\n00.png,\n", "weights.csv:2: ", "is not a weight"},
        {"name,weight\n00.png, 1\n", "weights.csv:2: ", "is not a weight"},
        {"name,weight\n00.png,1e-4\n", "weights.csv:2: ", "0.001 to 1000"},
        {"name,weight\n00.png,0x10\n", "weights.csv:2: ", "\"0x10\" is not a weight"},
        {"name,weight\n00.png,0\n08.png,0\n", "weights.csv: ", "all validation photos"},
    };
    tiny_scene_write(*state, &(struct tiny_scene){.count = 14});
    ASSERT_TEXTS_REFUSED(*state, "weights.csv", cases, tiny_scene_try(WITH_WEIGHTS(path)));
    tiny_scene_refused(WITH_WEIGHTS("no/weights.csv"), VW_ERROR_INPUT, "no/weights.csv");
}
