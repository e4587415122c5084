#include "value/repair.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"

static const uint32_t all_horizons[] = {1, 2, 3, 5, 8, 12, 20, 30, 50, 80, 120, 200, 300, 500, 800, 1200};
_Static_assert(VW_ARRAY_COUNT(all_horizons) == VW_REPAIR_HORIZONS_MAX, "a horizon for each place");

static void list_horizons(const struct vw_value_input *input, struct vw_repair_curves *curves) {
    uint32_t photos = 0;
    for (uint32_t i = 0; i < input->image_count; i++) photos += strcmp(input->images[i].split, "train") == 0;
    for (uint32_t i = 0; i < VW_REPAIR_HORIZONS_MAX && all_horizons[i] <= photos; i++)
        curves->horizons[curves->horizon_count++] = all_horizons[i];
}

// ---- Photos ---------------------------------------------------------------------------------------------------------

static double gain(const struct vw_value_input *input, uint64_t step, uint32_t horizon) {
    uint64_t after = step + horizon - 1;
    return step > 0 && after < input->record_count ? input->records[after].val_psnr - input->records[step - 1].val_psnr
                                                   : NAN;
}

static double mean_gain(const struct vw_value_input *input, uint64_t first, uint64_t end, uint32_t horizon) {
    double sum = 0;
    uint64_t count = 0;
    for (uint64_t step = first; step < end; step++) {
        double one = gain(input, step, horizon);
        if (!isfinite(one)) continue;
        sum += one;
        count++;
    }
    return count ? sum / (double)count : NAN;
}

// Adds a visit. Until all are added, `stderr_db` is the sum of squared differences from the mean (Welford).
static void add_visit(double excess, double *mean, double *squares, uint32_t *visits) {
    if (!isfinite(excess)) return;
    double before = ++*visits == 1 ? 0 : *mean, difference = excess - before;
    double now = before + difference / *visits;
    *squares = (*visits == 1 ? 0 : *squares) + difference * (excess - now);
    *mean = now;
}

static struct vw_repair_curve *curve_of(const struct vw_value_input *input, const struct vw_repair_curves *curves,
                                        uint64_t step) {
    const struct vw_ledger_image *image =
        vw_ledger_find_image(input->images, input->image_count, input->records[step].view);
    return image ? &curves->photos[image - input->images] : NULL;
}

// Adds the steps of one epoch, from `first` on.
static void add_epoch(const struct vw_value_input *input, uint64_t first, uint64_t end,
                      const struct vw_repair_curves *curves) {
    for (uint32_t k = 0; k < curves->horizon_count; k++) {
        double mean = mean_gain(input, first, end, curves->horizons[k]);
        for (uint64_t step = first; step < end; step++) {
            struct vw_repair_curve *curve = curve_of(input, curves, step);
            if (curve)
                add_visit(gain(input, step, curves->horizons[k]) - mean, &curve->excess_db[k], &curve->stderr_db[k],
                          &curve->visits[k]);
        }
    }
}

static bool counts(const struct vw_value_input *input, uint64_t step) {
    const struct vw_step_record *record = &input->records[step];
    return record->view != VW_RECORD_UNTRAINED && record->epoch >= input->burn_in_epochs;
}

static void finish(struct vw_repair_curve *curve) {
    for (uint32_t k = 0; k < VW_REPAIR_HORIZONS_MAX; k++) {
        uint32_t visits = curve->visits[k];
        if (!visits) curve->excess_db[k] = NAN;
        curve->stderr_db[k] = visits > 1 ? sqrt(curve->stderr_db[k] / (visits - 1) / visits) : NAN;
    }
}

// ---- Kinds ----------------------------------------------------------------------------------------------------------

// Returns NULL beyond the most kinds.
static struct vw_repair_kind *find_or_add(struct vw_repair_curves *curves, const char *ground_truth) {
    uint32_t place = 0;
    while (place < curves->kind_count && strcmp(curves->kinds[place].ground_truth, ground_truth) != 0) place++;
    if (place == VW_REPAIR_KINDS_MAX) return NULL;
    if (place == curves->kind_count) curves->kinds[curves->kind_count++].ground_truth = ground_truth;
    return &curves->kinds[place];
}

// Adds a photo to its kind's curve, whose entries count photos until they are averaged.
static void add_photo(const struct vw_repair_curve *photo, struct vw_repair_kind *kind,
                      uint32_t counts_of_kind[VW_REPAIR_HORIZONS_MAX]) {
    kind->photo_count += photo->visits[0] > 0;
    for (uint32_t k = 0; k < VW_REPAIR_HORIZONS_MAX; k++) {
        if (!photo->visits[k]) continue;
        kind->curve.excess_db[k] += photo->excess_db[k];
        kind->curve.stderr_db[k] += photo->stderr_db[k] * photo->stderr_db[k];
        kind->curve.visits[k] += photo->visits[k];
        counts_of_kind[k]++;
    }
}

static enum vw_status make_kinds(const struct vw_value_input *input, struct vw_repair_curves *curves) {
    uint32_t photo_counts[VW_REPAIR_KINDS_MAX][VW_REPAIR_HORIZONS_MAX] = {{0}};
    curves->kinds = vw_allocate(VW_REPAIR_KINDS_MAX, sizeof *curves->kinds);
    if (!curves->kinds) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const struct vw_ledger_image *image = &input->images[i];
        if (!image->ground_truth || strcmp(image->split, "train") != 0) continue;
        struct vw_repair_kind *kind = find_or_add(curves, image->ground_truth);
        if (kind) add_photo(&curves->photos[i], kind, photo_counts[kind - curves->kinds]);
    }
    for (uint32_t i = 0; i < curves->kind_count; i++)
        for (uint32_t k = 0; k < VW_REPAIR_HORIZONS_MAX; k++) {
            struct vw_repair_curve *curve = &curves->kinds[i].curve;
            uint32_t photos = photo_counts[i][k];
            curve->excess_db[k] = photos ? curve->excess_db[k] / photos : NAN;
            curve->stderr_db[k] = photos ? sqrt(curve->stderr_db[k]) / photos : NAN;
        }
    return VW_OK;
}

// ---- All of it ------------------------------------------------------------------------------------------------------

enum vw_status vw_repair_curves_make(const struct vw_value_input *input, struct vw_repair_curves *curves) {
    *curves = (struct vw_repair_curves){.photos = vw_allocate(input->image_count, sizeof *curves->photos)};
    if (!curves->photos) return VW_ERROR_MEMORY;
    list_horizons(input, curves);
    bool visited = false;
    for (uint64_t first = 0, end; first < input->record_count; first = end) {
        end = first + 1;
        if (!counts(input, first)) continue;
        while (end < input->record_count && counts(input, end) &&
               input->records[end].epoch == input->records[first].epoch)
            end++;
        add_epoch(input, first, end, curves);
    }
    for (uint32_t i = 0; i < input->image_count; i++) {
        visited |= curves->photos[i].visits[0] > 0;
        finish(&curves->photos[i]);
    }
    if (!visited) curves->horizon_count = 0;
    return make_kinds(input, curves);
}

void vw_repair_curves_free(struct vw_repair_curves *curves) {
    free(curves->photos);
    free(curves->kinds);
    *curves = (struct vw_repair_curves){0};
}
