// Detection on all recipes with three seeds each: two minutes; tests/train/test_detection.c has one of them.

#include "support/cmocka_test.h"

#include "support/detection_cases.h"
#include "support/gpu_fixture.h"

static void verdicts_hold_for_three_seeds(void **state) {
    (void)state;
    detection_check(1, 3, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(verdicts_hold_for_three_seeds)};
    return cmocka_run_group_tests(tests, NULL, test_gpu_close);
}
