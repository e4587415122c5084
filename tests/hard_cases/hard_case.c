#include "hard_cases/hard_case.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "support/gpu_fixture.h"

struct row {
    const struct hard_case *hard_case;
    struct hard_finding finding;
};

static struct table {
    const char *group;
    struct row *rows;
    size_t count;
} table;

static void run_row(void **state) {
    struct row *row = *state;
    row->finding.where = row->hard_case->name;
    row->hard_case->run(&row->finding);
    if (!row->finding.compared) fail_msg("%s: nothing was compared", row->hard_case->name);
    row->finding.passed = true;
}

static int text_width(const struct row *rows, size_t count, const char *heading,
                      const char *(*text)(const struct row *)) {
    size_t width = strlen(heading);
    for (size_t i = 0; i < count; i++)
        if (strlen(text(&rows[i])) > width) width = strlen(text(&rows[i]));
    return (int)width;
}

static const char *name_of(const struct row *row) { return row->hard_case->name; }
static const char *risk_of(const struct row *row) { return row->hard_case->risk; }
static const char *quantity_of(const struct row *row) { return row->finding.quantity ? row->finding.quantity : ""; }

static void print_table(void) {
    const struct row *rows = table.rows;
    int name = text_width(rows, table.count, "case", name_of),
        risk = text_width(rows, table.count, "what could go wrong", risk_of),
        quantity = text_width(rows, table.count, "nearest its tolerance", quantity_of);
    printf("\nHard cases: %s\n%-*s | %-*s | %-*s | %-9s | %-9s | %-9s | %s\n", table.group, name, "case", risk,
           "what could go wrong", quantity, "nearest its tolerance", "error", "tolerance", "compared", "verdict");
    for (size_t i = 0; i < table.count; i++) {
        const struct hard_finding *finding = &rows[i].finding;
        printf("%-*s | %-*s | %-*s | %-9.2g | %-9.2g | %-9llu | %s\n", name, name_of(&rows[i]), risk, risk_of(&rows[i]),
               quantity, quantity_of(&rows[i]), finding->error, finding->tolerance,
               (unsigned long long)finding->compared, finding->passed ? "passes" : "FAILS");
    }
    free(table.rows);
}

void hard_cases_add(const char *group, const struct hard_case *cases, size_t count, int line) {
    table = (struct table){group, vw_allocate(count, sizeof *table.rows), count};
    for (size_t i = 0; i < count; i++) {
        table.rows[i].hard_case = &cases[i];
        test_add((struct CMUnitTest){cases[i].name, run_row, NULL, NULL, &table.rows[i]}, line);
    }
    test_group(NULL, test_gpu_close);
    atexit(print_table);
}

// Returns the share of its tolerance that a finding uses up; infinite beyond it and for NaN.
static double used_up(double error, double tolerance) {
    if (error == 0.0) return 0.0;
    return error <= tolerance ? error / tolerance : INFINITY;
}

void hard_compare(struct hard_finding *finding, const char *quantity, uint64_t index, double device, double expected,
                  double scale, double tolerance) {
    double off = fabs(device - expected), error = off == 0.0 ? 0.0 : off / scale;
    if (!isfinite(device) || !isfinite(expected)) error = INFINITY;
    if (!finding->compared++ || used_up(error, tolerance) > used_up(finding->error, finding->tolerance)) {
        finding->quantity = quantity;
        finding->error = error;
        finding->tolerance = tolerance;
    }
    if (!(error <= tolerance))
        fail_msg("%s: %s[%llu] is %.9g on the device, %.9g by the reference: off by %.3g of %.3g, more than %.3g",
                 finding->where, quantity, (unsigned long long)index, device, expected, off, scale, tolerance);
}

void hard_equal(struct hard_finding *finding, const char *quantity, uint64_t index, double device, double expected) {
    hard_compare(finding, quantity, index, device, expected, 1.0, 0.0);
}

void hard_same_bits(struct hard_finding *finding, const char *quantity, const void *device, const void *expected,
                    size_t size_bytes) {
    const unsigned char *a = device, *b = expected;
    size_t i = 0;
    while (i < size_bytes && a[i] == b[i]) i++;
    hard_compare(finding, quantity, i, i < size_bytes ? a[i] : 0, i < size_bytes ? b[i] : 0, 1.0, 0.0);
}

void hard_require(struct hard_finding *finding, bool holds, const char *what) {
    if (!holds) fail_msg("%s: this does not hold: %s", finding->where, what);
}
