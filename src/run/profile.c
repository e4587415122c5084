#include "gpu/compute.h"
#include "train/trainer.h"
#include "run/profile.h"

#include <stdio.h>
#include <string.h>

static bool same_text(const char *a, const char *b) { return a && b ? strcmp(a, b) == 0 : a == b; }

static double mean_ms(const struct vw_gpu *gpu, const struct vw_pass_cost *cost) {
    uint32_t count = 0;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < count; i++)
        if (same_text(timers[i].name, cost->name) && same_text(timers[i].role, cost->role))
            return timers[i].total_ms / (double)timers[i].dispatches;
    return 0.0;
}

// A timer may have missed dispatches: so the mean of a dispatch counts, times the dispatches of a step.
enum vw_status vw_profile_make(const struct vw_trainer *trainer, struct vw_gpu *gpu, struct vw_profile *profile) {
    *profile = (struct vw_profile){0};
    struct vw_pass_cost costs[VW_PASS_COSTS_MAX];
    vw_trainer_pass_costs(trainer, costs, &profile->row_count);
    for (uint32_t i = 0; i < profile->row_count; i++) {
        double ms = mean_ms(gpu, &costs[i]) * costs[i].dispatches;
        profile->rows[i] =
            (struct vw_profile_row){.name = costs[i].name,
                                    .role = costs[i].role,
                                    .ms = ms,
                                    .bytes = costs[i].bytes,
                                    .multiply_adds = costs[i].multiply_adds,
                                    .bytes_per_s = ms > 0 ? 1e3 * costs[i].bytes / ms : 0,
                                    .multiply_adds_per_s = ms > 0 ? 1e3 * costs[i].multiply_adds / ms : 0};
        profile->ms += ms;
    }
    for (uint32_t i = 0; i < profile->row_count; i++)
        profile->rows[i].share = profile->ms > 0 ? profile->rows[i].ms / profile->ms : 0;
    return vw_gpu_measure_peaks(gpu, &profile->peaks);
}

void vw_profile_print(const struct vw_profile *profile) {
    const struct vw_gpu_peaks *peaks = &profile->peaks;
    if (!profile->row_count) return;
    printf("pass                              ms  share       MB    GB/s  of copy  mult-adds  G/s   of peak\n");
    for (uint32_t i = 0; i < profile->row_count; i++) {
        const struct vw_profile_row *row = &profile->rows[i];
        char name[48];
        snprintf(name, sizeof name, "%s%s%s", row->name, row->role ? ", " : "", row->role ? row->role : "");
        printf("%-28s %7.3f  %4.1f%%  %7.2f  %6.2f  %5.0f %%", name, row->ms, 100 * row->share, 1e-6 * row->bytes,
               1e-9 * row->bytes_per_s, 100 * row->bytes_per_s / peaks->copy_bytes_per_s);
        if (row->multiply_adds > 0)
            printf("   %6.2f M  %5.1f     %5.0f %%", 1e-6 * row->multiply_adds, 1e-9 * row->multiply_adds_per_s,
                   100 * row->multiply_adds_per_s / peaks->multiply_adds_per_s);
        putchar('\n');
    }
    printf("%-28s %7.3f         peaks: copy %.2f GB/s, multiply-adds %.1f G/s\n", "a step", profile->ms,
           1e-9 * peaks->copy_bytes_per_s, 1e-9 * peaks->multiply_adds_per_s);
}

static json_t *row_to_json(const struct vw_profile_row *row) {
    return json_pack("{s:s, s:s?, s:f, s:f, s:f, s:f, s:f, s:f}", "pass", row->name, "role", row->role, "ms", row->ms,
                     "share", row->share, "bytes", row->bytes, "bytes_per_s", row->bytes_per_s, "multiply_adds",
                     row->multiply_adds, "multiply_adds_per_s", row->multiply_adds_per_s);
}

json_t *vw_profile_to_json(const struct vw_profile *profile) {
    json_t *passes = json_array();
    for (uint32_t i = 0; passes && i < profile->row_count; i++)
        if (json_array_append_new(passes, row_to_json(&profile->rows[i]))) {
            json_decref(passes);
            passes = NULL;
        }
    return json_pack("{s:o, s:f, s:f, s:f}", "passes", passes, "ms", profile->ms, "copy_bytes_per_s",
                     profile->peaks.copy_bytes_per_s, "multiply_adds_per_s", profile->peaks.multiply_adds_per_s);
}
