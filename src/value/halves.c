#include "value/halves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"

// ---- Splitting ----

struct draw {
    uint8_t hash[VW_HASH_BYTES];
    uint32_t place;
};

static int compare_draws(const void *left, const void *right) {
    const struct draw *a = left, *b = right;
    int by_hash = memcmp(a->hash, b->hash, sizeof a->hash);
    return by_hash ? by_hash : (a->place > b->place) - (a->place < b->place);
}

static void draw(const char *name, uint64_t seed, uint8_t hash[VW_HASH_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth validation half");
    vw_hasher_add_integer(&hasher, (int64_t)seed);
    vw_hasher_add_text(&hasher, name);
    vw_hasher_end(&hasher, hash);
}

enum vw_status vw_halves_split(const struct vw_ledger_image *images, uint32_t image_count, uint64_t seed,
                               uint8_t *halves, uint32_t sizes[VW_HALVES]) {
    struct draw *draws = vw_allocate(image_count, sizeof *draws);
    uint32_t count = 0;
    if (!draws) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < image_count; i++) {
        halves[i] = VW_HALF_NONE;
        if (strcmp(images[i].split, "val") != 0) continue;
        draw(images[i].name, seed, draws[count].hash);
        draws[count++].place = i;
    }
    if (count) qsort(draws, count, sizeof *draws, compare_draws);
    for (uint32_t i = 0; i < count; i++) halves[draws[i].place] = i % VW_HALVES;
    sizes[VW_HALF_A] = (count + 1) / 2;
    sizes[VW_HALF_B] = count / 2;
    free(draws);
    return VW_OK;
}

// ---- Scoring ----

// Sums over the half's photos after one step.
struct sums {
    double psnr_db, mse, l1, weight; // all times the photo's weight
    uint32_t count;
};

struct reading {
    const struct vw_value_input *input;
    const uint8_t *halves;
    uint8_t half;
    struct sums *of_steps; // owned; by the index of the record
};

// Adds a view's error to its step. Steps count from 0 without a gap, so that a step is the index of its record; others
// have no values.
static void take_view(void *context, uint64_t step, uint32_t image_id, const struct vw_view_error *error) {
    struct reading *reading = context;
    const struct vw_value_input *input = reading->input;
    const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, image_id);
    if (!image || reading->halves[image - input->images] != reading->half || step >= input->record_count) return;
    struct sums *sums = &reading->of_steps[step];
    sums->psnr_db += image->weight * vw_psnr_db(error->mse);
    sums->mse += image->weight * error->mse;
    sums->l1 += image->weight * error->l1;
    sums->weight += image->weight;
    sums->count++;
}

static void measure_half(struct vw_step_record *record, const struct sums *sums, uint32_t view_count) {
    bool known = isfinite(record->val_psnr) && sums->count == view_count && sums->weight > 0;
    record->val_psnr = known ? sums->psnr_db / sums->weight : NAN;
    record->val_psnr_pooled = known ? vw_psnr_db(sums->mse / sums->weight) : NAN;
    record->val_l1 = known ? sums->l1 / sums->weight : NAN;
}

// Averages the backward pass's steps over the half's photos, by their weights. Without a pass by validation photo there
// are none.
static enum vw_status measure_lasting(const struct reading *reading, double half_weight,
                                      struct vw_lasting_pass *of_half) {
    const struct vw_value_input *input = reading->input;
    const struct vw_lasting_pass *pass = &input->lasting;
    *of_half = (struct vw_lasting_pass){0};
    if (!pass->view_count || !(half_weight > 0)) return VW_OK;
    struct vw_lasting_step *steps = vw_allocate(pass->step_count, sizeof *steps);
    if (!steps) return VW_ERROR_MEMORY;
    for (uint64_t i = 0; i < pass->step_count; i++)
        steps[i] = (struct vw_lasting_step){.step = pass->steps[i].step, .loss = NAN};
    for (uint32_t v = 0; v < pass->view_count; v++) {
        const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, pass->views[v]);
        if (!image || reading->halves[image - input->images] != reading->half) continue;
        for (uint64_t i = 0; i < pass->step_count; i++)
            steps[i].psnr += image->weight * pass->view_psnr[i * pass->view_count + v] / half_weight;
    }
    of_half->steps = steps;
    of_half->step_count = pass->step_count;
    return VW_OK;
}

enum vw_status vw_halves_score(struct vw_ledger *ledger, const struct vw_value_input *input, const uint8_t *halves,
                               uint8_t half, struct vw_ledger_score **scores, uint32_t *score_count) {
    struct vw_step_record *records = vw_allocate(input->record_count, sizeof *records);
    struct reading reading = {.input = input,
                              .halves = halves,
                              .half = half,
                              .of_steps = vw_allocate(input->record_count, sizeof *reading.of_steps)};
    uint32_t view_count = 0;
    double weight = 0;
    enum vw_status status = records && reading.of_steps ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        view_count += halves[i] == half;
        weight += halves[i] == half ? input->images[i].weight : 0;
    }
    if (!status) status = vw_ledger_each_view(ledger, take_view, &reading);
    for (uint64_t i = 0; !status && i < input->record_count; i++) {
        records[i] = input->records[i];
        if (records[i].step == i) measure_half(&records[i], &reading.of_steps[i], view_count);
        else records[i].val_psnr = records[i].val_psnr_pooled = records[i].val_l1 = NAN;
    }
    struct vw_value_input of_half = *input;
    of_half.records = records;
    if (!status) status = measure_lasting(&reading, weight, &of_half.lasting);
    else of_half.lasting = (struct vw_lasting_pass){0};
    if (!status) status = vw_value_score(&of_half, scores, score_count);
    vw_lasting_pass_free(&of_half.lasting);
    free(records);
    free(reading.of_steps);
    return status;
}
