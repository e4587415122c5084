#include "cli/output/estimate_output.h"
#include "cli/output/print.h"

#include <inttypes.h>

void vw_estimate_print(const struct vw_estimate *estimate) {
    vw_print("memory   %.1f MiB on the host for photos, masks and points\n", (double)estimate->host_bytes / 0x1p20);
    if (*estimate->missing) {
        vw_print("estimate none: %s\n", estimate->missing);
        return;
    }
    vw_print("         %.1f MiB on the device for %" PRIu64 " params with the default field\n",
             (double)estimate->device_bytes / 0x1p20, estimate->param_count);
    vw_print("time     about %.3g s for the %" PRIu64
             " steps of value with default options (%.3g ms per step, from %" PRIu64 " steps on %s)\n",
             estimate->seconds_per_step * (double)estimate->steps, estimate->steps, 1e3 * estimate->seconds_per_step,
             estimate->measured_steps, estimate->device);
}

json_t *vw_estimate_to_json(const struct vw_estimate *estimate) {
    if (*estimate->missing)
        return json_pack("{s:I, s:s}", "host_bytes", (json_int_t)estimate->host_bytes, "missing", estimate->missing);
    return json_pack("{s:I, s:I, s:I, s:I, s:f, s:f, s:I, s:s}", "host_bytes", (json_int_t)estimate->host_bytes,
                     "device_bytes", (json_int_t)estimate->device_bytes, "params", (json_int_t)estimate->param_count,
                     "steps", (json_int_t)estimate->steps, "seconds",
                     estimate->seconds_per_step * (double)estimate->steps, "seconds_per_step",
                     estimate->seconds_per_step, "measured_steps", (json_int_t)estimate->measured_steps, "device",
                     estimate->device);
}
