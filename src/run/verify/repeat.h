// Steps and the backward pass of a recorded run, made again and compared with the ledger bit for bit.
#ifndef VIEWWORTH_RUN_VERIFY_REPEAT_H
#define VIEWWORTH_RUN_VERIFY_REPEAT_H

#include "base/interrupt.h"
#include "run/recorded/recorded_run.h"
#include "viewworth/value.h"

struct vw_repeat_params {
    struct vw_recorded_run *run;        // its scene is opened
    const struct vw_value_input *input; // its steps and lasting credit
    const char *device;                 // NULL: the one that the ledger names
    const struct vw_interrupt *interrupt;
};

// Takes steps from step 0 on, until `wanted` of them or all are compared; `*compared` is the last one.
// VW_ERROR_MISMATCH names the first that differs, VW_ERROR_INTERRUPTED that the interrupt was requested, VW_ERROR_USAGE
// what cannot be repeated.
enum vw_status vw_repeat_steps(const struct vw_repeat_params *params, uint64_t wanted, uint64_t *compared);
// Makes the backward pass of lasting credit again, with its gate where it has one. Call it last: the config of the run
// gets the epochs that it took. The same errors.
enum vw_status vw_repeat_lasting(const struct vw_repeat_params *params);

#endif
