// Paired timing: trainings take a few steps each in turn, so that other load on the machine slows all alike. Step times
// of trainings timed together can be compared even on a busy machine.
#ifndef VIEWWORTH_EXPERIMENT_PAIRED_TIMING_H
#define VIEWWORTH_EXPERIMENT_PAIRED_TIMING_H

#include <stdint.h>

#include "base/interrupt.h"
#include "train/trainer.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

enum { VW_TIMING_ROUNDS_MAX = 16 };

// One of the trainings; begins all zero.
struct vw_timed_trainer {
    struct vw_trainer *trainer; // owned
    uint64_t param_count, device_bytes;
    double ms_per_step[VW_TIMING_ROUNDS_MAX];     // wall clock, by round
    double cpu_ms_per_step[VW_TIMING_ROUNDS_MAX]; // all threads
    double psnr_sum_db;                           // validation PSNR of the steps of the last rounds
    uint32_t psnr_count;
};

struct vw_step_timing {
    double ms_per_step, cpu_ms_per_step; // medians over all rounds but the first, which compiles and warms up
    double psnr_db;                      // mean over the steps of the last three rounds; NaN without validation
};

// Creates the trainer, with epochs enough for so many rounds instead of params->config->epochs. In a round it takes two
// submissions of params->steps_per_submission steps, which must not be 0. Close it also after a failure.
enum vw_status vw_timed_trainer_open(const struct vw_trainer_params *params, uint32_t rounds,
                                     struct vw_timed_trainer *timed);
// Times all trainers for `rounds` rounds (4 to VW_TIMING_ROUNDS_MAX). VW_ERROR_INTERRUPTED when the interrupt is
// requested.
enum vw_status vw_paired_timing_run(struct vw_timed_trainer *trainers, uint32_t count, uint32_t rounds,
                                    const struct vw_interrupt *interrupt);
struct vw_step_timing vw_timed_trainer_result(const struct vw_timed_trainer *timed, uint32_t rounds);
void vw_timed_trainer_close(struct vw_timed_trainer *timed);

#endif
