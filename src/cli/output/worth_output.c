#include "cli/output/worth_output.h"

#include <math.h>
#include <stdlib.h>

#include "cli/output/attribution_output.h"
#include "cli/output/json_output.h"
#include "cli/output/print.h"
#include "ledger/find_image.h"
#include "value/methods.h"

enum { SHOWN_AT_EACH_END = 5 };

// The worths, or their prior; best first.
struct ranking {
    struct vw_ledger_score *scores; // owned
    uint32_t count;
};

static const struct vw_ledger_image *image_of(const struct vw_worth_run *result, const struct vw_ledger_score *score) {
    const struct vw_value_input *input = &result->scoring.input;
    return vw_ledger_find_image(input->images, input->image_count, score->image_id);
}

// ---- Text ----------------------------------------------------------------------------------------------------------

static void print_photo(const struct vw_worth_run *result, const struct vw_ledger_score *score) {
    const struct vw_ledger_image *image = image_of(result, score);
    vw_print("  %+9" VW_SCORE_DIGITS "f ", score->value);
    if (!result->prior)
        vw_print("[%+9" VW_SCORE_DIGITS "f, %+9" VW_SCORE_DIGITS "f] dB  rank %u-%u", score->ci_low, score->ci_high,
                 score->rank_ci_low, score->rank_ci_high);
    vw_print("  %s", image->name);
    if (image->ground_truth) vw_print(" (%s)", image->ground_truth);
    vw_print("\n");
}

static void print_ranking(const struct vw_worth_run *result, const struct ranking *ranking) {
    uint32_t half = ranking->count > 1 ? ranking->count / 2 : ranking->count;
    uint32_t shown = half < SHOWN_AT_EACH_END ? half : SHOWN_AT_EACH_END, helpful = 0, harmful = 0;
    if (!shown) return;
    for (uint32_t i = 0; i < ranking->count; i++) {
        helpful += ranking->scores[i].ci_low > 0;
        harmful += ranking->scores[i].ci_high < 0;
    }
    vw_print("highest worth\n");
    for (uint32_t i = 0; i < shown; i++) print_photo(result, &ranking->scores[i]);
    vw_print("lowest worth\n");
    for (uint32_t i = 0; i < shown; i++) print_photo(result, &ranking->scores[ranking->count - 1 - i]);
    if (!result->prior)
        vw_print("signs    %u photos help and %u harm beyond their 95 %% intervals; of %u nothing is sure\n", helpful,
                 harmful, ranking->count - helpful - harmful);
}

static void print_claims(const struct vw_worth_summary *summary) {
    vw_print("accuracy on left-out retrainings, beyond the number of photos (Spearman, 95 %% interval)\n");
    for (uint32_t i = 0; i < summary->claim_count; i++) {
        const struct vw_worth_accuracy *accuracy = &summary->claims[i].accuracy;
        vw_print("  %+6.2f [%+5.2f, %+5.2f]  %s", accuracy->spearman, accuracy->ci_low, accuracy->ci_high,
                 summary->claims[i].method);
        if (isfinite(accuracy->r2)) vw_print(" (R^2 %.2f; with the number of photos %.2f)", accuracy->r2, summary->r2);
        vw_print("\n");
    }
    if (isfinite(summary->noise_db))
        vw_print("noise    %u trainings on all photos differ by %.3f dB: no score can exceed about %.2f\n",
                 summary->repeat_count, summary->noise_db, summary->ceiling);
    if (!(summary->claims[0].accuracy.ci_low > 0))
        vw_print("trust    these retrainings do not show that worth tells photos apart here: take more, or longer "
                 "runs\n");
}

static void print_text(const struct vw_worth_run *result, const struct ranking *ranking, double until_accuracy) {
    const struct vw_worth_summary *summary = &result->summary;
    if (result->prior)
        vw_print("worth without retrainings is its prior alone: %s, whose level is unknown; --retrainings M measures\n",
                 result->prior);
    else
        vw_print("worth from %u retrainings, %u of them on all photos and %u with whole providers\n",
                 summary->retraining_count, summary->repeat_count, summary->provider_retraining_count);
    if (!result->prior && !summary->claim_count)
        vw_print("too few of them have a value and parts of the photos; take more --retrainings\n");
    print_ranking(result, ranking);
    if (summary->claim_count) print_claims(summary);
    if (summary->claim_count && until_accuracy > 0)
        vw_print("target   %.2f is %s\n", until_accuracy,
                 summary->claims[0].accuracy.ci_low >= until_accuracy ? "reached" : "not reached");
    vw_attribution_print(&result->attribution);
    vw_print("ledger   %s\n", result->recorded.ledger_path);
    if (result->scores_path) vw_print("scores   %s\n", result->scores_path);
    if (result->report_path) vw_print("report   %s\n", result->report_path);
    vw_print("head     %s (note it elsewhere: viewworth verify --expect compares it)\n", result->head);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *photos_to_json(const struct vw_worth_run *result, const struct ranking *ranking) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < ranking->count; i++) {
        const struct vw_ledger_score *score = &ranking->scores[i];
        const struct vw_ledger_image *image = image_of(result, score);
        vw_json_append(&array, json_pack("{s:s, s:s?, s:s?, s:o, s:s, s:o, s:o, s:o, s:I}", "name", image->name,
                                         "provider", image->provider, "ground_truth", image->ground_truth, "value",
                                         vw_json_real(score->value), "unit", score->unit, "stderr",
                                         vw_json_real(score->standard_error), "ci_low", vw_json_real(score->ci_low),
                                         "ci_high", vw_json_real(score->ci_high), "retrainings",
                                         (json_int_t)(result->prior ? 0 : score->visits)));
    }
    return array;
}

static json_t *claims_to_json(const struct vw_worth_summary *summary) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < summary->claim_count; i++) {
        const struct vw_worth_accuracy *accuracy = &summary->claims[i].accuracy;
        vw_json_append(&array, json_pack("{s:s, s:o, s:o, s:o, s:o, s:I}", "method", summary->claims[i].method,
                                         "spearman", vw_json_real(accuracy->spearman), "ci_low",
                                         vw_json_real(accuracy->ci_low), "ci_high", vw_json_real(accuracy->ci_high),
                                         "r2", vw_json_real(accuracy->r2), "retrainings", (json_int_t)accuracy->count));
    }
    return array;
}

static json_t *to_json(const struct vw_worth_run *result, const struct ranking *ranking) {
    const struct vw_worth_summary *summary = &result->summary;
    return json_pack("{s:s, s:s*, s:I, s:I, s:I, s:o, s:o, s:o, s:o, s:o, s:s, s:s*, s:s*, s:s}", "method",
                     result->prior ? result->prior : vw_worth_method, "prior", result->prior, "retrainings",
                     (json_int_t)summary->retraining_count, "on_all_photos", (json_int_t)summary->repeat_count,
                     "with_whole_providers", (json_int_t)summary->provider_retraining_count, "accuracy",
                     claims_to_json(summary), "r2", vw_json_real(summary->r2), "noise_db",
                     vw_json_real(summary->noise_db), "ceiling", vw_json_real(summary->ceiling), "photos",
                     photos_to_json(result, ranking), "ledger", result->recorded.ledger_path, "scores",
                     result->scores_path, "report", result->report_path, "head", result->head);
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_worth_print(const struct vw_worth_run *result, double until_accuracy, bool json) {
    struct ranking ranking;
    enum vw_status status =
        vw_scores_rank(result->scoring.scores, result->scoring.score_count,
                       result->prior ? result->prior : vw_worth_method, &ranking.scores, &ranking.count);
    if (!status && json) {
        json_t *root = to_json(result, &ranking);
        if (root && result->attribution.method && !vw_attribution_add_json(&result->attribution, root)) {
            json_decref(root);
            root = NULL;
        }
        status = vw_json_print(root);
    } else if (!status) print_text(result, &ranking, until_accuracy);
    free(ranking.scores);
    return status;
}
