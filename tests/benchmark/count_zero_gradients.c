// How many samples of a step have no gradient, by epoch of a training with our defaults: shares that say what could be
// skipped. Reads the device's buffers after every step; prints a Markdown table.
//
//     field          every gradient of rgb and raw density is 0: outside, padding, behind what is opaque
//     2^-k           none of them is larger
//     grid           every contribution to the grid rounds to 0 quanta
//     grid by bound  the same, seen without corner weights: no gradient of the encoding exceeds half a quantum
//     level          of the pairs of a sample and a level, those whose contributions all round to 0
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "support/open_trainer.h"
#include "train/trainer_private.h"
#include "viewworth/scene.h"

enum { FIELD, BELOW_24, BELOW_16, BELOW_12, BELOW_8, GRID, GRID_BOUND, LEVEL, SHARES };

static const char *const headings[SHARES] = {"field", "2^-24", "2^-16",         "2^-12",
                                             "2^-8",  "grid",  "grid by bound", "level"};

struct reading {
    const struct vw_trainer *trainer;
    float *rows, *d_samples;
    uint64_t counts[SHARES], samples;
};

// Of the rows that scatter_grid reads: the gradient of the encoding, then the position.
static const float *row_at(const struct reading *reading, uint32_t row, uint32_t slot) {
    return reading->rows + 4 * (size_t)VW_ROW_PLACE(reading->trainer->model.grid_row_count, row, slot);
}

// The largest weight of a corner: trilinear weights are products over the axes.
static float largest_weight(const float position[3], uint32_t resolution) {
    float weight = 1.0f;
    for (int axis = 0; axis < 3; axis++) {
        float scaled = position[axis] * (float)resolution;
        float low = fminf(floorf(scaled), (float)(resolution - 1)), fraction = scaled - low;
        weight *= fmaxf(fraction, 1.0f - fraction);
    }
    return weight;
}

static void count_grid(struct reading *reading, uint32_t slot) {
    const struct vw_model *model = &reading->trainer->model;
    const struct vw_specialization *s = &model->specialization;
    const float *position = row_at(reading, model->grid_row_count - 1, slot);
    bool all = true, all_by_bound = true;
    for (uint32_t level = 0; level < s->levels; level++) {
        float most = 0.0f;
        for (uint32_t i = level * 2 * s->feature_pairs; i < (level + 1) * 2 * s->feature_pairs; i++)
            most = fmaxf(most, fabsf(row_at(reading, i / 4, slot)[i % 4]));
        float quanta = most / s->gradient_quantum;
        bool none = quanta * largest_weight(position, s->resolution[level]) <= 0.5f;
        reading->counts[LEVEL] += none;
        all &= none;
        all_by_bound &= quanta <= 0.5f;
    }
    reading->counts[GRID] += all;
    reading->counts[GRID_BOUND] += all_by_bound;
}

static void count_field(struct reading *reading, uint32_t slot) {
    static const int exponents[] = {[BELOW_24] = -24, [BELOW_16] = -16, [BELOW_12] = -12, [BELOW_8] = -8};
    const float *gradient = reading->d_samples + 4 * (size_t)slot;
    float most = 0.0f;
    for (int i = 0; i < 4; i++) most = fmaxf(most, fabsf(gradient[i]));
    reading->counts[FIELD] += most == 0.0f;
    for (int share = BELOW_24; share <= BELOW_8; share++)
        reading->counts[share] += most < ldexpf(1.0f, exponents[share]);
}

static enum vw_status read_step(struct reading *reading) {
    const struct vw_trainer *trainer = reading->trainer;
    struct vw_buffer *rows = trainer->field.grid_rows, *d_samples = trainer->step.d_samples;
    enum vw_status status = vw_buffer_read(rows, 0, reading->rows, vw_buffer_size_bytes(rows));
    if (status == VW_OK) status = vw_buffer_read(d_samples, 0, reading->d_samples, vw_buffer_size_bytes(d_samples));
    uint32_t samples = trainer->config.rays * trainer->config.samples;
    for (uint32_t slot = 0; slot < samples && status == VW_OK; slot++) {
        count_field(reading, slot);
        count_grid(reading, slot);
    }
    reading->samples += samples;
    return status;
}

static void print_epoch(struct reading *reading, uint32_t epoch) {
    const struct vw_specialization *s = &reading->trainer->model.specialization;
    printf("| %" PRIu32 " |", epoch);
    for (int share = 0; share < SHARES; share++) {
        uint64_t of = reading->samples * (share == LEVEL ? s->levels : 1);
        printf(" %.3f |", (double)reading->counts[share] / (double)of);
        reading->counts[share] = 0;
    }
    printf("\n");
    reading->samples = 0;
}

static enum vw_status train(struct vw_trainer *trainer, struct reading *reading) {
    const struct vw_step_record *records;
    uint32_t count, epoch = 0;
    enum vw_status status = VW_OK;
    for (uint64_t step = 0, last = vw_trainer_total_steps(trainer); step <= last && status == VW_OK; step++) {
        vw_trainer_stop_after(trainer, step);
        do status = vw_trainer_advance(trainer, &records, &count);
        while (status == VW_OK && vw_trainer_in_flight(trainer));
        if (status == VW_OK && step > 0) status = read_step(reading);
        if (status != VW_OK || step == 0 || step % trainer->schedule.train_count) continue;
        print_epoch(reading, epoch++);
    }
    return status;
}

static enum vw_status count_shares(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_config *config) {
    struct vw_trainer *trainer = NULL;
    struct reading reading = {0};
    enum vw_status status = test_trainer_open(
        (struct vw_trainer_params){.gpu = gpu, .scene = scene, .config = config, .steps_per_batch = 1}, &trainer);
    if (status == VW_OK && trainer->field.effect_buffers[VW_SLOT_OCCUPANCY])
        status = vw_fail(VW_ERROR_USAGE, "samples that occupancy skips are not counted; take another scene");
    if (status == VW_OK) {
        reading.trainer = trainer;
        reading.rows = vw_allocate(vw_buffer_size_bytes(trainer->field.grid_rows), 1);
        reading.d_samples = vw_allocate(vw_buffer_size_bytes(trainer->step.d_samples), 1);
        if (!reading.rows || !reading.d_samples) status = VW_ERROR_MEMORY;
    }
    if (status == VW_OK) status = train(trainer, &reading);
    free(reading.rows);
    free(reading.d_samples);
    vw_trainer_destroy(&trainer);
    return status;
}

int main(int argc, char **argv) {
    struct vw_config config = vw_config_default;
    if (argc < 2 || argc > 4) {
        fputs("usage: count_zero_gradients SCENE [EPOCHS [DOWNSCALE]]\n", stderr);
        return 2;
    }
    if (argc > 2) config.epochs = (uint32_t)atoi(argv[2]);
    struct vw_gpu *gpu = NULL;
    struct vw_scene *scene = NULL;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){0}, &gpu);
    struct vw_scene_params params = {.path = argv[1], .gpu = gpu, .downscale = argc > 3 ? (uint32_t)atoi(argv[3]) : 1};
    if (status == VW_OK) status = vw_scene_open(&params, &scene);
    printf("| epoch |");
    for (int share = 0; share < SHARES; share++) printf(" %s |", headings[share]);
    printf("\n|---|---|---|---|---|---|---|---|---|\n");
    if (status == VW_OK) status = count_shares(gpu, scene, &config);
    vw_scene_close(&scene);
    enum vw_status closed = vw_gpu_close(&gpu);
    if (status == VW_OK) status = closed;
    if (status != VW_OK) fprintf(stderr, "count_zero_gradients: %s\n", vw_error_message());
    return vw_exit_code(status);
}
