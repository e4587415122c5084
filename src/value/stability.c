#include "value/stability.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

enum vw_status vw_stability_watch_begin(const uint32_t *photos, uint32_t photo_count, uint32_t burn_in_epochs,
                                        struct vw_stability_watch *watch) {
    watch->photos = vw_allocate(photo_count, sizeof *watch->photos);
    if (!watch->photos) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < photo_count; i++) watch->photos[i] = photos[i];
    watch->photo_count = photo_count;
    watch->burn_in_epochs = burn_in_epochs;
    watch->last_psnr = NAN;
    return VW_OK;
}

void vw_stability_watch_end(struct vw_stability_watch *watch) {
    free(watch->photos);
    free(watch->sums);
    *watch = (struct vw_stability_watch){0};
}

// Begins an epoch, whose scores start from those of the epoch before.
static enum vw_status begin_epoch(struct vw_stability_watch *watch) {
    size_t photos = watch->photo_count;
    enum vw_status status =
        vw_grow((void **)&watch->sums, &watch->capacity, (watch->epoch_count + 1) * photos, sizeof *watch->sums);
    if (status) return status;
    double *sums = &watch->sums[watch->epoch_count++ * photos];
    for (size_t i = 0; i < photos; i++) sums[i] = watch->epoch_count > 1 ? sums[i - photos] : NAN;
    return VW_OK;
}

static int compare_ids(const void *left, const void *right) {
    uint32_t a = *(const uint32_t *)left, b = *(const uint32_t *)right;
    return a < b ? -1 : a > b;
}

static enum vw_status add_delta(struct vw_stability_watch *watch, const struct vw_step_record *record, double delta) {
    const uint32_t *photo =
        bsearch(&record->view, watch->photos, watch->photo_count, sizeof *watch->photos, compare_ids);
    enum vw_status status = VW_OK;
    if (!photo)
        return vw_fail(VW_ERROR_INPUT,
                       "step %" PRIu64 ": trained on image %u, which is not a train photo; verify the ledger",
                       record->step, record->view);
    while (!status && watch->epoch_count <= record->epoch - watch->burn_in_epochs) status = begin_epoch(watch);
    if (status || !isfinite(delta)) return status;
    double *sum = &watch->sums[(watch->epoch_count - 1) * watch->photo_count + (size_t)(photo - watch->photos)];
    *sum = isnan(*sum) ? delta : *sum + delta;
    return VW_OK;
}

enum vw_status vw_stability_watch_add(struct vw_stability_watch *watch, const struct vw_step_record *record) {
    double delta = record->val_psnr - watch->last_psnr;
    if (isfinite(record->val_psnr)) watch->last_psnr = record->val_psnr;
    watch->last_step = record->step;
    bool counts = record->view != VW_RECORD_UNTRAINED && record->epoch >= watch->burn_in_epochs;
    return counts ? add_delta(watch, record, delta) : VW_OK;
}

// Computes Spearman's correlation of the scores after `epochs` that count with those after half of them; NaN if a photo
// has none.
static enum vw_status correlate_with_half(const struct vw_stability_watch *watch, uint32_t epochs,
                                          double *correlation) {
    size_t photos = watch->photo_count;
    const double *now = &watch->sums[(epochs - 1) * photos], *before = &watch->sums[(epochs / 2 - 1) * photos];
    bool known = true;
    for (size_t i = 0; i < photos; i++) known &= !isnan(now[i]) && !isnan(before[i]);
    *correlation = NAN;
    return known ? vw_spearman(now, before, watch->photo_count, correlation) : VW_OK;
}

enum vw_status vw_stability_watch_measure(const struct vw_stability_watch *watch, struct vw_stability *stability) {
    uint32_t burn_in = watch->burn_in_epochs;
    uint64_t complete = watch->photo_count ? watch->last_step / watch->photo_count : 0;
    *stability =
        (struct vw_stability){.epochs = complete > burn_in ? (uint32_t)complete - burn_in : 0, .correlation = NAN};
    stability->earlier_epochs = stability->epochs / 2;
    if (stability->epochs < VW_STABILITY_EPOCHS_MIN) return VW_OK;
    enum vw_status status = VW_OK;
    for (uint32_t back = 0; !status && back < VW_STABILITY_ENDS; back++) {
        double correlation;
        status = correlate_with_half(watch, stability->epochs - back, &correlation);
        if (back == 0 || isnan(correlation) || correlation < stability->correlation)
            stability->correlation = correlation;
    }
    return status;
}

bool vw_stability_reaches(const struct vw_stability *stability, double wanted) {
    return stability->correlation >= wanted;
}

// ---- Statistics of steps ----

enum { NONFINITE_BY_CHANCE = 20 };
const double vw_step_statistics_nonfinite_max = 0.1;

struct vw_step_statistics vw_step_statistics_begin(void) {
    return (struct vw_step_statistics){.first_val_psnr_db = NAN, .last_val_psnr_db = NAN};
}

void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record) {
    if (record->step == 0) statistics->first_val_psnr_db = record->val_psnr;
    statistics->steps = record->step;
    statistics->nonfinite += record->nonfinite;
    statistics->finite += record->step > 0 && !record->nonfinite;
    statistics->floored += record->floored_views > 0;
    statistics->clamped += record->clamped_count;
    if (isfinite(record->val_psnr)) statistics->last_val_psnr_db = record->val_psnr;
}

bool vw_step_statistics_are_void(const struct vw_step_statistics *statistics) {
    return statistics->steps > 0 && !statistics->finite;
}

bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics) {
    return statistics->nonfinite > NONFINITE_BY_CHANCE &&
           (double)statistics->nonfinite > vw_step_statistics_nonfinite_max * (double)statistics->steps;
}
