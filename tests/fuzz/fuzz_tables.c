#include "fuzz/fuzz.h"

// Tries a table of a report; the first byte says which one.
void fuzz_tables(const uint8_t *data, size_t size_bytes) {
    static const char *const names[] = {"providers.csv", "payout.csv", "duplicates.csv", "tradeoff.csv", "summary.csv"};
    enum { NAME_COUNT = sizeof names / sizeof names[0] };
    const char *name = names[size_bytes ? data[0] % NAME_COUNT : 0];
    fuzz_check_report(name, data + (size_bytes > 0), size_bytes - (size_bytes > 0));
}
