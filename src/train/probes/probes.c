#include "train/probes/probes.h"

// ---- Creation -------------------------------------------------------------------------------------------------------

enum vw_status vw_probes_check(const struct vw_config *config, bool validates) {
    const char *option = config->noise_floor ? "noise-floor" : config->same_state ? "same-state" : NULL;
    if (!option || validates) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s: needs validation after every step; use viewworth value", option);
}

// Draws beyond these are free for the probes of a state.
enum { STEP_DRAWS = 1 + PROBE_RESAMPLES };

uint32_t vw_probes_draws_per_step(const struct vw_config *config) { return config->noise_floor ? STEP_DRAWS : 1; }

uint32_t vw_probes_per_step(const struct vw_config *config) { return config->noise_floor ? PROBES_PER_STEP : 0; }

uint32_t vw_probes_measurements_per_step(const struct vw_config *config) { return 1 + vw_probes_per_step(config); }

enum vw_status vw_probes_create(const struct vw_probe_context *context, struct vw_probes *probes) {
    const struct vw_config *config = context->config;
    enum vw_status status = VW_OK;
    probes->context = *context;
    probes->context.snapshot = &probes->snapshot;
    if (config->noise_floor || config->same_state) status = vw_snapshot_create(context->step, &probes->snapshot);
    if (!status && config->noise_floor) status = vw_noise_probe_create(&probes->context, &probes->noise);
    if (!status && config->same_state)
        status = vw_same_state_create(&probes->context, vw_probes_per_step(config), &probes->same_state);
    return status;
}

void vw_probes_destroy(struct vw_probes *probes) {
    vw_noise_probe_destroy(&probes->noise);
    vw_same_state_destroy(&probes->same_state);
    vw_snapshot_destroy(&probes->snapshot);
}

// ---- Probes of a step -----------------------------------------------------------------------------------------------

static uint32_t noise_row(const struct vw_probe_context *context) {
    return vw_validation_rows_per_measurement(context->validation);
}

uint32_t vw_probes_draws_of_step(const struct vw_probes *probes, uint64_t step) {
    return vw_noise_probe_due(&probes->context, step) ? STEP_DRAWS : 1;
}

void vw_probes_record_before(const struct vw_probes *probes, struct vw_submission *batch, uint64_t step,
                             uint32_t first_pixel, uint32_t scalar_row) {
    const struct vw_probe_context *context = &probes->context;
    if (vw_noise_probe_due(context, step))
        vw_noise_probe_record(probes->noise, context, batch, step, first_pixel, scalar_row + noise_row(context));
}

void vw_probes_read(const struct vw_probes *probes, const vw_float4 *rows, struct vw_probe *values,
                    struct vw_step_record *record) {
    const struct vw_probe_context *context = &probes->context;
    bool noise = vw_noise_probe_due(context, record->step);
    record->probes = values;
    record->probe_count = noise ? PROBES_PER_STEP : 0;
    if (noise) vw_noise_probe_read(context, rows + noise_row(context), record->step, values);
}

// ---- Probes of a state ----------------------------------------------------------------------------------------------

bool vw_probes_state_due(const struct vw_probes *probes, uint64_t step) {
    return step > probes->same_state.probed_step && vw_same_state_due(&probes->context, step);
}

enum vw_status vw_probes_take_state(struct vw_probes *probes, struct vw_submission *batch,
                                    struct vw_step_record *record) {
    return vw_same_state_take(&probes->same_state, &probes->context, batch, STEP_DRAWS, record);
}

void vw_probes_resume_after(struct vw_probes *probes, uint64_t step) { probes->same_state.probed_step = step; }
