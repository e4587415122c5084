#include "run/profile.h"
#include "gpu/compute.h"
#include "train/trainer.h"

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

// Makes the profile. A timer may miss dispatches, so each pass counts the mean of a dispatch times the dispatches of a
// step.
enum vw_status vw_profile_make(const struct vw_trainer *trainer, struct vw_gpu *gpu, struct vw_profile *profile) {
    *profile = (struct vw_profile){0};
    struct vw_pass_costs costs;
    vw_trainer_pass_costs(trainer, &costs);
    profile->row_count = costs.count;
    for (uint32_t i = 0; i < profile->row_count; i++) {
        const struct vw_pass_cost *cost = &costs.list[i];
        double ms = mean_ms(gpu, cost) * cost->dispatches;
        profile->rows[i] = (struct vw_profile_row){.name = cost->name,
                                                   .role = cost->role,
                                                   .ms = ms,
                                                   .bytes = cost->bytes,
                                                   .multiply_adds = cost->multiply_adds,
                                                   .bytes_per_s = ms > 0 ? 1e3 * cost->bytes / ms : 0,
                                                   .multiply_adds_per_s = ms > 0 ? 1e3 * cost->multiply_adds / ms : 0};
        profile->ms += ms;
    }
    for (uint32_t i = 0; i < profile->row_count; i++)
        profile->rows[i].share = profile->ms > 0 ? profile->rows[i].ms / profile->ms : 0;
    return vw_gpu_measure_peaks(gpu, &profile->peaks);
}
