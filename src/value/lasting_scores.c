#include "value/lasting_scores.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"

const double vw_lasting_gate_least = 0.8;

struct sum {
    double psnr, loss;
    uint32_t visits;
};

static struct vw_ledger_score score_of(const struct vw_ledger_image *image, const char *method, double value,
                                       uint32_t visits) {
    return (struct vw_ledger_score){.image_id = image->image_id,
                                    .method = method,
                                    .value = value,
                                    .unit = vw_value_method_find(method)->unit,
                                    .standard_error = NAN,
                                    .visits = visits,
                                    .ci_low = NAN,
                                    .ci_high = NAN};
}

static void append(const struct vw_value_input *input, const char *method, const struct sum *sums, bool loss,
                   struct vw_ledger_score *scores, uint32_t *score_count) {
    for (uint32_t i = 0; i < input->image_count; i++) {
        if (strcmp(input->images[i].split, "train") != 0) continue;
        scores[(*score_count)++] =
            score_of(&input->images[i], method, loss ? sums[i].loss : sums[i].psnr, sums[i].visits);
    }
}

enum vw_status vw_lasting_scores_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                        uint32_t *score_count) {
    if (!input->lasting.step_count || input->lasting.step_count + 1 != input->record_count) return VW_OK;
    struct sum *sums = vw_allocate(input->image_count, sizeof *sums);
    if (!sums) return VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < input->lasting.step_count; i++) {
        const struct vw_ledger_image *image =
            vw_ledger_find_image(input->images, input->image_count, input->records[i + 1].view);
        if (!image) continue;
        struct sum *sum = &sums[image - input->images];
        sum->psnr += input->lasting.steps[i].psnr;
        sum->loss += input->lasting.steps[i].loss;
        sum->visits++;
    }
    append(input, "lasting_psnr", sums, false, scores, score_count);
    if (!isnan(input->lasting.steps[0].loss)) append(input, "lasting_loss", sums, true, scores, score_count);
    free(sums);
    return VW_OK;
}

struct vw_lasting_growth vw_lasting_growth_of(const struct vw_lasting_pass *pass, uint64_t steps_per_epoch) {
    struct vw_lasting_growth growth = {.factor = 1};
    uint64_t averaged = pass->epochs * steps_per_epoch, end = pass->step_count;
    if (averaged < end) end -= averaged;
    double least = INFINITY;
    uint64_t least_step = end;
    for (uint64_t step = end; step > 0; step--) {
        double size = pass->steps[step - 1].size_psnr;
        if (size / least > growth.factor) growth = (struct vw_lasting_growth){size / least, step, least_step};
        if (!(size > 0) || size >= least) continue;
        least = size;
        least_step = step;
    }
    return growth;
}

double vw_lasting_gate(const struct vw_lasting_pass *pass, bool loss) {
    enum { PHOTOS_MOST = 64, PHOTOS_LEAST = 3 };
    double predicted[PHOTOS_MOST], measured[PHOTOS_MOST];
    uint32_t count = 0;
    for (uint32_t i = 0; i < pass->check_count && count < PHOTOS_MOST; i++) {
        const struct vw_gate_check *check = &pass->checks[i];
        predicted[count] = loss ? check->predicted_loss : check->predicted_psnr;
        measured[count] = loss ? check->measured_loss : check->measured_psnr;
        count += isfinite(measured[count]);
    }
    return count < PHOTOS_LEAST ? NAN : vw_pearson(predicted, measured, count);
}
