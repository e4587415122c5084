// The main of every test program: runs the tests that TEST and its like have added.
#include "support/cmocka_test.h"

#include <errno.h>

enum { TESTS_MAX = 64 };
static struct CMUnitTest tests[TESTS_MAX];
static int lines[TESTS_MAX];
static size_t test_count;
static CMFixtureFunction group_set_up, group_tear_down;

void test_add(struct CMUnitTest test, int line) {
    if (test_count == TESTS_MAX) abort();
    size_t place = test_count++;
    for (; place && lines[place - 1] > line; place--) {
        tests[place] = tests[place - 1];
        lines[place] = lines[place - 1];
    }
    tests[place] = test;
    lines[place] = line;
}

void test_group(CMFixtureFunction set_up, CMFixtureFunction tear_down) {
    group_set_up = set_up;
    group_tear_down = tear_down;
}

int main(int argument_count, char **arguments) {
    if (argument_count > 1) cmocka_set_test_filter(arguments[1]);
    return _cmocka_run_group_tests(program_invocation_short_name, tests, test_count, group_set_up, group_tear_down);
}
