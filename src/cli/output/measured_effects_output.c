#include "cli/output/measured_effects_output.h"
#include "cli/output/print.h"

#include <inttypes.h>
#include <string.h>

#include "base/json.h"

void vw_measured_effects_print(const struct vw_measured_effects *measured) {
    if (!measured->count) return;
    const struct vw_measured_training *all = &measured->trainings[0];
    vw_print(
        "\nmeasured over %u steps by paired timing: with all effects called for, a step takes %.3g ms, and PSNR is "
        "%.2f dB\n",
        measured->steps, all->ms_per_step, all->psnr_db);
    vw_print("effect          ms on     ms off    params    bytes       PSNR gained, dB\n");
    for (uint32_t i = 1; i < measured->count; i++) {
        const struct vw_measured_training *off = &measured->trainings[i];
        vw_print("%-15s %-9.4g %-9.4g %-9" PRId64 " %-11" PRId64 " %+.2f\n", off->without, all->ms_per_step,
                 off->ms_per_step, (int64_t)(all->param_count - off->param_count),
                 (int64_t)(all->device_bytes - off->device_bytes), all->psnr_db - off->psnr_db);
    }
    for (uint32_t i = 1; i < measured->count; i++)
        if (!strcmp(measured->trainings[i].without, "masks"))
            vw_print("without masks, masked pixels are validated on, too: the PSNR is of other pixels\n");
}

json_t *vw_measured_effects_to_json(const struct vw_measured_effects *measured) {
    json_t *array = json_array();
    const struct vw_measured_training *all = &measured->trainings[0];
    for (uint32_t i = 1; i < measured->count; i++) {
        const struct vw_measured_training *off = &measured->trainings[i];
        vw_json_append(&array, json_pack("{s:s, s:f, s:f, s:I, s:I, s:o}", "effect", off->without, "ms_per_step_on",
                                         all->ms_per_step, "ms_per_step_off", off->ms_per_step, "params",
                                         (json_int_t)(all->param_count - off->param_count), "bytes",
                                         (json_int_t)(all->device_bytes - off->device_bytes), "psnr_gained_db",
                                         vw_json_real(all->psnr_db - off->psnr_db)));
    }
    return array;
}
