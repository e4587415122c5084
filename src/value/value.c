#include "viewworth/value.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "ledger/find_image.h"
#include "viewworth/memory.h"

struct estimator {
    const char *method, *unit;
    size_t measure_offset; // of the validation measure in struct vw_step_record
    double sign;           // +1 where more is better, -1 where less is
};

static const struct estimator estimators[] = {
    {"dv_psnr", "dB", offsetof(struct vw_step_record, val_psnr), 1},
    {"dv_loss", "mean absolute error", offsetof(struct vw_step_record, val_l1), -1},
    {"dv_psnr_pooled", "dB", offsetof(struct vw_step_record, val_psnr_pooled), 1},
};

// The deltas of one image so far. Mean and squares by Welford's recurrence, which does not cancel.
struct tally {
    double sum, mean, squared_deviations;
    uint32_t visits;
};

static void add_delta(struct tally *tally, double delta) {
    tally->sum += delta;
    tally->visits++;
    double deviation = delta - tally->mean;
    tally->mean += deviation / tally->visits;
    tally->squared_deviations += deviation * (delta - tally->mean);
}

static double standard_error_of_sum(const struct tally *tally) {
    if (tally->visits < 2) return NAN;
    return sqrt(tally->squared_deviations / (tally->visits - 1) * tally->visits);
}

static double measure_of(const struct vw_step_record *record, const struct estimator *estimator) {
    double measure;
    memcpy(&measure, (const char *)record + estimator->measure_offset, sizeof measure);
    return measure;
}

// Deltas are summed in the order of the steps, so that equal ledgers give equal bits.
static enum vw_status tally_deltas(const struct estimator *estimator, const struct vw_step_record *records, uint64_t record_count,
                                   uint32_t burn_in_epochs, const struct vw_ledger_image *images, uint32_t image_count,
                                   struct tally *tallies) {
    double before = NAN;
    for (uint64_t i = 0; i < record_count; i++) {
        const struct vw_step_record *record = &records[i];
        double after = measure_of(record, estimator);
        if (!isfinite(after)) continue;
        if (isfinite(before) && record->epoch >= burn_in_epochs && record->view != VW_RECORD_UNTRAINED) {
            const struct vw_ledger_image *image = vw_ledger_find_image(images, image_count, record->view);
            if (!image)
                return vw_fail(VW_ERROR_INPUT, "step %" PRIu64 ": trained on image %u, which the image table lacks; verify the ledger",
                               record->step, record->view);
            add_delta(&tallies[image - images], estimator->sign * (after - before));
        }
        before = after;
    }
    return VW_OK;
}

// Appends a score per train image; nothing when no image was visited after burn-in.
static void append_scores(const struct estimator *estimator, const struct tally *tallies, const struct vw_ledger_image *images,
                          uint32_t image_count, struct vw_ledger_score *scores, uint32_t *score_count) {
    bool visited = false;
    for (uint32_t i = 0; i < image_count; i++) visited = visited || tallies[i].visits > 0;
    for (uint32_t i = 0; visited && i < image_count; i++) {
        if (strcmp(images[i].split, "train") != 0) continue;
        scores[(*score_count)++] = (struct vw_ledger_score){
            .image_id = images[i].image_id,
            .method = estimator->method,
            .value = tallies[i].sum,
            .unit = estimator->unit,
            .standard_error = standard_error_of_sum(&tallies[i]),
            .visits = tallies[i].visits,
        };
    }
}

enum vw_status vw_value_score(const struct vw_step_record *records, uint64_t record_count, uint32_t burn_in_epochs,
                              const struct vw_ledger_image *images, uint32_t image_count, struct vw_ledger_score **scores,
                              uint32_t *score_count) {
    enum vw_status status = VW_OK;
    uint32_t count = 0;
    struct tally *tallies = vw_allocate(image_count, sizeof *tallies);
    struct vw_ledger_score *made = vw_allocate((size_t)image_count * VW_ARRAY_COUNT(estimators), sizeof *made);
    if (!tallies || !made) status = VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(estimators); i++) {
        memset(tallies, 0, image_count * sizeof *tallies);
        status = tally_deltas(&estimators[i], records, record_count, burn_in_epochs, images, image_count, tallies);
        if (!status) append_scores(&estimators[i], tallies, images, image_count, made, &count);
    }
    free(tallies);
    if (status) {
        free(made);
        return status;
    }
    *scores = made;
    *score_count = count;
    return VW_OK;
}
