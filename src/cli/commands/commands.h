// The commands, one file each: options -> open -> call -> close. Results go to stdout, everything else to stderr.
#ifndef VIEWWORTH_CLI_COMMANDS_COMMANDS_H
#define VIEWWORTH_CLI_COMMANDS_COMMANDS_H

#include "cli/options.h"
#include "viewworth/status.h"

enum vw_status vw_command_devices(const struct vw_options *options);
enum vw_status vw_command_info(const struct vw_options *options);
enum vw_status vw_command_value(const struct vw_options *options);
enum vw_status vw_command_batch(const struct vw_options *options);
enum vw_status vw_command_merge(const struct vw_options *options);
enum vw_status vw_command_worth(const struct vw_options *options);
enum vw_status vw_command_train(const struct vw_options *options);
enum vw_status vw_command_lasting(const struct vw_options *options);
enum vw_status vw_command_render(const struct vw_options *options);
enum vw_status vw_command_tradeoff(const struct vw_options *options);
enum vw_status vw_command_compare(const struct vw_options *options);
enum vw_status vw_command_report(const struct vw_options *options);
enum vw_status vw_command_verify(const struct vw_options *options);
enum vw_status vw_command_select(const struct vw_options *options);
enum vw_status vw_command_import_steps(const struct vw_options *options);

#endif
