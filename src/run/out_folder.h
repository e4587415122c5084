// Checks before any work that results can be written.
#ifndef VIEWWORTH_RUN_OUT_FOLDER_H
#define VIEWWORTH_RUN_OUT_FOLDER_H

#include <stdbool.h>

#include "viewworth/status.h"

// Checks where --out is or would be made; the folder itself is not created. VW_ERROR_USAGE when --out is a file, and
// when this user may not write at that place.
enum vw_status vw_out_check(const char *out);
// Refuses the name of a file to write, as an option gives it, unless it ends in .ply, or in .json if `json`, is not
// there yet, and is not a name of vw_out_files in `out`. NULL is fine.
enum vw_status vw_out_check_target(const char *option, const char *path, const char *out, bool json);
// Removes what further steps make out of date: all derived files, the field, and the state of a stopped lasting pass.
enum vw_status vw_run_remove_outdated(const char *out, bool pays);
// Removes all derived files, whoever made them: SHA256SUMS, tables, report and what the report needs. Unless the caller
// `pays`, a removed payout is told, and how to ask for one again.
enum vw_status vw_run_remove_derived(const char *out, bool pays);

#endif
