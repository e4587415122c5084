#include "cli/interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t requested;

static void request(int signal_number) {
    (void)signal_number;
    requested = 1;
}

// Before anyone asks, a signal ends the program at once: opening a scene leaves nothing behind, and does not ask.
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
