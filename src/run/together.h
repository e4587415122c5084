// Runs of one session that take their steps together: as many are opened as fit on the devices.
#ifndef VIEWWORTH_RUN_TOGETHER_H
#define VIEWWORTH_RUN_TOGETHER_H

#include <stdint.h>

#include "run/session.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

struct vw_together_params {
    const struct vw_session *session; // opened by the first run unless it is open
    uint32_t together;                // runs on each device; 0: as many as fit in its memory
    // Opens the run `place` on a device of the session. `*run` stays untouched on failure.
    enum vw_status (*open_run)(void *context, uint32_t place, uint32_t device, struct vw_run **run);
    // Ends a run whose steps ended with `stepped`; the run is closed after it. Its failure counts like one of a step.
    enum vw_status (*finish)(void *context, uint32_t place, enum vw_status stepped, struct vw_run *run);
    void *context;
};

// Makes the first of `count` > 0 runs, as many as fit: `*made`. Every run is tried, and the first failure is returned.
enum vw_status vw_together_make(const struct vw_together_params *params, uint32_t count, uint32_t *made);

#endif
