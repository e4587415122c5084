#include "run/lasting/lasting_summary.h"

#include <stdlib.h>
#include <string.h>

#include "value/methods.h"

enum vw_status vw_lasting_check_config(const struct vw_config *config) {
    if (config && config->field == VW_FIELD_SPLATS)
        return vw_fail(VW_ERROR_USAGE,
                       "lasting credit and scores from gradients cannot go back through splats; value the scene with "
                       "--field hash");
    return VW_OK;
}

bool vw_lasting_has_gate(const struct vw_config *config) { return !(config->beta1 > 0); }

bool vw_lasting_is_there(const struct vw_lasting_options *wanted, const struct vw_config *config,
                         const struct vw_lasting_pass *pass) {
    bool gated = wanted->no_gate || !vw_lasting_has_gate(config) || pass->check_count > 0;
    return pass->step_count && gated && (!wanted->rays || wanted->rays == pass->rays) &&
           (!wanted->matrix || pass->view_count);
}

static enum vw_status fill(struct vw_ledger *ledger, struct vw_lasting_summary *summary) {
    struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_ledger_get_images(ledger, &summary->images, &summary->image_count);
    if (!status) status = vw_ledger_get_scores(ledger, &scores, &count);
    if (!status) status = vw_scores_rank(scores, count, "lasting_psnr", &summary->scores, &summary->score_count);
    free(scores);
    for (uint32_t i = 0; !status && i < summary->image_count; i++)
        summary->steps_per_epoch += strcmp(summary->images[i].split, "train") == 0;
    return status;
}

enum vw_status vw_lasting_summary_make(struct vw_ledger *ledger, struct vw_lasting_summary *summary) {
    struct vw_lasting_summary made = {0};
    enum vw_status status = vw_ledger_get_lasting(ledger, &made.pass);
    if (!status && made.pass.step_count) status = fill(ledger, &made);
    if (status) {
        vw_lasting_summary_free(&made);
        return status;
    }
    vw_lasting_summary_free(summary);
    *summary = made;
    return VW_OK;
}

void vw_lasting_summary_free(struct vw_lasting_summary *summary) {
    vw_lasting_pass_free(&summary->pass);
    free(summary->scores);
    *summary = (struct vw_lasting_summary){0};
}
