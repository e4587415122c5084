// Help texts on stdout, wrapped at 80 columns; man pages and bash completion. All follow from the tables of commands
// and options.
#ifndef VIEWWORTH_CLI_HELP_H
#define VIEWWORTH_CLI_HELP_H

#include <stdbool.h>

#include "cli/program.h"

// Prints the commands by group.
void vw_help_print_program(const struct vw_program *program);
// Prints a command's usage, its description, and its options by section: the common ones, or all.
void vw_help_print_command(const struct vw_program *program, const struct vw_program_command *command, bool all);

// Writes FOLDER/man/NAME.1, FOLDER/man/NAME-COMMAND.1 for every command, and FOLDER/completion/NAME.
// Existing files are replaced. VW_ERROR_USAGE if `folder` is empty, VW_ERROR_IO if a file cannot be written.
enum vw_status vw_manual_write(const struct vw_program *program, const char *folder);

// ---- Texts about an option, also for errors -------------------------------------------------------------------------

const char *vw_option_section_title(enum vw_option_section section);
bool vw_option_fits(const struct vw_option *option, const struct vw_program_command *command);
bool vw_command_needs_out(const struct vw_program_command *command);
// Writes the numbers that an option accepts, for example "1 to 65536"; "" if it accepts no number.
void vw_option_range(const struct vw_option *option, char text[VW_CONFIG_RANGE_BYTES]);
// The names of an option's choices with the separator between; "" without choices.
enum { VW_OPTION_CHOICES_BYTES = 128 };
void vw_option_choices(const struct vw_option *option, char separator, char text[VW_OPTION_CHOICES_BYTES]);
// "--rays N", "--out FOLDER, -o FOLDER".
enum { VW_OPTION_USAGE_BYTES = 160 };
void vw_option_usage(const struct vw_option *option, char text[VW_OPTION_USAGE_BYTES]);
// The help sentence with range and default: "Training rays per step (1 to 65536, default 250)."
enum { VW_OPTION_HELP_BYTES = 640 };
void vw_option_sentence(const struct vw_program *program, const struct vw_option *option,
                        char text[VW_OPTION_HELP_BYTES]);

#endif
