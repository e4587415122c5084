// Recipes that combine what effects simulate, with what is true of them, held against what detection says. For programs
// that use test_gpu().
#ifndef TESTS_SUPPORT_DETECTION_CASES_H
#define TESTS_SUPPORT_DETECTION_CASES_H

#include <stdint.h>

#include "viewworth/scene.h"

// Decides on every case with `seed_count` seeds, prints evidence and a confusion matrix over all effects, and fails the
// test on a mistake.
void detection_check(uint64_t first_seed, uint32_t seed_count);

// A scene that calls for nothing; owned by the caller.
struct vw_scene *detection_plain_scene(void);

#endif
