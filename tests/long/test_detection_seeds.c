// Detection on all recipes with three seeds each: two minutes; tests/train/test_detection.c has one of them.
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "support/detection_cases.h"
#include "support/gpu_fixture.h"

static void test_three_seeds(void **state) {
    (void)state;
    detection_check(1, 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_three_seeds)};
    return cmocka_run_group_tests(tests, NULL, test_gpu_close);
}
