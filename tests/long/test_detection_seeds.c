// Detection on all recipes with three seeds each: two minutes; tests/detect/test_detection.c has one of them.

#include "support/cmocka_test.h"

#include "support/detection_cases.h"
#include "support/gpu_fixture.h"

TEST(verdicts_hold_for_three_seeds) { detection_check(1, 3, true); }

TEST_GROUP(NULL, test_gpu_close)
