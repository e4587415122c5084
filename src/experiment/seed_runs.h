// Valued runs that differ by their seed alone, each in its folder OUT/seed_<seed> as `value` writes it, and read again
// from there.
#ifndef VIEWWORTH_SEED_RUNS_H
#define VIEWWORTH_SEED_RUNS_H

#include <stdint.h>

#include "cli/options.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Makes the runs of the seeds options->config.seed + first_seed_offset and the `count - 1` after it in folders of
// options->out, as `value
// --resume` would: one that is there is gone on with, and a finished one left alone. Device and scene are opened once
// for all. VW_ERROR_USAGE when a seed is too large, or names what differs in a folder that holds another run;
// VW_ERROR_INTERRUPTED keeps what is recorded, and the same call goes on.
enum vw_status vw_seed_runs_make(const struct vw_options *options, uint32_t first_seed_offset, uint32_t count);
// Where a file of a seed's run lies ("field.vwf"), owned by the caller; NULL when memory is short.
char *vw_seed_run_path(const char *out, uint64_t seed, const char *file);
// The ledger of a seed's run, for the caller to close. VW_ERROR_INPUT when there is none.
enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger);

#endif
