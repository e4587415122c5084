#include "value/measure.h"

#include <math.h>
#include <string.h>

const struct vw_measure vw_measure_psnr = {offsetof(struct vw_step_record, val_psnr),
                                           offsetof(struct vw_probe, val_psnr)};
const struct vw_measure vw_measure_l1 = {offsetof(struct vw_step_record, val_l1), offsetof(struct vw_probe, val_l1)};

static double read_real(const void *object, size_t offset) {
    double value;
    memcpy(&value, (const char *)object + offset, sizeof value);
    return value;
}

double vw_measure_of_record(const struct vw_measure *measure, const struct vw_step_record *record) {
    return read_real(record, measure->in_record);
}

double vw_measure_of_probe(const struct vw_measure *measure, const struct vw_probe *probe) {
    return read_real(probe, measure->in_probe);
}

void vw_spread_add(struct vw_spread *spread, double value) {
    spread->count++;
    double deviation = value - spread->mean;
    spread->mean += deviation / (double)spread->count;
    spread->squared_deviations += deviation * (value - spread->mean);
}

double vw_spread_variance(const struct vw_spread *spread) {
    return spread->count < 2 ? NAN : spread->squared_deviations / (double)(spread->count - 1);
}

struct vw_step_probes vw_step_probes_take(const struct vw_value_input *input, uint64_t step, uint64_t *taken) {
    while (*taken < input->probe_count && input->probes[*taken].step < step)
        ++*taken; // skip probes of a step without a record
    uint64_t first = *taken;
    while (*taken < input->probe_count && input->probes[*taken].step == step) ++*taken;
    return (struct vw_step_probes){*taken > first ? &input->probes[first] : NULL, *taken - first};
}

double vw_step_sampling_variance(const struct vw_measure *measure, const struct vw_step_record *record,
                                 struct vw_step_probes probes) {
    struct vw_spread spread = {0};
    double own = vw_measure_of_record(measure, record);
    if (isfinite(own)) vw_spread_add(&spread, own);
    for (uint64_t i = 0; i < probes.count; i++) {
        double redrawn = vw_measure_of_probe(measure, &probes.probes[i]);
        if (probes.probes[i].kind == VW_PROBE_RESAMPLED && isfinite(redrawn)) vw_spread_add(&spread, redrawn);
    }
    return vw_spread_variance(&spread);
}

void vw_mean_variance_add(struct vw_mean_variance *mean, double variance) {
    if (isnan(variance)) return;
    mean->sum += variance;
    mean->count++;
}

double vw_mean_variance_result(const struct vw_mean_variance *mean) {
    return mean->count ? mean->sum / (double)mean->count : NAN;
}
