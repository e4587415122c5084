// The files in OUT that commands go on from: which of them the ledger binds.
#ifndef VIEWWORTH_RUN_VERIFY_VERIFY_KEPT_H
#define VIEWWORTH_RUN_VERIFY_VERIFY_KEPT_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

struct vw_kept_file {
    const char *name; // static
    bool bound;       // the ledger contains its hash, or those of all rows in it
};
enum { VW_KEPT_FILES_MAX = 8 };

// Lists the files of that kind which are in OUT. A database that cannot be read is not bound: no command uses it.
enum vw_status vw_verify_kept(const char *out, struct vw_ledger *ledger, struct vw_kept_file files[VW_KEPT_FILES_MAX],
                              uint32_t *count);

#endif
