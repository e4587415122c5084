// The settings of benchmark_step.
#ifndef VIEWWORTH_TESTS_BENCHMARK_STEP_SETUP_H
#define VIEWWORTH_TESTS_BENCHMARK_STEP_SETUP_H

#include "support/synthetic_scene.h"
#include "train/device_choices.h"
#include "viewworth/train.h"

enum { ROUNDS_MAX = 64 };

struct setup {
    struct vw_config config;
    struct synthetic_scene_params scene;
    struct vw_scene_params real; // path NULL: the synthetic scene
    uint32_t steps, rounds;      // steps are spread over the rounds, each with trainers of its own
    uint32_t together;           // trainings that share their submissions; times are per step and training
    uint32_t batch;              // steps of one
    uint32_t chunk_samples, slice_samples, slice_parts, ray_lanes, grid_texel, rows_texel, skip_zeros, draws_pixels,
        resubmits, scatter;
    bool profile;   // also prints the time of every pass
    bool bits;      // only hashes the records
    bool describe;  // only the device
    bool occupancy; // only lists the dispatches of a step
};

// Chooses the yardstick's workload and then what the words say; returns whether they are known.
bool step_setup_read(int argc, char **argv, struct setup *setup);
void step_setup_print_usage(void);

// Chooses by the kind of device, unless forced.
struct vw_device_choices step_setup_choose(const struct setup *setup, const struct vw_gpu *gpu);

#endif
