#include "run/sign.h"

#include "run/signature.h"
#include "run/verify/verify.h"

// A signature vouches for what the folder holds, which somebody may have changed since the run ended.
enum vw_status vw_run_sign(const char *out, const char *key_path, const char *providers) {
    const struct vw_verify_params params = {.out = out, .providers = providers, .to_sign = true};
    struct vw_verification verification = {0};
    enum vw_status status = vw_run_verify(&params, &verification);
    if (!status) status = vw_statement_sign(&verification.statement, out, key_path);
    vw_verification_free(&verification);
    return status ? vw_fail_context(status, "--sign") : VW_OK;
}
