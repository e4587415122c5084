// The lock of a folder of results: one holder at a time, nothing left behind, and no hostile link followed.
#include "support/cmocka_test.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "run/out_folder.h"
#include "support/temporary_folder.h"

static void assert_locked(const char *out, const char *why) {
    struct vw_out_lock *lock = NULL;
    assert_int_equal(vw_out_lock_take(out, &lock), VW_ERROR_USAGE);
    assert_null(lock);
    assert_non_null(strstr(vw_error_message(), out));
    if (!strstr(vw_error_message(), why)) fail_msg("\"%s\" does not say: %s", vw_error_message(), why);
}

FOLDER_TEST(a_second_start_is_refused) {
    char pid[40];
    const char *out = temporary_path(*state, "out");
    struct vw_out_lock *lock = NULL, *again = NULL;
    ASSERT_OK(vw_out_lock_take(out, &lock));
    snprintf(pid, sizeof pid, "(pid %ld) writes there", (long)getpid());
    assert_locked(out, pid);
    assert_true(vw_folder_exists(out));
    vw_out_lock_release(&lock);
    assert_null(lock);
    ASSERT_OK(vw_out_lock_take(out, &again));
    vw_out_lock_release(&again);
    vw_out_lock_release(&again); // does nothing
}

FOLDER_TEST(an_empty_folder_goes_with_the_lock_that_created_it) {
    struct vw_out_lock *lock = NULL;
    const char *out = temporary_path(*state, "out");
    ASSERT_OK(vw_out_lock_take(out, &lock));
    vw_out_lock_release(&lock);
    assert_false(vw_folder_exists(out));

    ASSERT_OK(vw_out_lock_take(out, &lock));
    temporary_file(*state, "out/result", "");
    vw_out_lock_release(&lock);
    assert_true(vw_file_exists(temporary_path(*state, "out/result")));

    assert_int_equal(mkdir(temporary_path(*state, "empty"), 0777), 0);
    ASSERT_OK(vw_out_lock_take(temporary_path(*state, "empty"), &lock));
    vw_out_lock_release(&lock);
    assert_true(vw_folder_exists(temporary_path(*state, "empty")));
}

FOLDER_TEST(leftovers_of_killed_writers_are_removed) {
    static const char left[] = ".viewworth-0123456789abcdef0123456789abcdef.part";
    struct vw_out_lock *lock = NULL;
    temporary_file(*state, left, "half");
    temporary_file(*state, ".viewworth.lock", "1\n"); // no process holds it
    ASSERT_OK(vw_out_lock_take(*state, &lock));
    assert_false(vw_file_exists(temporary_path(*state, left)));
    vw_out_lock_release(&lock);
}

FOLDER_TEST(a_link_in_its_place_is_not_followed) {
    struct vw_out_lock *lock = NULL;
    AUTO_FREE char *victim = strdup(temporary_file(*state, "victim", "precious"));
    temporary_file(*state, "out/other", "");
    assert_int_equal(symlink(victim, temporary_path(*state, "out/.viewworth.lock")), 0);
    ASSERT_FAILS(vw_out_lock_take(temporary_path(*state, "out"), &lock), VW_ERROR_USAGE,
                 ".viewworth.lock: is reached through a link");
    AUTO_FREE void *data = temporary_read(victim, NULL);
    assert_string_equal(data, "precious");
}

FOLDER_TEST(only_a_target_in_the_folder_locks_it) {
    const char *const folders[] = {temporary_path(*state, "none"), *state};
    struct vw_out_lock *held = NULL, *lock = NULL;
    ASSERT_OK(vw_out_lock_take(*state, &held));
    ASSERT_OK(vw_out_lock_take_for("/elsewhere/report.html", folders, 2, &lock));
    assert_null(lock);
    ASSERT_OK(vw_out_lock_take_for(temporary_path(*state, "none/report.html"), folders, 2, &lock));
    assert_null(lock);
    assert_int_equal(vw_out_lock_take_for(temporary_path(*state, "./report.html"), folders, 2, &lock), VW_ERROR_USAGE);
    vw_out_lock_release(&held);
    ASSERT_OK(vw_out_lock_take_for(temporary_path(*state, "report.html"), folders, 2, &lock));
    assert_non_null(lock);
    vw_out_lock_release(&lock);
}

// Takes and releases the lock again and again, as every child does. While it is held, creates and removes a file that
// no other child may have at that moment.
static int contend(const char *out, const char *mark) {
    int held = 0;
    alarm(60);
    for (int i = 0; i < 1500 || !held; i++) { // on a busy machine others may hold it for all of these
        struct vw_out_lock *lock = NULL;
        if (vw_out_lock_take(out, &lock)) continue;
        int file = open(mark, O_WRONLY | O_CREAT | O_EXCL, 0666);
        if (file < 0) return 1;
        close(file);
        if (unlink(mark)) return 1;
        held++;
        vw_out_lock_release(&lock);
    }
    return 0;
}

FOLDER_TEST(two_never_hold_it) {
    enum { CHILDREN = 4 };
    pid_t children[CHILDREN];
    const char *out = temporary_path(*state, "out"), *mark = temporary_path(*state, "mark");
    assert_int_equal(mkdir(out, 0777), 0);
    for (int i = 0; i < CHILDREN; i++)
        if ((children[i] = fork()) == 0) _exit(contend(out, mark));
    for (int i = 0; i < CHILDREN; i++) {
        int result = 0;
        assert_int_equal(waitpid(children[i], &result, 0), children[i]);
        assert_int_equal(result, 0);
    }
}
