#include "value/quality.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "value/series.h"
#include "value/uncertainty.h"

enum { DRAWS = 400 };
static const uint64_t DRAW_SEED = 0x7175616c697479; // no training has it

// The losses of one photo in one epoch.
struct cell {
    double gain, loss; // sums of the deltas and of the training losses
    uint32_t gains, losses;
};

struct work {
    const struct vw_value_input *input;
    struct vw_series series;
    uint32_t epochs, late_epochs; // after burn-in; of these the last, whose losses count
    struct cell *cells;           // [image * epochs + epoch]
    struct cell *totals;          // by image; losses of late epochs only
    uint32_t block;               // epochs that are drawn together
    uint32_t *photos;             // train images that have both
    uint32_t photo_count;
    uint32_t *drawn;           // a draw's epochs
    double *sides;             // [photo], [photo]: what a rank is of
    double *ranks;             // the same
    double *values;            // one per photo
    struct vw_spread *spreads; // spread of each photo's value over the draws
};

static void add_cell(struct cell *sum, const struct cell *cell, bool late) {
    sum->gain += cell->gain;
    sum->gains += cell->gains;
    if (!late) return;
    sum->loss += cell->loss;
    sum->losses += cell->losses;
}

static struct cell sum_epochs(const struct work *work, uint32_t image, const uint32_t *epochs) {
    struct cell sum = {0};
    for (uint32_t i = 0; i < work->epochs; i++)
        add_cell(&sum, &work->cells[(size_t)image * work->epochs + epochs[i]],
                 epochs[i] >= work->epochs - work->late_epochs);
    return sum;
}

static void fill_cells(struct work *work) {
    for (uint64_t i = 0; i < work->series.count; i++) {
        const struct vw_visit *visit = &work->series.visits[i];
        struct cell *cell = &work->cells[(size_t)visit->image * work->epochs + visit->epoch];
        if (isfinite(visit->delta)) {
            cell->gain += visit->delta;
            cell->gains++;
        }
        if (isfinite(visit->train_loss)) {
            cell->loss += visit->train_loss;
            cell->losses++;
        }
    }
    for (uint32_t e = 0; e < work->epochs; e++) work->drawn[e] = e;
    for (uint32_t i = 0; i < work->input->image_count; i++) {
        work->totals[i] = sum_epochs(work, i, work->drawn);
        bool known = work->totals[i].gains && work->totals[i].losses;
        if (known && strcmp(work->input->images[i].split, "train") == 0) work->photos[work->photo_count++] = i;
    }
}

static enum vw_status allocate(struct work *work) {
    size_t images = work->input->image_count;
    work->cells = vw_allocate(images, work->epochs * sizeof *work->cells);
    work->totals = vw_allocate(images, sizeof *work->totals);
    work->photos = vw_allocate(images, sizeof *work->photos);
    work->drawn = vw_allocate(work->epochs, sizeof *work->drawn);
    work->sides = vw_allocate(images, 2 * sizeof *work->sides);
    work->ranks = vw_allocate(images, 2 * sizeof *work->ranks);
    work->values = vw_allocate(images, sizeof *work->values);
    work->spreads = vw_allocate(images, sizeof *work->spreads);
    bool whole = work->cells && work->totals && work->photos && work->drawn && work->sides && work->ranks &&
                 work->values && work->spreads;
    return whole ? VW_OK : VW_ERROR_MEMORY;
}

static void discard(struct work *work) {
    vw_series_free(&work->series);
    free(work->cells);
    free(work->totals);
    free(work->photos);
    free(work->drawn);
    free(work->sides);
    free(work->ranks);
    free(work->values);
    free(work->spreads);
}

// Computes the value of each photo from the drawn epochs. A photo whose late visits were not drawn keeps its loss of
// all.
static enum vw_status rank_photos(const struct work *work, double *values) {
    uint32_t count = work->photo_count;
    double *gains = work->sides, *fits = work->sides + count;
    for (uint32_t p = 0; p < count; p++) {
        const struct cell sum = sum_epochs(work, work->photos[p], work->drawn), *all = &work->totals[work->photos[p]];
        gains[p] = sum.gain;
        fits[p] = sum.losses ? -sum.loss / sum.losses : -all->loss / all->losses;
    }
    enum vw_status status = vw_ranks(gains, count, work->ranks);
    if (!status) status = vw_ranks(fits, count, work->ranks + count);
    for (uint32_t p = 0; p < count && !status; p++)
        values[p] = count == 1 ? 0.5 : (work->ranks[p] + work->ranks[count + p] - 2) / (2.0 * (count - 1));
    return status;
}

// Draws as many of the epochs first ... end - 1 as there are, in blocks of neighbours; the last is followed by the
// first.
static void draw_blocks(struct work *work, uint32_t draw, uint32_t first, uint32_t end) {
    uint32_t count = end - first, start = 0, words[4];
    for (uint32_t i = 0; i < count; i++) {
        if (i % work->block == 0) {
            vw_random_words(DRAW_SEED, VW_RANDOM_ORDER, draw, first + i, 0, words);
            start = vw_random_below(words[0], count);
        }
        work->drawn[first + i] = first + (start + i % work->block) % count;
    }
}

static enum vw_status spread_draws(struct work *work) {
    uint32_t late = work->epochs - work->late_epochs;
    enum vw_status status = VW_OK;
    for (uint32_t draw = 0; draw < DRAWS && !status; draw++) {
        draw_blocks(work, draw, 0, late);
        draw_blocks(work, draw, late, work->epochs);
        status = rank_photos(work, work->values);
        for (uint32_t p = 0; p < work->photo_count && !status; p++) vw_spread_add(&work->spreads[p], work->values[p]);
    }
    for (uint32_t e = 0; e < work->epochs; e++) work->drawn[e] = e;
    return status ? status : rank_photos(work, work->values);
}

static void append(const struct work *work, struct vw_ledger_score *scores, uint32_t *score_count) {
    struct vw_ledger_score *own = &scores[*score_count];
    uint32_t count = 0;
    double shown = 1 - (double)work->block / work->late_epochs; // blocks of n among m epochs show a share 1 - n / m
    for (uint32_t i = 0, p = 0; i < work->input->image_count; i++) {
        if (strcmp(work->input->images[i].split, "train") != 0) continue;
        struct vw_ledger_score *score = &own[count++];
        *score = (struct vw_ledger_score){.image_id = work->input->images[i].image_id,
                                          .method = "quality",
                                          .unit = "mean rank",
                                          .standard_error = NAN,
                                          .ci_low = NAN,
                                          .ci_high = NAN};
        if (p == work->photo_count || work->photos[p] != i) continue;
        double error = sqrt(vw_spread_variance(&work->spreads[p]) * vw_run_variance / shown);
        score->value = work->values[p++];
        score->visits = work->totals[i].gains;
        if (work->late_epochs < 2) continue; // a single late epoch cannot be resampled
        score->standard_error = error;
        score->ci_low = fmax(score->value - vw_student_quantile(work->epochs - 1) * error, 0);
        score->ci_high = fmin(score->value + vw_student_quantile(work->epochs - 1) * error, 1);
    }
    vw_rank_intervals(own, count, 0);
    *score_count += count;
}

// Appends the training losses that a rank hides, in dB. A mean that is not positive, which some losses allow, has none.
static void append_fits(const struct work *work, struct vw_ledger_score *scores, uint32_t *score_count) {
    for (uint32_t i = 0, p = 0; i < work->input->image_count; i++) {
        if (strcmp(work->input->images[i].split, "train") != 0) continue;
        struct vw_ledger_score *score = &scores[(*score_count)++];
        *score = (struct vw_ledger_score){.image_id = work->input->images[i].image_id,
                                          .method = "train_fit",
                                          .unit = "dB",
                                          .standard_error = NAN,
                                          .ci_low = NAN,
                                          .ci_high = NAN};
        if (p == work->photo_count || work->photos[p] != i) continue;
        const struct cell *total = &work->totals[work->photos[p++]];
        if (!(total->loss > 0)) continue;
        score->value = -10 * log10(total->loss / total->losses);
        score->visits = total->losses;
    }
}

enum vw_status vw_quality_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                 uint32_t *score_count) {
    struct work work = {.input = input};
    enum vw_status status = vw_series_make(input, VW_MEASURE_L1, VW_FORM_STEP, &work.series);
    work.epochs = work.series.epoch_count;
    work.late_epochs = (work.epochs + 2) / 3;
    work.block = (uint32_t)fmax(1, fmin(round(cbrt(work.epochs)), work.late_epochs / 2));
    if (!status) status = allocate(&work);
    if (!status) fill_cells(&work);
    if (!status && work.photo_count) status = spread_draws(&work);
    if (!status && work.photo_count) append(&work, scores, score_count);
    if (!status && work.photo_count) append_fits(&work, scores, score_count);
    discard(&work);
    return status;
}
