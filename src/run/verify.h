// Checks that the ledger of a run was not changed.
#ifndef VIEWWORTH_RUN_VERIFY_H
#define VIEWWORTH_RUN_VERIFY_H

#include <stdint.h>

#include "base/interrupt.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

struct vw_verify_params {
    const char *out;               // the folder of the run
    const char *expect;            // the chain head that an earlier command printed; NULL: not compared
    uint64_t replay_steps;         // so many first steps are taken again and compared bit for bit; 0: none
    const char *device;            // for that; NULL: the one that the ledger names
    struct vw_interrupt interrupt; // stops taking steps
};

// Of a ledger that is intact.
struct vw_verification {
    char *ledger_path; // owned
    char run_id[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    char status[32];                    // of the run
    char log_sha256[VW_HASH_HEX_BYTES]; // of the log of an imported run; "" otherwise
    uint64_t steps, replayed_steps;
    uint32_t score_count;
};

// Recomputes every hash and every score. VW_ERROR_MISMATCH names the first difference. `*verification` is untouched on
// failure; free it by vw_verification_free().
enum vw_status vw_run_verify(const struct vw_verify_params *params, struct vw_verification *verification);
void vw_verification_free(struct vw_verification *verification);

#endif
