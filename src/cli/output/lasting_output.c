#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "cli/output/print.h"
#include "cli/output/results.h"
#include "ledger/find_image.h"
#include "value/lasting_scores.h"

static const double GROWTH_WORTH_A_WORD = 2; // growth of |lambda|; scenes that passed the gate stayed below it

static const char *name_of(const struct vw_lasting_summary *summary, uint32_t image_id) {
    const struct vw_ledger_image *image = vw_ledger_find_image(summary->images, summary->image_count, image_id);
    return image ? image->name : "?";
}

static struct vw_ranking ranking_of(const struct vw_lasting_summary *summary) {
    return (struct vw_ranking){.scores = summary->scores,
                               .count = summary->score_count,
                               .images = summary->images,
                               .image_count = summary->image_count};
}

// A photo of the gate.
struct row {
    const char *name;
    struct vw_gate_check check;
};

#define OF_CHECK(member, heading)                                                                                      \
    { VW_CELL(#member, struct row, REAL_OR_NULL, check.member), .title = heading, .digits = 2, .has_sign = true }
static const struct vw_column columns[] = {
    OF_CHECK(predicted_psnr, "predicted, dB"),
    OF_CHECK(measured_psnr, "measured, dB"),
    OF_CHECK(predicted_loss, NULL),
    OF_CHECK(measured_loss, NULL),
    {VW_CELL("from_step", struct row, COUNT64, check.from_step)},
    {VW_CELL("name", struct row, TEXT, name), .title = "photo"},
};

// Lists the photos of the gate, owned by the caller.
static struct vw_rows list_checks(const struct vw_lasting_summary *summary) {
    uint32_t count = summary->pass.check_count;
    struct row *rows = vw_allocate(count, sizeof *rows);
    for (uint32_t i = 0; rows && i < count; i++)
        rows[i] = (struct row){name_of(summary, summary->pass.checks[i].image_id), summary->pass.checks[i]};
    return VW_ROWS(columns, rows, rows ? count : 0);
}

static bool is_trusted(double gate) { return gate >= vw_lasting_gate_least; } // not if it is NaN

// ---- Text ----------------------------------------------------------------------------------------------------------

static void print_growth(const struct vw_lasting_growth *growth, bool trusted) {
    if (growth->factor > GROWTH_WORTH_A_WORD)
        vw_print("         the gradient grew %.1f-fold during the backward pass, from step %" PRIu64 " to step %" PRIu64
                 "%s\n",
                 growth->factor, growth->last_step, growth->first_step,
                 trusted ? "" : ": small errors grow with it; a lower --lr helps");
    else if (!trusted)
        vw_print(
            "         the gradient did not grow during the backward pass (%.1f-fold at most): the changes of "
            "the gate may be too large for a first-order prediction, or too small to measure; more --val-rays help\n",
            growth->factor);
}

static void print_gate(const struct vw_lasting_summary *summary) {
    const struct vw_lasting_pass *pass = &summary->pass;
    const struct vw_lasting_growth growth = vw_lasting_growth_of(pass, summary->steps_per_epoch);
    double psnr = vw_lasting_gate(pass, false), loss = vw_lasting_gate(pass, true);
    if (!pass->check_count) {
        vw_print("gate     none (--no-gate, or a run with momentum): lasting credit is not checked here\n");
        return;
    }
    vw_print("gate     change of the final PSNR when the steps on a photo after step %" PRIu64 " are made longer\n",
             pass->checks->from_step);
    const struct vw_rows checks = list_checks(summary);
    vw_print_rows(&checks);
    free((void *)checks.rows);
    vw_print("         Pearson's correlation %.2f (mean absolute error: %.2f)\n", psnr, loss);
    if (!is_trusted(psnr)) vw_print("         below %.1f: do not trust lasting credit here\n", vw_lasting_gate_least);
    print_growth(&growth, is_trusted(psnr));
}

void vw_lasting_print(const struct vw_lasting_summary *summary) {
    const struct vw_ranking ranking = ranking_of(summary);
    vw_ranking_print(&ranking,
                     "highest lasting credit (lasting_psnr: what the steps on the photo leave at the end; compare "
                     "photos with each other, since zero has no meaning)",
                     "lowest lasting credit");
    print_gate(summary);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *gate_to_json(const struct vw_lasting_summary *summary) {
    const struct vw_lasting_pass *pass = &summary->pass;
    if (!pass->check_count) return json_null();
    double psnr = vw_lasting_gate(pass, false);
    const struct vw_rows checks = list_checks(summary);
    json_t *photos = vw_rows_to_json(&checks);
    free((void *)checks.rows);
    return json_pack("{s:o, s:o, s:b, s:o}", "pearson_psnr", vw_json_real(psnr), "pearson_loss",
                     vw_json_real(vw_lasting_gate(pass, true)), "trusted", is_trusted(psnr), "photos", photos);
}

json_t *vw_lasting_to_json(const struct vw_lasting_summary *summary) {
    const struct vw_ranking ranking = ranking_of(summary);
    const struct vw_lasting_pass *pass = &summary->pass;
    const struct vw_lasting_growth growth = vw_lasting_growth_of(pass, summary->steps_per_epoch);
    return json_pack("{s:I, s:I, s:I, s:I, s:b, s:{s:o, s:I, s:I}, s:o, s:o, s:o}", "steps",
                     (json_int_t)pass->step_count, "rays", (json_int_t)pass->rays, "epochs", (json_int_t)pass->epochs,
                     "states", (json_int_t)pass->states, "has_zero", 0, "growth", "factor", vw_json_real(growth.factor),
                     "first_step", (json_int_t)growth.first_step, "last_step", (json_int_t)growth.last_step, "gate",
                     gate_to_json(summary), "highest", vw_ranking_to_json(&ranking, VW_RANKING_HIGHEST), "lowest",
                     vw_ranking_to_json(&ranking, VW_RANKING_LOWEST));
}
