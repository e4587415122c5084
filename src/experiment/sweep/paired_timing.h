// Trainings that take turns, a few steps each, so that what else the machine does meets all of them alike: what a step
// of one takes beside a step of another can be compared even on a busy machine.
#ifndef VIEWWORTH_TURNS_H
#define VIEWWORTH_TURNS_H

#include <stdint.h>

#include "viewworth/status.h"
#include "train/trainer.h"
#include "viewworth/train.h"

enum { VW_TIMING_ROUNDS_MAX = 16 };

// One of the trainings; begins all zero.
struct vw_timed_trainer {
    struct vw_trainer *trainer; // owned
    uint64_t param_count, device_bytes;
    double ms_per_step[VW_TIMING_ROUNDS_MAX];     // wall clock, by round
    double cpu_ms_per_step[VW_TIMING_ROUNDS_MAX]; // of all of the program's threads
    double psnr_sum_db;                           // validation PSNR of the steps of the last rounds
    uint32_t psnr_count;
};

// What turns have shown.
struct vw_step_timing {
    double ms_per_step, cpu_ms_per_step; // medians over all rounds but the first, which compiles and warms up
    double psnr_db;                      // mean over the steps of the last three rounds; NaN without validation
};

// Creates the trainer, with room for so many rounds whatever params->config->epochs says. A turn is two batches of
// params->steps_per_batch steps, which must be said. Leave it by vw_timed_trainer_close() also after a failure.
enum vw_status vw_timed_trainer_open(const struct vw_trainer_params *params, uint32_t rounds,
                                     struct vw_timed_trainer *timed);
// Lets all take their turns, `rounds` of them (4 to VW_TIMING_ROUNDS_MAX). VW_ERROR_INTERRUPTED when the user asked to
// stop.
enum vw_status vw_paired_timing_run(struct vw_timed_trainer *trainers, uint32_t count, uint32_t rounds);
struct vw_step_timing vw_timed_trainer_result(const struct vw_timed_trainer *timed, uint32_t rounds);
void vw_timed_trainer_close(struct vw_timed_trainer *timed);

#endif
