// Several jobs of a batch in one process of `value`.
#ifndef VIEWWORTH_CLI_COMMANDS_VALUE_JOBS_H
#define VIEWWORTH_CLI_COMMANDS_VALUE_JOBS_H

#include "cli/options.h"

// Values the scene with each of the seeds ("0,1,2", as the batch gives them), as many at a time as --together says, or
// the device. The run of seed K goes to seed-K beside --out, and what is said of it to the log next to it. Reports the
// first failure after the others have ended.
enum vw_status vw_value_jobs(const struct vw_options *options, const char *seeds);

#endif
