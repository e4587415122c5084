// Outputs for people and other programs, from ledger rows alone (no GPU).
#ifndef VIEWWORTH_REPORT_H
#define VIEWWORTH_REPORT_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

// scores.csv (RFC 4180, but lines end with LF): header
// name,provider,method,value,unit,stderr,visits,rank,sampling_error,low,high,rank_low,rank_high; one row per train image and method,
// methods in the given order, best first; rank 1 = most valuable, ties by name. What is unknown is an empty field. Reals are printed so
// that they read back to the same double.
enum vw_status vw_report_write_csv(const char *path, const struct vw_ledger_score *scores, uint32_t score_count,
                                   const struct vw_ledger_image *images, uint32_t image_count);

#endif
