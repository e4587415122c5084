// Ctrl-C and SIGTERM as a request to stop between two pieces of work, so that what is recorded stays whole.
#ifndef VIEWWORTH_CLI_INTERRUPT_H
#define VIEWWORTH_CLI_INTERRUPT_H

#include "base/interrupt.h"

// Returns an interrupt that watches from the first time that it is asked. The first SIGINT or SIGTERM of the process
// after that only makes it requested; the second one ends the program. A signal before that ends the program at once.
struct vw_interrupt vw_interrupt_watch(void);
// Asks the kernel for a SIGTERM when the batch that started this process ends, however it ends; nothing without one.
void vw_interrupt_follow_batch(void);

#endif
