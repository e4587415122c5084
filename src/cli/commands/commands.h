// The commands, one file each: options -> open -> call -> close. Results go to stdout, everything else to stderr.
#ifndef VIEWWORTH_CLI_COMMANDS_COMMANDS_H
#define VIEWWORTH_CLI_COMMANDS_COMMANDS_H

#include "cli/options.h"
#include "experiment/sweep/sweep.h"
#include "viewworth/status.h"

enum vw_status vw_command_devices(const struct vw_options *options);
enum vw_status vw_command_info(const struct vw_options *options);
enum vw_status vw_command_check(const struct vw_options *options);
enum vw_status vw_command_value(const struct vw_options *options);
enum vw_status vw_command_batch(const struct vw_options *options);
enum vw_status vw_command_merge(const struct vw_options *options);
enum vw_status vw_command_worth(const struct vw_options *options);
enum vw_status vw_command_train(const struct vw_options *options);
enum vw_status vw_command_lasting(const struct vw_options *options);
enum vw_status vw_command_export(const struct vw_options *options);
enum vw_status vw_command_next(const struct vw_options *options);
enum vw_status vw_command_render(const struct vw_options *options);
enum vw_status vw_command_tradeoff(const struct vw_options *options);
enum vw_status vw_command_compare(const struct vw_options *options);
enum vw_status vw_command_report(const struct vw_options *options);
enum vw_status vw_command_verify(const struct vw_options *options);
enum vw_status vw_command_select(const struct vw_options *options);
enum vw_status vw_command_import_steps(const struct vw_options *options);

// Values the scene with each of the seeds ("0,1,2", as a batch gives them), as many at a time as --together says, or
// the device. The run of seed K goes to seed-K beside --out, and what is said of it to the log next to it. Reports the
// first failure after the others have ended.

// Refuses, before the run of `value --retrainings` is trained, unusable options.
enum vw_status vw_worth_check_options(const struct vw_options *options);
// Makes the worth of the run in `out` and prints it; `answer` takes the new advice (NULL: nothing does).
struct vw_answer;
enum vw_status vw_worth_of_run(const struct vw_options *options, const char *out, uint32_t retrainings,
                               struct vw_answer *answer);

// Writes the report, with a further table (NULL: none), and prints its path.
enum vw_status vw_report_make(const struct vw_options *options, const struct vw_report_extra *extra);

// Measures the trade-off and prints it. `evaluator` says how good the scores are; NULL: no one does.
enum vw_status vw_tradeoff_make(const struct vw_options *options, const struct vw_sweep_follower *follower);

#endif
