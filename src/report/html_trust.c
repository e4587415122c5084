#include "report/html_trust.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "ledger/find_image.h"
#include "value/lasting_scores.h"

enum { GROWTH_SHOWN = 1000 };

json_t *vw_html_gate(const struct vw_report_run *run) {
    if (!run->lasting.check_count) return json_null();
    json_t *gate = json_object(), *images = json_array(), *predicted = json_array(), *measured = json_array();
    for (uint32_t i = 0; i < run->lasting.check_count; i++) {
        const struct vw_gate_check *check = &run->lasting.checks[i];
        const struct vw_ledger_image *image = vw_ledger_find_image(run->images, run->image_count, check->image_id);
        vw_json_append(&images, image ? json_integer(image - run->images) : json_null());
        vw_json_append(&predicted, vw_json_real(check->predicted_psnr));
        vw_json_append(&measured, vw_json_real(check->measured_psnr));
    }
    vw_json_set(&gate, "image", images);
    vw_json_set(&gate, "predicted", predicted);
    vw_json_set(&gate, "measured", measured);
    vw_json_set(&gate, "correlation", vw_json_real(vw_lasting_gate(&run->lasting, false)));
    vw_json_set(&gate, "least", json_real(vw_lasting_gate_least));
    return gate;
}

// Reads what report_files.c has checked; without a file nothing is known.
static struct vw_reconstruction reconstruction_of(const struct vw_report_run *run) {
    const char *text = run->reconstruction_json;
    struct vw_reconstruction reconstruction = {0};
    json_t *json = text ? vw_json_load(text, strlen(text), 0, NULL) : NULL;
    if (!json || vw_reconstruction_from_json(json, &reconstruction)) reconstruction = vw_reconstruction_unknown;
    json_decref(json);
    return reconstruction;
}

enum vw_verdict vw_html_judge(const struct vw_report_run *run) {
    const struct vw_reconstruction reconstruction = reconstruction_of(run);
    return run->agreement ? vw_verdict_judge(&reconstruction) : VW_VERDICT_UNKNOWN;
}

json_t *vw_html_verdict(const struct vw_report_run *run) {
    const struct vw_reconstruction reconstruction = reconstruction_of(run);
    return run->agreement ? vw_verdict_to_json(&reconstruction, run->agreement) : json_null();
}

json_t *vw_html_growth(const struct vw_report_run *run) {
    if (!run->lasting.step_count) return json_null();
    json_t *growth = json_object(), *steps = json_array(), *sizes = json_array();
    uint64_t stride = run->lasting.step_count / GROWTH_SHOWN + 1;
    for (uint64_t i = 0; i < run->lasting.step_count; i++) {
        if (i % stride != 0 && i + 1 != run->lasting.step_count) continue;
        vw_json_append(&steps, json_integer((json_int_t)run->lasting.steps[i].step));
        vw_json_append(&sizes, vw_json_real(run->lasting.steps[i].size_psnr));
    }
    vw_json_set(&growth, "step", steps);
    vw_json_set(&growth, "size", sizes);
    return growth;
}

// ---- Retrainings ---------------------------------------------------------------------------------------------------

// Returns the scores of a method by image, NaN if there is none; NULL if memory is short. `found`: some are known.
static double *values_of(const struct vw_report_run *run, const char *method, bool *found) {
    double *values = vw_allocate(run->image_count, sizeof *values);
    for (uint32_t i = 0; values && i < run->image_count; i++) values[i] = NAN;
    for (uint32_t i = 0; values && i < run->score_count; i++) {
        const struct vw_ledger_score *score = &run->scores[i];
        const struct vw_ledger_image *image = vw_ledger_find_image(run->images, run->image_count, score->image_id);
        if (!image || strcmp(score->method, method) != 0 || !score->visits) continue;
        values[image - run->images] = score->value;
        *found = true;
    }
    return values;
}

static json_t *means_of(const struct vw_report_run *run, const double *values) {
    json_t *means = json_array();
    for (uint32_t r = 0; r < run->retraining_count; r++) {
        double sum = 0;
        for (uint32_t i = 0; i < run->retrainings[r].image_count; i++) {
            const struct vw_ledger_image *image =
                vw_ledger_find_image(run->images, run->image_count, run->retrainings[r].image_ids[i]);
            sum += image ? values[image - run->images] : NAN;
        }
        vw_json_append(&means, vw_json_real(sum / run->retrainings[r].image_count));
    }
    return means;
}

json_t *vw_html_retrainings(const struct vw_report_run *run) {
    static const char *const methods[] = {"dv_psnr", "lasting_psnr", "worth_psnr"};
    if (!run->retraining_count) return json_null();
    json_t *object = json_object(), *measured = json_array(), *photos = json_array(), *means = json_object();
    for (uint32_t r = 0; r < run->retraining_count; r++) {
        vw_json_append(&measured, vw_json_real(run->retrainings[r].val_psnr));
        vw_json_append(&photos, json_integer(run->retrainings[r].image_count));
    }
    for (size_t m = 0; m < VW_ARRAY_COUNT(methods); m++) {
        bool found = false;
        double *values = values_of(run, methods[m], &found);
        if (found || !values) vw_json_set(&means, methods[m], values ? means_of(run, values) : NULL);
        free(values);
    }
    vw_json_set(&object, "measured", measured);
    vw_json_set(&object, "photos", photos);
    vw_json_set(&object, "means", means);
    return object;
}

json_t *vw_html_accuracy(const struct vw_worth_summary *worth) {
    if (!worth->claim_count) return json_null();
    json_t *object = json_object(), *methods = json_array(), *rho = json_array(), *low = json_array(),
           *high = json_array();
    for (uint32_t i = 0; i < worth->claim_count; i++) {
        vw_json_append(&methods, vw_json_string(worth->claims[i].method));
        vw_json_append(&rho, vw_json_real(worth->claims[i].accuracy.spearman));
        vw_json_append(&low, vw_json_real(worth->claims[i].accuracy.ci_low));
        vw_json_append(&high, vw_json_real(worth->claims[i].accuracy.ci_high));
    }
    vw_json_set(&object, "method", methods);
    vw_json_set(&object, "spearman", rho);
    vw_json_set(&object, "ci_low", low);
    vw_json_set(&object, "ci_high", high);
    vw_json_set(&object, "retrainings", json_integer(worth->retraining_count));
    vw_json_set(&object, "noise_db", vw_json_real(worth->noise_db));
    vw_json_set(&object, "ceiling", vw_json_real(worth->ceiling));
    return object;
}
