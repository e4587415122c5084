// Clocks, for display and for budgets: never for a decision that affects a bit of a step.
#ifndef VIEWWORTH_BASE_CLOCK_H
#define VIEWWORTH_BASE_CLOCK_H

#include <stdbool.h>

double vw_now_s(void); // monotonic seconds
double vw_cpu_s(void); // seconds that all threads of the process have computed

// Returns whether five seconds have passed since `*told_s`, which then becomes now: long work tells its progress.
bool vw_progress_is_due(double *told_s);

enum { VW_UTC_BYTES = 21 }; // "2026-11-21T03:04:05Z"

// Writes the current time, for the ledger's columns only.
void vw_utc_now(char text[VW_UTC_BYTES]);

#endif
