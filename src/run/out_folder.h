// Checks before any work that results can be written.
#ifndef VIEWWORTH_RUN_OUT_FOLDER_H
#define VIEWWORTH_RUN_OUT_FOLDER_H

#include "viewworth/status.h"

// Writes a file of 1 MiB where --out is or would be made, and removes it again; the folder itself is not created.
// VW_ERROR_USAGE when --out is a file, and when the place is not writable or full.
enum vw_status vw_out_check(const char *out);
// Removes what further steps make out of date: SHA256SUMS, tables, report and the state of a stopped lasting pass.
enum vw_status vw_run_remove_outdated(const char *out);
// Removes the tables of a payout, and SHA256SUMS, which may list them.
enum vw_status vw_run_remove_payouts(const char *out);
// Removes what further scores of the same steps make out of date: SHA256SUMS, tables and report.
enum vw_status vw_run_remove_outdated_scores(const char *out);

#endif
