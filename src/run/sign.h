// Signs a run.
#ifndef VIEWWORTH_RUN_SIGN_H
#define VIEWWORTH_RUN_SIGN_H

#include "viewworth/status.h"

// Verifies the run in OUT, which must have ended, and signs it with the secret key in the file `key_path`: writes
// OUT/signature.json. `providers`: see vw_verify_params.
enum vw_status vw_run_sign(const char *out, const char *key_path, const char *providers);

#endif
