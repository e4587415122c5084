// Files opened below a folder lie in it: hostile links, pipes, folders, and names that lead out.
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

static int clean_up(void **state) {
    temporary_folder_remove(*state);
    temporary_folder_remove(outside);
    return 0;
}

TEST_WITHIN(names_of_results_are_not_links, prepare, clean_up) {
    static const char *const refused[] = {"link", "away", "a/near", "dangling", "../file", "a", "pipe"};
    ASSERT_OK(vw_file_check_inside(*state, "file"));
    ASSERT_OK(vw_file_check_inside(*state, "none"));
    assert_true(vw_file_exists_inside(*state, "a/b/file"));
    for (size_t i = 0; i < VW_ARRAY_COUNT(refused); i++) {
        ASSERT_CASE_FAILS(refused[i], vw_file_check_inside(*state, refused[i]), VW_ERROR_INPUT, refused[i]);
        assert_false(strncmp(refused[i], "..", 2) && vw_file_exists_inside(*state, refused[i]));
    }
}

TEST_WITHIN(folders_are_created_without_links, prepare, clean_up) {
    ASSERT_OK(vw_folder_create_inside(*state, "a/c/d"));
    ASSERT_OK(vw_folder_create_inside(*state, "a/c/d"));
    assert_true(vw_folder_exists(temporary_path(*state, "a/c/d")));
    ASSERT_OK(vw_folder_check_inside(*state, "new"));
    static const char *const refused[] = {"away", "dangling", "../new", "a/../../new", "file", "file/new", "pipe"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(refused); i++)
        if (!vw_folder_create_inside(*state, refused[i])) fail_msg("%s was created", refused[i]);
    assert_false(vw_folder_exists(temporary_path(outside, "new")));
}

static void assert_opens(const char *folder, const char *name, const char *expected) {
    int descriptor = -1;
    char text[LIMIT_BYTES] = "";
    enum vw_status status = vw_file_open_inside(folder, name, &descriptor);
    if (status) fail_msg("%s: %s", name, vw_error_message());
    assert_true(read(descriptor, text, sizeof text - 1) >= 0);
    assert_string_equal(text, expected);
    close(descriptor);
    AUTO_FREE void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_OK(vw_file_read_inside(folder, name, LIMIT_BYTES, &data, &size_bytes));
    assert_string_equal(data, expected);
}

static void assert_stays_closed(const char *folder, const char *name, const char *why) {
    int descriptor = -1;
    ASSERT_CASE_FAILS(name, vw_file_open_inside(folder, name, &descriptor), VW_ERROR_INPUT, why);
    assert_int_equal(descriptor, -1);
    void *data = NULL;
    size_t size_bytes = 0;
    ASSERT_CASE_FAILS(name, vw_file_read_inside(folder, name, LIMIT_BYTES, &data, &size_bytes), VW_ERROR_INPUT, why);
}

TEST_WITHIN(links_may_stay_in_the_folder, prepare, clean_up) {
    assert_opens(*state, "file", "ours");
    assert_opens(*state, "a/near", "ours");
    assert_opens(*state, "absolute/b/file", "deep");
    assert_opens(temporary_path(*state, "absolute"), "b/file", "deep");
    assert_stays_closed(temporary_path(*state, "absolute"), "near", "through a link");
    static const char *const linked[] = {"link", "away/secret/file", "../file", "a/../file"};
    for (size_t i = 0; i < sizeof linked / sizeof *linked; i++)
        assert_stays_closed(*state, linked[i], "through a link");
    assert_stays_closed(*state, temporary_path(*state, "file"), "through a link");
    assert_stays_closed(*state, "pipe", "is a folder, a pipe or a device");
    assert_stays_closed(*state, "a", "is a folder, a pipe or a device");
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
