#include "train/probes/probes.h"

// ---- Creation -------------------------------------------------------------------------------------------------------

enum vw_status probes_check(const struct vw_config *config, bool validates) {
    const char *option = config->noise_floor ? "noise-floor" : config->same_state ? "same-state" : NULL;
    if (!option || validates) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s: needs validation after every step; use viewworth value", option);
}

// Draws beyond these are free for the probes of a state.
enum { STEP_DRAWS = 1 + PROBE_RESAMPLES };

uint32_t probes_draws_per_step(const struct vw_config *config) { return config->noise_floor ? STEP_DRAWS : 1; }

uint32_t probes_per_step(const struct vw_config *config) { return config->noise_floor ? PROBES_PER_STEP : 0; }

uint32_t probes_measurements_per_step(const struct vw_config *config) { return 1 + probes_per_step(config); }

enum vw_status probes_create(const struct probe_context *context, struct probes *probes) {
    const struct vw_config *config = context->config;
    enum vw_status status = VW_OK;
    probes->context = *context;
    probes->context.snapshot = &probes->snapshot;
    if (config->noise_floor || config->same_state) status = snapshot_create(context->step, &probes->snapshot);
    if (status == VW_OK && config->noise_floor) status = noise_probe_create(&probes->context, &probes->noise);
    if (status == VW_OK && config->same_state)
        status = same_state_create(&probes->context, probes_per_step(config), &probes->same_state);
    return status;
}

void probes_destroy(struct probes *probes) {
    noise_probe_destroy(&probes->noise);
    same_state_destroy(&probes->same_state);
    snapshot_destroy(&probes->snapshot);
}

// ---- Probes of a step -----------------------------------------------------------------------------------------------

static uint32_t noise_row(const struct probe_context *context) {
    return validation_rows_per_measurement(context->validation);
}

uint32_t probes_draws_of_step(const struct probes *probes, uint64_t step) {
    return noise_probe_due(&probes->context, step) ? STEP_DRAWS : 1;
}

void probes_record_before(const struct probes *probes, struct vw_batch *batch, uint64_t step, uint32_t first_pixel,
                          uint32_t scalar_row) {
    const struct probe_context *context = &probes->context;
    if (noise_probe_due(context, step))
        noise_probe_record(probes->noise, context, batch, step, first_pixel, scalar_row + noise_row(context));
}

void probes_read(const struct probes *probes, const vw_float4 *rows, struct vw_probe *values,
                 struct vw_step_record *record) {
    const struct probe_context *context = &probes->context;
    bool noise = noise_probe_due(context, record->step);
    record->probes = values;
    record->probe_count = noise ? PROBES_PER_STEP : 0;
    if (noise) noise_probe_read(context, rows + noise_row(context), record->step, values);
}

// ---- Probes of a state ----------------------------------------------------------------------------------------------

bool probes_state_due(const struct probes *probes, uint64_t step) {
    return step > probes->same_state.probed_step && same_state_due(&probes->context, step);
}

enum vw_status probes_take_state(struct probes *probes, struct vw_batch *batch, struct vw_step_record *record) {
    return same_state_take(&probes->same_state, &probes->context, batch, STEP_DRAWS, record);
}

void probes_resume_after(struct probes *probes, uint64_t step) { probes->same_state.probed_step = step; }
