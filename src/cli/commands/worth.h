// The end of `value --worth`, which is all of `worth`.
#ifndef VIEWWORTH_CLI_COMMANDS_WORTH_H
#define VIEWWORTH_CLI_COMMANDS_WORTH_H

#include "cli/options.h"

// Refuses unusable options before the run is trained.
enum vw_status vw_worth_check_options(const struct vw_options *options);
// Makes the worth of the run in `out` and prints it.
enum vw_status vw_worth_of_run(const struct vw_options *options, const char *out, uint32_t retrainings);

#endif
