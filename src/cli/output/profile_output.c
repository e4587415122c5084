#include "cli/output/profile_output.h"
#include "cli/output/print.h"

#include <stdio.h>

#include "base/json.h"

void vw_profile_print(const struct vw_profile *profile) {
    const struct vw_gpu_peaks *peaks = &profile->peaks;
    if (!profile->row_count) return;
    vw_print("pass                              ms  share       MB    GB/s  of copy  mult-adds  G/s   of peak\n");
    for (uint32_t i = 0; i < profile->row_count; i++) {
        const struct vw_profile_row *row = &profile->rows[i];
        char name[48];
        snprintf(name, sizeof name, "%s%s%s", row->name, row->role ? ", " : "", row->role ? row->role : "");
        vw_print("%-28s %7.3f  %4.1f%%  %7.2f  %6.2f  %5.0f %%", name, row->ms, 100 * row->share, 1e-6 * row->bytes,
                 1e-9 * row->bytes_per_s, 100 * row->bytes_per_s / peaks->copy_bytes_per_s);
        if (row->multiply_adds > 0)
            vw_print("   %6.2f M  %5.1f     %5.0f %%", 1e-6 * row->multiply_adds, 1e-9 * row->multiply_adds_per_s,
                     100 * row->multiply_adds_per_s / peaks->multiply_adds_per_s);
        vw_print("\n");
    }
    vw_print("%-28s %7.3f         peaks: copy %.2f GB/s, multiply-adds %.1f G/s\n", "a step", profile->ms,
             1e-9 * peaks->copy_bytes_per_s, 1e-9 * peaks->multiply_adds_per_s);
}

static json_t *row_to_json(const struct vw_profile_row *row) {
    return json_pack("{s:s, s:s?, s:f, s:f, s:f, s:f, s:f, s:f}", "pass", row->name, "role", row->role, "ms", row->ms,
                     "share", row->share, "bytes", row->bytes, "bytes_per_s", row->bytes_per_s, "multiply_adds",
                     row->multiply_adds, "multiply_adds_per_s", row->multiply_adds_per_s);
}

json_t *vw_profile_to_json(const struct vw_profile *profile) {
    json_t *passes = json_array();
    for (uint32_t i = 0; i < profile->row_count; i++) vw_json_append(&passes, row_to_json(&profile->rows[i]));
    return json_pack("{s:o, s:f, s:f, s:f}", "passes", passes, "ms", profile->ms, "copy_bytes_per_s",
                     profile->peaks.copy_bytes_per_s, "multiply_adds_per_s", profile->peaks.multiply_adds_per_s);
}
