// Checks that a run, its ledger and the files that it left were not changed. src/ledger/README.md tells what that
// proves.
#ifndef VIEWWORTH_RUN_VERIFY_VERIFY_H
#define VIEWWORTH_RUN_VERIFY_VERIFY_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "run/outputs/checksums.h"
#include "run/recorded/recorded_run.h"
#include "viewworth/status.h"
#include "viewworth/types.h"
#include "viewworth/value.h"

struct vw_verify_params {
    const char *out;       // the folder of the run
    const char *expect;    // the chain head that an earlier command printed; NULL: not compared
    const char *providers; // FILE.csv, by which providers.csv and payout.csv were made; NULL: those of the ledger
    uint64_t replay_steps; // the first N steps are repeated and compared bit for bit; 0: none
    bool lasting;          // so is the backward pass of lasting credit
    const char *device;    // for that; NULL: the one that the ledger names
    struct vw_interrupt interrupt; // stops repeating
};

// One row of the table: what was checked, how it went ("intact", "claimed", "absent", "not checked"), and by what.
// Static texts.
struct vw_verify_item {
    const char *name, *result, *by;
};
enum { VW_VERIFY_ITEMS_MAX = 32 };

struct vw_verification {
    char *ledger_path; // owned
    char run_id[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    char status[32];                    // the run's status
    char log_sha256[VW_HASH_HEX_BYTES]; // SHA-256 of the log of an imported run; "" otherwise
    uint64_t steps, replayed_steps;
    bool lasting_repeated;
    uint32_t score_count, retrainings;
    struct vw_verify_item items[VW_VERIFY_ITEMS_MAX];
    uint32_t item_count;
    struct vw_checksums_found list; // names what OUT contains beside the files of SHA256SUMS
};

// Recomputes every hash and score, the identity, and the tables that follow from the ledger; compares the field with
// its hash, and all result files and the chain head with SHA256SUMS. Writes nothing. VW_ERROR_MISMATCH names the first
// difference. `*verification` is untouched on failure; free it by vw_verification_free().
enum vw_status vw_run_verify(const struct vw_verify_params *params, struct vw_verification *verification);
void vw_verification_free(struct vw_verification *verification);

#endif
