#include "run/lasting_summary.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum vw_status vw_lasting_check_config(const struct vw_config *config) {
    if (!config || config->table_precision == VW_TABLE_FLOAT32) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "lasting credit follows small changes, which tables of halves round away; value the scene with "
                   "--table-precision float32");
}

bool vw_lasting_has_gate(const struct vw_config *config) { return !(config->beta1 > 0); }

bool vw_lasting_is_there(const struct vw_lasting_wanted *wanted, const struct vw_config *config,
                         const struct vw_lasting_sweep *sweep) {
    bool gated = wanted->no_gate || !vw_lasting_has_gate(config) || sweep->check_count > 0;
    return sweep->step_count && gated && (!wanted->rays || wanted->rays == sweep->rays);
}

static int compare_scores(const void *left, const void *right) {
    const struct vw_ledger_score *a = left, *b = right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return a->image_id < b->image_id ? -1 : a->image_id > b->image_id;
}

static enum vw_status fill(struct vw_ledger *ledger, struct vw_lasting_summary *summary) {
    uint32_t kept = 0, count = 0;
    enum vw_status status = vw_ledger_get_images(ledger, &summary->images, &summary->image_count);
    if (!status) status = vw_ledger_get_scores(ledger, &summary->scores, &count);
    if (status) return status;
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(summary->scores[i].method, "lasting_psnr") == 0) summary->scores[kept++] = summary->scores[i];
    summary->score_count = kept;
    if (kept) qsort(summary->scores, kept, sizeof *summary->scores, compare_scores);
    for (uint32_t i = 0; i < summary->image_count; i++)
        summary->steps_per_epoch += strcmp(summary->images[i].split, "train") == 0;
    return VW_OK;
}

enum vw_status vw_lasting_summary_make(struct vw_ledger *ledger, struct vw_lasting_summary *summary) {
    struct vw_lasting_summary made = {0};
    enum vw_status status = vw_ledger_get_lasting(ledger, &made.sweep);
    if (!status && made.sweep.step_count) status = fill(ledger, &made);
    if (status) {
        vw_lasting_summary_free(&made);
        return status;
    }
    vw_lasting_summary_free(summary);
    *summary = made;
    return VW_OK;
}

void vw_lasting_summary_free(struct vw_lasting_summary *summary) {
    vw_lasting_sweep_free(&summary->sweep);
    free(summary->scores);
    *summary = (struct vw_lasting_summary){0};
}
