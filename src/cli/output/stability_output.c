#include "cli/output/stability_output.h"
#include "cli/output/print.h"

#include "base/json.h"

void vw_stability_print(const struct vw_stability *stability, double wanted, const struct vw_config *config) {
    bool stable = vw_stability_reaches(stability, wanted);
    if (stability->epochs < VW_STABILITY_EPOCHS_MIN) {
        vw_print("not stable: %u epochs count, of which at least %d are wanted; take more --epochs\n",
                 stability->epochs, VW_STABILITY_EPOCHS_MIN);
        return;
    }
    vw_print("%s after epoch %u: scores rank as those of half the epochs did by %.3f or more at the last %d ends "
             "(Spearman; wanted %g)%s\n",
             stable ? "stable  " : "not stable", config->burn_in_epochs + stability->epochs, stability->correlation,
             VW_STABILITY_ENDS, wanted, stable ? "" : "; take more --epochs");
}

json_t *vw_stability_to_json(const struct vw_stability *stability, double wanted) {
    return json_pack("{s:b, s:i, s:i, s:o, s:f}", "stable", vw_stability_reaches(stability, wanted), "epochs",
                     (int)stability->epochs, "earlier_epochs", (int)stability->earlier_epochs, "correlation",
                     vw_json_real(stability->correlation), "wanted", wanted);
}
