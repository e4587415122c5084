#include "value/measure.h"

#include <math.h>
#include <string.h>

const struct vw_measure vw_measure_psnr = {offsetof(struct vw_step_record, val_psnr)};
const struct vw_measure vw_measure_l1 = {offsetof(struct vw_step_record, val_l1)};

double vw_measure_of_record(const struct vw_measure *measure, const struct vw_step_record *record) {
    double value;
    memcpy(&value, (const char *)record + measure->in_record, sizeof value);
    return value;
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
