#include "base/clock.h"

#include <time.h>

static double read_clock_s(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double vw_now_s(void) { return read_clock_s(CLOCK_MONOTONIC); }

double vw_cpu_s(void) { return read_clock_s(CLOCK_PROCESS_CPUTIME_ID); }

bool vw_progress_is_due(double *told_s) {
    static const double EACH_S = 5;
    double now_s = vw_now_s();
    bool due = now_s - *told_s >= EACH_S;
    if (due) *told_s = now_s;
    return due;
}

void vw_utc_now(char text[VW_UTC_BYTES]) {
    time_t now = time(NULL);
    struct tm parts;
    gmtime_r(&now, &parts);
    strftime(text, VW_UTC_BYTES, "%Y-%m-%dT%H:%M:%SZ", &parts);
}
