#include "train/probes/same_state.h"

#include <stdlib.h>
#include <string.h>

#include "train/pixels.h"
#include "train/trainer_private.h"
#include "base/clock.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "base/memory.h"

static uint32_t probe_count(const struct vw_trainer *trainer) { return trainer->train_count * SAME_STATE_DRAWS; }

enum vw_status same_state_create(const struct vw_trainer *trainer, uint32_t others, struct same_state_probes *probes) {
    probes->probes = vw_allocate((size_t)others + probe_count(trainer), sizeof *probes->probes);
    return probes->probes ? VW_OK : VW_ERROR_MEMORY;
}

void same_state_destroy(struct same_state_probes *probes) { free(probes->probes); }

// How many of the middles (2 i + 1) counted / (2 states), i = 0, 1, ..., lie before the beginning of epoch `place` of
// those that are counted.
static uint64_t middles_before(uint64_t states, uint64_t counted, uint64_t place) {
    return (2 * states * place + counted - 1) / (2 * counted);
}

bool same_state_due(const struct vw_trainer *trainer, uint64_t step) {
    const struct vw_config *config = &trainer->config;
    uint32_t epoch = trainer_epoch_of_step(trainer, step);
    if (!config->same_state || step == 0 || step % trainer->train_count != 0 || epoch < config->burn_in_epochs)
        return false;
    uint64_t counted = config->epochs - config->burn_in_epochs, place = epoch - config->burn_in_epochs;
    return middles_before(config->same_state, counted, place + 1) > middles_before(config->same_state, counted, place);
}

// The pixels of probe `index` are drawn as those of the next step would be, by a draw that nothing else takes.
static void draw_pixels(struct vw_trainer *trainer, uint64_t step, uint32_t index, struct vw_pixel *pixels) {
    uint32_t view = trainer->train_views[index / SAME_STATE_DRAWS];
    pixels_draw(trainer->scene, view, vw_config_seed_of(&trainer->config, VW_VARY_PIXELS), step,
                TRAINER_STEP_DRAWS + index, trainer->config.rays, pixels);
    if (!trainer->masks) pixels_unmask(trainer->scene, pixels, trainer->config.rays);
}

// The probes from `first` on, as many as a batch of steps has, so that a submission takes no longer than one of the
// run.
static enum vw_status take_some(struct vw_trainer *trainer, struct vw_batch *batch, uint64_t step, uint32_t first,
                                uint32_t count) {
    uint32_t stride = trainer_rows_per_measurement(trainer), rays = trainer->config.rays;
    vw_batch_begin(batch);
    if (first == 0) snapshot_record_save(&trainer->snapshot, batch);
    for (uint32_t i = 0; i < count; i++) {
        draw_pixels(trainer, step, first + i, (struct vw_pixel *)vw_buffer_map(trainer->pixels) + (size_t)i * rays);
        step_record(&trainer->step, batch, step, i * rays, i * stride);
        trainer_record_validation(trainer, batch, i * stride);
        snapshot_record_restore(&trainer->snapshot, batch);
    }
    enum vw_status status = vw_batch_submit(batch);
    return status == VW_OK ? vw_batch_wait(batch) : status;
}

static void read_some(struct vw_trainer *trainer, const struct vw_step_record *record, uint32_t first, uint32_t count) {
    const vw_float4 *rows = vw_buffer_map(trainer->scalars);
    for (uint32_t i = 0; i < count; i++, rows += trainer_rows_per_measurement(trainer)) {
        struct vw_probe *probe = &trainer->same_state.probes[record->probe_count + first + i];
        *probe = (struct vw_probe){.step = record->step,
                                   .index = record->probe_count + first + i,
                                   .kind = VW_PROBE_SAME_STATE,
                                   .view = trainer->train_views[(first + i) / SAME_STATE_DRAWS]};
        trainer_read_probe(trainer, rows, true, probe);
    }
}

enum vw_status same_state_take(struct vw_trainer *trainer, struct vw_batch *batch, struct vw_step_record *record) {
    struct vw_probe *probes = trainer->same_state.probes;
    double started_s = vw_now_s();
    enum vw_status status = VW_OK;
    uint32_t total = probe_count(trainer);
    for (uint32_t first = 0, count = 0; first < total && status == VW_OK; first += count) {
        count = total - first < trainer->steps_per_batch ? total - first : trainer->steps_per_batch;
        status = take_some(trainer, batch, record->step + 1, first, count);
        if (status == VW_OK) read_some(trainer, record, first, count);
    }
    if (status != VW_OK) return status;
    if (record->probe_count) memcpy(probes, record->probes, record->probe_count * sizeof *probes);
    record->probes = probes;
    record->probe_count += total;
    trainer->same_state.probed_step = record->step;
    trainer->stats.same_state_steps += total;
    trainer->stats.same_state_s += vw_now_s() - started_s;
    return VW_OK;
}
