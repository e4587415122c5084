// Ctrl-C and SIGTERM as a request to stop between two pieces of work, so that what is recorded stays whole.
#ifndef VIEWWORTH_CLI_INTERRUPT_H
#define VIEWWORTH_CLI_INTERRUPT_H

#include "base/interrupt.h"

// From here on the first SIGINT or SIGTERM of the process only makes the returned interrupt requested; the second one
// ends the program at once.
struct vw_interrupt vw_interrupt_watch(void);

#endif
