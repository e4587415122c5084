// Every cmocka test and helper includes this first: cmocka with the headers that it needs, and the assertions that it
// lacks.
#ifndef VIEWWORTH_TESTS_SUPPORT_CMOCKA_TEST_H
#define VIEWWORTH_TESTS_SUPPORT_CMOCKA_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "viewworth/status.h"

// Defines a test, which run_tests.c runs in the order of the file. Programs with a main of their own list theirs.
#define TEST(name) TEST_WITHIN(name, NULL, NULL)
// The same between a set-up and a tear-down.
#define TEST_WITHIN(name, set_up, tear_down)                                                                           \
    static void name(void **state);                                                                                    \
    __attribute__((constructor)) static void add_##name(void) {                                                        \
        test_add((struct CMUnitTest){#name, name, set_up, tear_down, NULL}, __LINE__);                                 \
    }                                                                                                                  \
    static void name(__attribute__((unused)) void **state)
// Defines a test of a table: the body runs for `index` = 0 to count - 1, and what it owns is released after each.
#define TEST_CASES(name, index, count)                                                                                 \
    static void name##_case(size_t index);                                                                             \
    TEST(name) { test_each_case(count, name##_case); }                                                                 \
    static void name##_case(size_t index)
// Returns whether VIEWWORTH_FULL is set, which scripts/test --full does: tests that choose some of many cases then run
// all of them.
static inline bool test_is_full(void) { return getenv("VIEWWORTH_FULL") != NULL; }

// Declares a function of the library that the linker wraps (a test's "wrap:", tests/CMakeLists.txt), and what takes its
// place.
#define WRAPS(name) __typeof__(name) __real_##name, __wrap_##name

// Runs one set-up before all tests of the program and one tear-down after them.
#define TEST_GROUP(set_up, tear_down)                                                                                  \
    __attribute__((constructor)) static void add_group(void) { test_group(set_up, tear_down); }

void test_add(struct CMUnitTest test, int line);
void test_group(CMFixtureFunction set_up, CMFixtureFunction tear_down);
void test_each_case(size_t count, void (*run)(size_t index));

// ---- What a test owns -----------------------------------------------------------------------------------------------

// Registers `it` and returns it. It is released when the test ends, the last first, also when the test fails; after all
// tests, what the set-up of TEST_GROUP owns.
void *test_own(void *it, void (*release)(void *));
// Returns memory of zeros that the test owns.
void *test_allocate(size_t count, size_t size);
// Releases at once; NULL is left alone.
void test_release(void *it);
// Returns how many objects it owns; test_release_to() releases those that came later.
size_t test_owned(void);
void test_release_to(size_t count);

// ---- Assertions -----------------------------------------------------------------------------------------------------

// Goes before a declaration: AUTO ends what the variable holds by a call of `end` with its address, and AUTO_FREE frees
// it, when its block ends. (A failing test leaves the block without that.)
#define AUTO(end) __attribute__((cleanup(end)))
#define AUTO_FREE AUTO(free_at_end)

static inline void free_at_end(void *variable) {
    void *pointer;
    memcpy(&pointer, variable, sizeof pointer);
    free(pointer);
}

// Fails the test, with the call and its message, unless the call gives VW_OK.
#define ASSERT_OK(call)                                                                                                \
    do {                                                                                                               \
        enum vw_status status_of_call = (call);                                                                        \
        if (status_of_call) fail_msg("%s gave %d: %s", #call, (int)status_of_call, vw_error_message());                \
    } while (0)

// Fails the test unless the call gives the error, with a message of one line that contains all of the texts.
#define ASSERT_FAILS(call, error, ...) assert_fails_at(#call, __FILE__, __LINE__, (call), (error), __VA_ARGS__, NULL)
// The same in a table: `name` says which of its cases failed.
#define ASSERT_CASE_FAILS(name, call, error, ...)                                                                      \
    assert_fails_at((name), __FILE__, __LINE__, (call), (error), __VA_ARGS__, NULL)

__attribute__((sentinel)) static inline void assert_fails_at(const char *call, const char *file, int line,
                                                             enum vw_status status, enum vw_status error, ...) {
    const char *message = status ? vw_error_message() : "", *missing = strchr(message, '\n') ? "a single line" : NULL;
    va_list texts;
    va_start(texts, error);
    for (const char *text = va_arg(texts, const char *); text && !missing; text = va_arg(texts, const char *))
        if (!strstr(message, text)) missing = text;
    va_end(texts);
    if (status == error && !missing) return;
    print_error("%s gave %d: %s, not %d: %s\n", call, (int)status, message, (int)error, missing ? missing : "");
    _fail(file, line);
}

// Comparison of doubles; cmocka 1.1.5 has it only for floats.
#define assert_near(value, expected, tolerance) assert_near_at(value, expected, tolerance, #value, __FILE__, __LINE__)

static inline void assert_near_at(double value, double expected, double tolerance, const char *what, const char *file,
                                  int line) {
    if (fabs(value - expected) <= tolerance) return; // false for NaN
    print_error("%s is %.12g, not %.12g to within %g\n", what, value, expected, tolerance);
    _fail(file, line);
}

#endif
