// Hard cases: named situations in which numbers go wrong easily. Each is a cmocka test of its own and a row of the
// table that the program prints at its end: the comparison with the reference that came nearest to its tolerance.
#ifndef VIEWWORTH_TESTS_SUPPORT_HARD_CASE_H
#define VIEWWORTH_TESTS_SUPPORT_HARD_CASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The findings of the comparisons of a case so far.
struct hard_finding {
    const char *where;       // case and seed, for messages
    const char *quantity;    // name of the comparison nearest to its tolerance
    double error, tolerance; // numbers of that comparison
    uint64_t compared;       // comparisons in all
    bool passed;
};

struct hard_case {
    const char *name;
    const char *risk; // mistake that the case would reveal
    void (*run)(struct hard_finding *finding);
};

// Adds the cases of an array to the tests of the program, which then ends with their table and the closed device. A
// case that compares nothing fails.
#define HARD_CASES(group, cases)                                                                                       \
    __attribute__((constructor)) static void add_hard_cases(void) {                                                    \
        hard_cases_add(group, cases, sizeof(cases) / sizeof *(cases), __LINE__);                                       \
    }
void hard_cases_add(const char *group, const struct hard_case *cases, size_t count, int line);

// Fails the case unless |device - expected| <= tolerance * scale; anything not finite fails. With scale 0 only equality
// passes.
void hard_compare(struct hard_finding *finding, const char *quantity, uint64_t index, double device, double expected,
                  double scale, double tolerance);
// Fails the case unless both are finite and equal.
void hard_equal(struct hard_finding *finding, const char *quantity, uint64_t index, double device, double expected);
// Compares bit for bit; counts as one comparison.
void hard_same_bits(struct hard_finding *finding, const char *quantity, const void *device, const void *expected,
                    size_t size_bytes);
// Fails the case unless a condition beside the numbers holds; `what` says it in words.
void hard_require(struct hard_finding *finding, bool holds, const char *what);

#endif
