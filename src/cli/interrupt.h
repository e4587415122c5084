// Ctrl-C and SIGTERM as a request to stop between batches, so that what is recorded stays whole.
#ifndef VIEWWORTH_CLI_INTERRUPT_H
#define VIEWWORTH_CLI_INTERRUPT_H

#include <stdbool.h>

// From here on the first SIGINT or SIGTERM only sets a flag (process-wide); the second one ends the program at once.
void vw_interrupt_watch(void);
bool vw_interrupt_requested(void);

#endif
