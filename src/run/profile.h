// The time of each pass of a run, next to the device's peak throughput.
#ifndef VIEWWORTH_RUN_PROFILE_H
#define VIEWWORTH_RUN_PROFILE_H

#include "gpu/compute.h"
#include "train/trainer.h"
#include "viewworth/gpu.h"
#include "viewworth/train.h"

struct vw_profile_row {
    const char *name, *role;     // name and role of the pass
    double ms, share;            // per step; of all passes' time
    double bytes, multiply_adds; // per step
    double bytes_per_s, multiply_adds_per_s;
};

struct vw_profile {
    struct vw_profile_row rows[VW_PASS_COSTS_MAX];
    uint32_t row_count;
    double ms; // time of all passes, per step
    struct vw_gpu_peaks peaks;
};

// Makes the profile after the steps were taken. Measures the peaks now, on the same device.
enum vw_status vw_profile_make(const struct vw_trainer *trainer, struct vw_gpu *gpu, struct vw_profile *profile);

#endif
