#include "cli/program.h"

#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "batch/batch.h"

static volatile sig_atomic_t requested;

static void request(int signal_number) {
    (void)signal_number;
    requested = 1;
}

// Begins to watch for signals. Until a caller asks, a signal ends the program at once: opening a scene leaves no files,
// and does not ask.
static void watch(void) {
    static bool watching;
    struct sigaction action = {.sa_handler = request, .sa_flags = SA_RESTART | (int)SA_RESETHAND};
    if (watching) return;
    watching = true;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

static bool is_requested(void *context) {
    (void)context;
    watch();
    return requested;
}

struct vw_interrupt vw_interrupt_watch(void) {
    return (struct vw_interrupt){.requested = is_requested};
}

// Ends this process when its batch ends. A batch that ended before this call is no longer its parent.
void vw_interrupt_follow_batch(void) {
    const char *batch = getenv(VW_BATCH_PROCESS_VARIABLE);
    if (!batch) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (strtol(batch, NULL, 10) != getppid()) raise(SIGTERM);
}
