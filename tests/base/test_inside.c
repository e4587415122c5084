// Files opened below a folder lie in it: hostile links, pipes, folders, and names that lead out. Every test runs
// with openat2 and with the walk from part to part that replaces it on other kernels.
#include <sys/stat.h>
#include <unistd.h>

#include "base/inside.h"
#include "scene/builder.h"
#include "support/cmocka_test.h"
#include "support/temporary_folder.h"

enum { LIMIT_BYTES = 1000 };

static char *outside; // a folder beside the one of the test, with secret/file

static int prepare(void **state) {
    *state = temporary_folder_create();
    outside = temporary_folder_create();
    temporary_file(outside, "secret/file", "secret");
    temporary_file(*state, "file", "ours");
    temporary_file(*state, "a/b/file", "deep");
    assert_int_equal(symlink(outside, temporary_path(*state, "away")), 0);
    assert_int_equal(symlink(temporary_path(outside, "secret/file"), temporary_path(*state, "link")), 0);
    assert_int_equal(symlink("../file", temporary_path(*state, "a/near")), 0);
    assert_int_equal(symlink(temporary_path(*state, "a"), temporary_path(*state, "absolute")), 0);
    assert_int_equal(symlink("a", temporary_path(*state, "relative")), 0);
    assert_int_equal(symlink("nowhere", temporary_path(*state, "dangling")), 0);
    assert_int_equal(mkfifo(temporary_path(*state, "pipe"), 0666), 0);
    return 0;
}

static int prepare_walk(void **state) {
    vw_inside_force_walk(true);
    return prepare(state);
}

static int clean_up(void **state) {
    vw_inside_force_walk(false);
    temporary_folder_remove(*state);
    temporary_folder_remove(outside);
    return 0;
}

static void assert_read(const char *folder, const char *name, const char *expected) {
    AUTO_FREE void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_file_read_inside(folder, name, LIMIT_BYTES, &data, &size_bytes);
    if (status) fail_msg("%s: %s", name, vw_error_message());
    assert_string_equal(data, expected);
    assert_true(vw_file_exists_inside(folder, name));
    ASSERT_OK(vw_file_check_inside(folder, name));
}

static void assert_not_read(const char *folder, const char *name, const char *why) {
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_CASE_FAILS(name, vw_file_read_inside(folder, name, LIMIT_BYTES, &data, &size_bytes), VW_ERROR_INPUT, name,
                      why);
    assert_null(data);
    assert_false(vw_file_exists_inside(folder, name));
}

static void files_of_results_are_read_without_links(void **state) {
    static const char *const linked[] = {
        "link", "away/secret/file", "a/near", "absolute/b/file", "relative/b/file", "dangling", "../file", "a/../file"};
    assert_read(*state, "file", "ours");
    assert_read(*state, "a/b/file", "deep");
    for (size_t i = 0; i < sizeof linked / sizeof *linked; i++) {
        assert_not_read(*state, linked[i], "through a link");
        assert_int_equal(vw_file_check_inside(*state, linked[i]), VW_ERROR_INPUT);
    }
    assert_not_read(*state, temporary_path(outside, "secret/file"), "through a link");
    assert_not_read(*state, "pipe", "another kind");
    assert_not_read(*state, "a", "another kind");
    assert_not_read(*state, "file/below", "another kind");
    assert_not_read(*state, "none", "no such file");
    ASSERT_OK(vw_file_check_inside(*state, "none"));
    assert_int_equal(vw_file_check_inside(*state, "pipe"), VW_ERROR_INPUT);
    // The user's way to the folder may have links.
    assert_read(temporary_path(*state, "absolute"), "b/file", "deep");
}

static void folders_are_created_without_links(void **state) {
    ASSERT_OK(vw_folder_create_inside(*state, "a/c/d"));
    ASSERT_OK(vw_folder_create_inside(*state, "a/c/d"));
    assert_true(vw_folder_exists(temporary_path(*state, "a/c/d")));
    ASSERT_OK(vw_folder_check_inside(*state, "a/c"));
    ASSERT_OK(vw_folder_check_inside(*state, "new"));
    static const char *const refused[] = {"away",        "away/new", "absolute/new", "dangling", "../new",
                                          "a/../../new", "file",     "file/new",     "pipe"};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        enum vw_status status = vw_folder_create_inside(*state, refused[i]);
        if (!status) fail_msg("%s was created", refused[i]);
        assert_non_null(strstr(vw_error_message(), refused[i]));
        assert_int_not_equal(vw_folder_check_inside(*state, refused[i]), VW_OK);
    }
    assert_false(vw_folder_exists(temporary_path(outside, "new")));
    assert_int_not_equal(vw_folder_create_inside(temporary_path(*state, "none"), "new"), VW_OK);
}

static void assert_opens(const char *folder, const char *name, const char *expected) {
    int descriptor = -1;
    char text[LIMIT_BYTES] = "";
    enum vw_status status = vw_file_open_inside(folder, name, &descriptor);
    if (status) fail_msg("%s: %s", name, vw_error_message());
    assert_true(read(descriptor, text, sizeof text - 1) >= 0);
    assert_string_equal(text, expected);
    close(descriptor);
}

static void assert_stays_closed(const char *folder, const char *name, const char *why) {
    int descriptor = -1;
    ASSERT_CASE_FAILS(name, vw_file_open_inside(folder, name, &descriptor), VW_ERROR_INPUT, why);
    assert_int_equal(descriptor, -1);
}

static void files_of_scenes_may_have_links_that_stay(void **state) {
    assert_opens(*state, "file", "ours");
    assert_opens(*state, "a/near", "ours");
    assert_opens(*state, "absolute/b/file", "deep");
    assert_opens(temporary_path(*state, "absolute"), "b/file", "deep");
    assert_stays_closed(temporary_path(*state, "absolute"), "near", "through a link");
    static const char *const linked[] = {"link", "away/secret/file", "../file", "a/../file"};
    for (size_t i = 0; i < sizeof linked / sizeof *linked; i++)
        assert_stays_closed(*state, linked[i], "through a link");
    assert_stays_closed(*state, temporary_path(*state, "file"), "through a link");
    assert_stays_closed(*state, "pipe", "not a plain file");
    assert_stays_closed(*state, "a", "not a plain file");
    assert_stays_closed(*state, "dangling", "no such file");
    assert_stays_closed(*state, "none", "no such file");
    // Paths of scenes begin with their folder.
    const char *inside = temporary_path(*state, "a/near"), *other = temporary_path(outside, "secret/file");
    ASSERT_OK(vw_scene_file_check(*state, inside));
    ASSERT_OK(vw_scene_file_check(NULL, other));
    ASSERT_FAILS(vw_scene_file_check(*state, other), VW_ERROR_INPUT, "is not in the scene folder");
    assert_int_equal(vw_scene_file_check(*state, temporary_path(*state, "link")), VW_ERROR_INPUT);
    // A folder whose name begins as this one's is another folder.
    AUTO_FOLDER char *longer = malloc(strlen(*state) + 2);
    assert_non_null(longer);
    sprintf(longer, "%s2", (char *)*state);
    temporary_file(longer, "file", "other");
    assert_int_equal(symlink(temporary_path(longer, "file"), temporary_path(*state, "a/longer")), 0);
    assert_stays_closed(*state, "a/longer", "through a link");
}

#define BOTH(test)                                                                                                     \
    cmocka_unit_test_setup_teardown(test, prepare, clean_up), {                                                        \
#test "_by_walking", test, prepare_walk, clean_up, NULL                                                        \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        BOTH(files_of_results_are_read_without_links),
        BOTH(folders_are_created_without_links),
        BOTH(files_of_scenes_may_have_links_that_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
