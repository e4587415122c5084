#include "run/until_stable.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/output/json_output.h"
#include "run/scoring.h"
#include "viewworth/value.h"

static bool is_asked_for(const struct vw_training_run *run) { return run->options->until_stable > 0; }

static bool is_stable(const struct vw_training_run *run) {
    return vw_stability_reaches(&run->stability, run->options->until_stable);
}

enum vw_status vw_until_stable_check_option(const struct vw_options *options) {
    double wanted = options->until_stable;
    if (wanted >= 0 && wanted < 1) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--until-stable takes a rank correlation of 0 (never stop) to below 1, not %g",
                   wanted);
}

enum vw_status vw_until_stable_measure(struct vw_training_run *run, bool *stable) {
    *stable = false;
    if (!is_asked_for(run)) return VW_OK;
    struct vw_value_input input;
    enum vw_status status = vw_scoring_load(run->ledger, &run->options->config, &input);
    if (!status) status = vw_value_stability(&input, vw_value_default_method, &run->stability);
    vw_scoring_unload(&input);
    *stable = !status && is_stable(run);
    return status;
}

void vw_until_stable_print(const struct vw_training_run *run) {
    const struct vw_stability *stability = &run->stability;
    if (!is_asked_for(run)) return;
    if (stability->epochs < VW_STABILITY_EPOCHS_MIN) {
        printf("not stable: %u epochs count, of which at least %d are wanted; take more --epochs\n", stability->epochs,
               VW_STABILITY_EPOCHS_MIN);
        return;
    }
    uint32_t epochs = run->options->config.burn_in_epochs + stability->epochs;
    printf("%s after epoch %u: scores rank as those of half the epochs did by %.3f or more at the last %d ends "
           "(Spearman; wanted %g)%s\n",
           is_stable(run) ? "stable  " : "not stable", epochs, stability->correlation, VW_STABILITY_ENDS,
           run->options->until_stable, is_stable(run) ? "" : "; take more --epochs");
}

json_t *vw_until_stable_to_json(const struct vw_training_run *run) {
    const struct vw_stability *stability = &run->stability;
    if (!is_asked_for(run)) return NULL;
    return json_pack("{s:b, s:i, s:i, s:o, s:f}", "stable", is_stable(run), "epochs", (int)stability->epochs,
                     "earlier_epochs", (int)stability->earlier_epochs, "correlation",
                     vw_json_real(stability->correlation), "wanted", run->options->until_stable);
}
