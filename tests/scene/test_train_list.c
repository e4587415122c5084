// Lists of photos to train on, as files name them.
#include "support/cmocka_test.h"

#include "scene/formats/photo_list.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

enum { PHOTOS = 10 }; // images/00.png to images/09.png, split vtttTtttvt

static struct vw_scene *open_scene(const char *folder) {
    tiny_scene_write(folder, &(struct tiny_scene){.count = PHOTOS});
    return tiny_scene_open(SCENE_PARAMS(.path = folder));
}

// Checks which photos the list chooses. `expected` has their digits.
static void check_list(const char *folder, const char *name, const char *text, const double *least,
                       const char *expected, uint32_t expected_passed_over) {
    struct vw_scene *scene = open_scene(folder);
    bool chosen[PHOTOS] = {false};
    uint32_t passed_over = 99, count = 0;
    char digits[PHOTOS + 1] = "";
    temporary_file(folder, name, text);
    if (vw_train_list_read(scene, temporary_path(folder, name), least, chosen, &passed_over))
        fail_msg("%s", vw_error_message());
    for (uint32_t v = 0; v < PHOTOS; v++)
        if (chosen[v]) digits[count++] = (char)('0' + v);
    assert_string_equal(digits, expected);
    assert_int_equal(passed_over, expected_passed_over);
}

// Checks that the list is refused with a message of one line that holds both texts.
static void check_refusal(const char *folder, const char *name, const char *text, const double *least,
                          const char *first, const char *second) {
    struct vw_scene *scene = open_scene(folder);
    bool chosen[PHOTOS] = {false};
    uint32_t passed_over;
    temporary_file(folder, name, text);
    ASSERT_FAILS(vw_train_list_read(scene, temporary_path(folder, name), least, chosen, &passed_over), VW_ERROR_INPUT,
                 first, second);
}

FOLDER_TEST(plain_names) {
    check_list(*state, "list.txt", "images/03.png\n\n  05.png \r\n./images/01.png", NULL, "135", 0);
    check_list(*state, "list.txt", "images/03.png\n03.png\n", NULL, "3", 0); // twice is once
    check_refusal(*state, "list.txt", "images/03.png\nimages/11.png\n", NULL, "list.txt:2",
                  "images/11.png is not in the scene");
    check_refusal(*state, "list.txt", "03.png\n04.png\n", NULL, "list.txt:2", "its split is test");
    check_refusal(*state, "list.txt", "00.png\n", NULL, "list.txt:1", "its split is val");
    check_refusal(*state, "list.txt", " \n\n", NULL, "list.txt", "names no train photo");
}

// Rows without an id, test rows, photos that do not train and photos that are not there: none of them is chosen.
FOLDER_TEST(nerfw_rows_with_an_id) {
    static const char rows[] =
        "filename\tid\tsplit\tdataset\n03.png\t7.0\ttrain\tx\n05.png\t\ttrain\tx\n06.png\t4\ttest\tx\n"
        "00.png\t5\ttrain\tx\ngone.png\t6\ttrain\tx\n09.png\t8\ttrain\tx\n";
    check_list(*state, "list.tsv", rows, NULL, "39", 2);
    check_list(*state, "list.txt", rows, NULL, "39", 2); // known by its header
    check_refusal(*state, "list.tsv", "filename\tid\tsplit\n03.png\t\ttrain\n", NULL, "list.tsv",
                  "names no train photo");
}

FOLDER_TEST(frames_of_a_transforms_file) {
    check_list(*state, "chosen.json",
               "{\"frames\": [{\"file_path\": \"images/02.png\"}, {\"file_path\": \"./images/04.png\"}, "
               "{\"file_path\": \"07.png\"},"
               " {\"file_path\": \"../elsewhere/images/06.png\"}]}",
               NULL, "267", 1);
    check_refusal(*state, "chosen.json", "{\"frames\": [{\"file_path\": \"02.png\"}, {\"file_path\": \"a/12.png\"}]}",
                  NULL, "frame 1", "a/12.png");
    check_refusal(*state, "chosen.json", "{\"frames\": [{\"file\": \"02.png\"}]}", NULL, "frame 0", "file_path");
    check_refusal(*state, "chosen.json", "{\"frames\": {}}", NULL, "chosen.json", "frames");
    check_refusal(*state, "chosen.json", "{\"frames\": [}", NULL, "chosen.json:1:13", "not valid JSON");
    check_refusal(*state, "chosen.json", "{\"frames\": []}", NULL, "chosen.json", "names no train photo");
}

// Photo 8 validates.
FOLDER_TEST(photos_scored_so_highly) {
    const double three = 3, nine = 9;
    static const char rows[] = "name,score\nimages/01.png,3\n\"images/02.png\",2.99\n08.png,8\n03.png,1e1\n";
    check_list(*state, "nima.csv", rows, &three, "13", 2);
    check_list(*state, "nima.csv", rows, &nine, "3", 3);
    check_refusal(*state, "nima.csv", "name,score\n01.png,3\n", &nine, "nima.csv", "no train photo");
    check_refusal(*state, "nima.csv", "name,value\n01.png,3\n", &three, "nima.csv:1", "name,score");
    check_refusal(*state, "nima.csv", "", &three, "nima.csv:1", "name,score");
    check_refusal(*state, "nima.csv", "name,score\n01.png,3\n31.png,3\n", &three, "nima.csv:3",
                  "31.png is not in the scene");
    check_refusal(*state, "nima.csv", "name,score\n01.png,3\n01.png,3\n", &three, "nima.csv:3", "score already");
    check_refusal(*state, "nima.csv", "name,score\n01.png,good\n", &three, "nima.csv:2", "good");
    check_refusal(*state, "nima.csv", "name,score\n01.png,nan\n", &three, "nima.csv:2", "nan");
    check_refusal(*state, "nima.csv", "name,score\n01.png\n", &three, "nima.csv:2", "two fields");
}

FOLDER_TEST(a_file_that_is_not_there) {
    struct vw_scene *scene = open_scene(*state);
    bool chosen[PHOTOS] = {false};
    uint32_t passed_over;
    static const char *const missing[] = {"none.txt", "none.json", "none.tsv"};
    const double least = 0;
    for (int i = 0; i < 4; i++) {
        const char *path = temporary_path(*state, missing[i % 3]);
        ASSERT_FAILS(vw_train_list_read(scene, path, i == 3 ? &least : NULL, chosen, &passed_over), VW_ERROR_INPUT,
                     path);
    }
}
