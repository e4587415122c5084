// Recipes that combine what effects simulate, with what is true of them, held against what detection says. For programs
// that use test_gpu().
#ifndef VIEWWORTH_TESTS_SUPPORT_DETECTION_CASES_H
#define VIEWWORTH_TESTS_SUPPORT_DETECTION_CASES_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"

// Decides what files and points tell of every case with `seed_count` seeds; with `pilots` also the rest, by default
// pilots. Prints a confusion matrix, and fails the test on a mistake about what files and points tell. What pilots gain
// does not follow from what a recipe is made of: their mistakes are only printed.
void detection_check(uint64_t first_seed, uint32_t seed_count, bool pilots);

// Makes a scene that calls for nothing, and one with a bright sky; owned by the caller.
struct vw_scene *detection_plain_scene(void);
struct vw_scene *detection_sky_scene(void);

#endif
