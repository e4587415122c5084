// The main of every test program: runs the tests that TEST and its like have added, and releases what each owns.
#include "support/cmocka_test.h"

#include <errno.h>

enum { TESTS_MAX = 64 };
static struct added {
    struct CMUnitTest test;
    int line;
} added[TESTS_MAX];
static size_t test_count, owned_by_group;
static CMFixtureFunction group_set_up, group_tear_down;
static void *group_state;
static const struct CMUnitTest *running;

void test_add(struct CMUnitTest test, int line) {
    if (test_count == TESTS_MAX) abort();
    size_t place = test_count++;
    for (; place && added[place - 1].line > line; place--) added[place] = added[place - 1];
    added[place] = (struct added){test, line};
}

void test_group(CMFixtureFunction set_up, CMFixtureFunction tear_down) {
    group_set_up = set_up;
    group_tear_down = tear_down;
}

static int set_up_group(void **state) {
    int failed = group_set_up ? group_set_up(state) : 0;
    group_state = *state;
    *state = NULL; // which cmocka would give to set_up() in place of the test
    owned_by_group = test_owned();
    return failed;
}

static int tear_down_group(void **state) {
    test_release_to(0);
    *state = group_state;
    return group_tear_down ? group_tear_down(state) : 0;
}

static int set_up(void **state) {
    running = *state;
    *state = running->initial_state ? running->initial_state : group_state;
    return running->setup_func ? running->setup_func(state) : 0;
}

static int tear_down(void **state) {
    test_release_to(owned_by_group); // before what it may depend on, such as a folder
    return running->teardown_func ? running->teardown_func(state) : 0;
}

int main(int argument_count, char **arguments) {
    struct CMUnitTest tests[TESTS_MAX];
    for (size_t i = 0; i < test_count; i++)
        tests[i] = (struct CMUnitTest){added[i].test.name, added[i].test.test_func, set_up, tear_down, &added[i].test};
    if (argument_count > 1) cmocka_set_test_filter(arguments[1]);
    return _cmocka_run_group_tests(program_invocation_short_name, tests, test_count, set_up_group, tear_down_group);
}
