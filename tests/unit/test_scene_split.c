// Which view trains, validates or tests; name lists and providers.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static int make_folder(void **state) { return !(*state = temporary_folder_create()); }

static int remove_folder(void **state) {
    temporary_folder_remove(*state);
    return 0;
}

// One letter per view: t(rain), v(al), T(est), x(excluded).
static void check_splits(const struct vw_scene_params *params, const char *expected) {
    struct vw_scene *scene = tiny_scene_open(params);
    char splits[100] = "";
    uint32_t count[4] = {0};
    for (uint32_t v = 0; v < scene->view_count; v++) {
        splits[v] = "tvTx"[scene->views[v].split];
        count[scene->views[v].split]++;
    }
    assert_string_equal(splits, expected);
    assert_memory_equal(count, scene->split_count, sizeof count);
    vw_scene_close(&scene);
}

static void test_every_eighth(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 18});
    check_splits(&(struct vw_scene_params){.path = *state}, "vtttTtttvtttTtttvt");
}

static void test_two_are_left_to_train(void **state) {
    static const char *const expected[] = {"t", "tt", "vtt", "vttt", "vtttT"};
    for (uint32_t count = 1; count <= 5; count++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = count});
        check_splits(&(struct vw_scene_params){.path = *state}, expected[count - 1]);
    }
}

static void test_split_files(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_test.json", .first = 5, .count = 2});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 2});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    check_splits(&(struct vw_scene_params){.path = *state}, "tttvvTT");
    check_splits(&(struct vw_scene_params){.path = temporary_path(*state, "transforms_val.json")}, "tt"); // one file is read alone
}

static void test_half_of_test_validates(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    check_splits(&(struct vw_scene_params){.path = *state}, "vtt"); // train alone has no opinion
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_test.json", .first = 3, .count = 5});
    check_splits(&(struct vw_scene_params){.path = *state}, "tttvvvTT");
}

static void test_view_in_two_split_files(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 4});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 2});
    tiny_scene_refused(&(struct vw_scene_params){.path = *state}, VW_ERROR_INPUT, "transforms_val.json", "frame 0", "images/03.png",
                       "train and val", NULL);
}

static void test_lists_win(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    const char *train = temporary_file(*state, "train.txt", "\n  images/00.png \r\n\n./images/02.png\t\nimages/02.png");
    const char *val = temporary_file(*state, "val.txt", "images/04.png\n");
    const char *test = temporary_file(*state, "test.txt", "images/07.png\n");
    check_splits(&(struct vw_scene_params){.path = *state, .train_list = train, .val_list = val, .test_list = test}, "txtxvxxT");
    check_splits(&(struct vw_scene_params){.path = *state, .train_list = train}, "txtxTxxx"); // the rule fills what has no list
    check_splits(&(struct vw_scene_params){.path = *state, .val_list = val}, "ttttvttt");
}

static void test_lists_win_over_files(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_train.json", .first = 0, .count = 3});
    tiny_scene_write(*state, &(struct tiny_scene){.file = "transforms_val.json", .first = 3, .count = 3});
    const char *train = temporary_file(*state, "train.txt", "images/01.png\nimages/03.png\n");
    check_splits(&(struct vw_scene_params){.path = *state, .train_list = train}, "xtxtvv"); // claimed from val
}

static void test_list_errors(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 8});
    const char *train = temporary_file(*state, "train.txt", "images/00.png\nimages/01.png\n");
    const char *overlap = temporary_file(*state, "val.txt", "images/02.png\nimages/01.png\n");
    tiny_scene_refused(&(struct vw_scene_params){.path = *state, .train_list = train, .val_list = overlap}, VW_ERROR_INPUT, "val.txt:2",
                       "images/01.png", "train and val", NULL);
    const char *unknown = temporary_file(*state, "unknown.txt", "\nimages/1.png\n");
    tiny_scene_refused(&(struct vw_scene_params){.path = *state, .test_list = unknown}, VW_ERROR_INPUT, "unknown.txt:2", "images/1.png",
                       NULL);
    const char *empty = temporary_file(*state, "empty.txt", " \n");
    tiny_scene_refused(&(struct vw_scene_params){.path = *state, .train_list = empty}, VW_ERROR_INPUT, "no view is left to train", NULL);
    tiny_scene_refused(&(struct vw_scene_params){.path = *state, .train_list = "no/list"}, VW_ERROR_INPUT, "no/list", NULL);
}

static void test_providers(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    const char *csv = temporary_file(*state, "p.csv", "name,provider\r\nimages/02.png,\"Smith, \"\"Jo\"\"\"\nimages/00.png,anna\n\n");
    struct vw_scene *scene = tiny_scene_open(&(struct vw_scene_params){.path = *state, .providers = csv});
    assert_string_equal(scene->views[0].provider, "anna");
    assert_string_equal(scene->views[1].provider, "");
    assert_string_equal(scene->views[2].provider, "Smith, \"Jo\"");
    vw_scene_close(&scene);
}

static void test_provider_errors(void **state) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 4});
    static const struct {
        const char *text, *line, *said;
    } cases[] = {
        {"", "p.csv:1", "two fields"},
        {"provider,name\n", "p.csv:1", "header"},
        {"name,provider\nimages/00.png\n", "p.csv:2", "two fields"},
        {"name,provider\nimages/00.png,a,b\n", "p.csv:2", "two fields"},
        {"name,provider\n\nimages/00.png,\"a\n", "p.csv:3", "two fields"},
        {"name,provider\nimages/99.png,a\n", "p.csv:2", "images/99.png"},
        {"name,provider\nimages/00.png,a\nimages/00.png,b\n", "p.csv:3", "images/00.png"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const char *csv = temporary_file(*state, "p.csv", cases[i].text);
        tiny_scene_refused(&(struct vw_scene_params){.path = *state, .providers = csv}, VW_ERROR_INPUT, cases[i].line, cases[i].said, NULL);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_eighth, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_two_are_left_to_train, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_split_files, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_half_of_test_validates, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_view_in_two_split_files, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_lists_win, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_lists_win_over_files, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_list_errors, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_providers, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_provider_errors, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
