// scripts/test --full sets VIEWWORTH_FULL: tests that choose some of many cases then run all of them.
#ifndef VIEWWORTH_TESTS_SUPPORT_FULL_H
#define VIEWWORTH_TESTS_SUPPORT_FULL_H

#include <stdbool.h>
#include <stdlib.h>

static inline bool test_is_full(void) { return getenv("VIEWWORTH_FULL") != NULL; }

#endif
