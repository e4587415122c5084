// A job as a process of its own, so that one that crashes ends no other.
#ifndef VIEWWORTH_BATCH_CHILD_H
#define VIEWWORTH_BATCH_CHILD_H

#include <stddef.h>
#include <sys/types.h>

#include "viewworth/status.h"

// The variable by which a child learns which process started it. The program asks the kernel to be ended with that
// process (cli/interrupt.h), so that a batch that is killed leaves none behind.
#define VW_CHILD_PARENT_VARIABLE "VIEWWORTH_BATCH_PROCESS"

// Starts `program` with these words (the first is its name; NULL ends them) in a process group of its own: Ctrl-C does
// not reach it. Stdout and stderr are added to the file `log_path`, which may not be a link.
enum vw_status vw_child_start(const char *program, char *const *words, const char *log_path, pid_t *process);

// Runs the program of the PATH that the first word names to its end. `text` gets what it prints on stdout and stderr,
// up to size - 1 bytes. VW_ERROR_IO where it cannot be started.
enum vw_status vw_child_read(char *const *words, char *text, size_t size, int *exit_code);

#endif
