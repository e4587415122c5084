#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/output/print.h"
#include "cli/output/results.h"
#include "report/tables.h"
#include "value/methods.h"

// ---- Text ----------------------------------------------------------------------------------------------------------

static void print_signs(const struct vw_ranking *ranking) {
    uint32_t helpful = 0, harmful = 0;
    for (uint32_t i = 0; i < ranking->count; i++) {
        helpful += ranking->scores[i].ci_low > 0;
        harmful += ranking->scores[i].ci_high < 0;
    }
    vw_print("signs    %u help and %u harm beyond their 95 %% intervals; %u may do either\n", helpful, harmful,
             ranking->count - helpful - harmful);
}

static void print_claims(const struct vw_worth_summary *summary) {
    vw_print("accuracy on left-out retrainings, beyond the number of photos\n");
    const struct vw_rows claims = vw_claim_rows(summary);
    vw_print_rows(&claims);
    if (isfinite(summary->r2)) vw_print("R^2 with the number of photos %.2f\n", summary->r2);
    if (isfinite(summary->noise_db))
        vw_print("noise    %u trainings on all photos differ by %.2f dB: no score can exceed about %.2f\n",
                 summary->repeat_count, summary->noise_db, summary->ceiling);
    if (!(summary->claims[0].accuracy.ci_low > 0))
        vw_print(
            "trust    these retrainings do not show that worth distinguishes photos here: use more retrainings, or "
            "longer runs\n");
}

static void print_origin(const struct vw_worth_run *result) {
    const struct vw_worth_summary *summary = &result->summary;
    if (result->prior)
        vw_print(
            "worth without retrainings is its prior alone: %s, whose level is unknown; --retrainings M measures it\n",
            result->prior);
    else
        vw_print("worth from %u retrainings, %u of them on all photos\n", summary->retraining_count,
                 summary->repeat_count);
}

static void print_text(const struct vw_worth_run *result, const struct vw_ranking *ranking, double until_confidence) {
    const struct vw_worth_summary *summary = &result->summary;
    print_origin(result);
    if (!result->prior && !summary->claim_count)
        vw_print("too few retrainings on a part of the photos have a result; increase --retrainings\n");
    vw_ranking_print(ranking, "highest worth", "lowest worth");
    if (!result->prior && ranking->count) print_signs(ranking);
    if (summary->claim_count) print_claims(summary);
    if (summary->claim_count && until_confidence > 0)
        vw_print("target   %.2f is %s\n", until_confidence,
                 summary->claims[0].accuracy.ci_low >= until_confidence ? "reached" : "not reached");
    vw_attribution_print(&result->outputs.attribution);
    vw_print("ledger   %s\n", result->recorded.ledger_path);
    if (result->scores_path) vw_print("scores   %s\n", result->scores_path);
    if (result->outputs.report_path) vw_print("report   %s\n", result->outputs.report_path);
    vw_print("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", result->head);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *photos_to_json(const struct vw_worth_run *result, const struct vw_ranking *ranking) {
    json_t *photos = vw_ranking_to_json(ranking, VW_RANKING_ALL);
    for (uint32_t i = 0; i < json_array_size(photos); i++)
        json_object_set_new(json_array_get(photos, i), "retrainings",
                            json_integer(result->prior ? 0 : ranking->scores[i].visits));
    return photos;
}

static json_t *to_json(const struct vw_worth_run *result, const struct vw_ranking *ranking) {
    const struct vw_worth_summary *summary = &result->summary;
    const struct vw_rows claims = vw_claim_rows(summary);
    json_t *root = json_pack("{s:s, s:s*, s:I, s:I, s:o, s:o, s:o, s:o, s:o, s:s, s:s*, s:s*, s:s}", "method",
                             result->prior ? result->prior : vw_worth_method, "prior", result->prior, "retrainings",
                             (json_int_t)summary->retraining_count, "on_all_photos", (json_int_t)summary->repeat_count,
                             "accuracy", vw_rows_to_json(&claims), "r2", vw_json_real(summary->r2), "noise_db",
                             vw_json_real(summary->noise_db), "ceiling", vw_json_real(summary->ceiling), "photos",
                             photos_to_json(result, ranking), "ledger", result->recorded.ledger_path, "scores",
                             result->scores_path, "report", result->outputs.report_path, "head", result->head);
    if (result->outputs.attribution.method) vw_attribution_add_json(&result->outputs.attribution, &root);
    return root;
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_worth_print(const struct vw_worth_run *result, double until_confidence, bool json) {
    const struct vw_scoring *scoring = &result->scoring;
    struct vw_ledger_score *scores = NULL;
    struct vw_ranking ranking = {.images = scoring->input.images, .image_count = scoring->input.image_count};
    enum vw_status status = vw_scores_rank(scoring->scores, scoring->score_count,
                                           result->prior ? result->prior : vw_worth_method, &scores, &ranking.count);
    ranking.scores = scores;
    if (!status && json) status = vw_json_print(to_json(result, &ranking));
    else if (!status) print_text(result, &ranking, until_confidence);
    free(scores);
    return status;
}
