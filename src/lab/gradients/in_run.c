// In-Run Data Shapley.
#include <math.h>

#include "lab/gradients/gradient_replay.h"

// The gradient of U is taken behind every step: it is that of the state before the next one.
static void record_steps(const struct gradient_sweep *sweep, uint64_t first_step, uint32_t count) {
    const struct step_replay *replay = &sweep->replay;
    vw_batch_begin(replay->batch);
    if (first_step == 1) gradient_sweep_record_validation(sweep, 0);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t pixel = step_replay_draw(replay, first_step + i, i), row = step_replay_row(replay, i);
        sweep_record_own_step(&sweep->passes, replay->batch, first_step + i, pixel, row);
        sweep_record_multiply(&sweep->passes, replay->batch, false, 2 * i);
        gradient_sweep_record_validation(sweep, row);
        sweep_record_multiply(&sweep->passes, replay->batch, false, 2 * i + 1);
    }
}

static enum vw_status take_steps(struct gradient_sweep *sweep, struct vw_in_run_credit *credits) {
    const struct step_replay *replay = &sweep->replay;
    enum vw_status status = VW_OK;
    while (status == VW_OK && sweep->step < replay->total_steps) {
        uint64_t first = sweep->step + 1, left = replay->total_steps - sweep->step;
        uint32_t count = left < replay->batch_steps ? (uint32_t)left : replay->batch_steps;
        status = gradient_sweep_check_interrupt(sweep);
        if (status != VW_OK) return status;
        record_steps(sweep, first, count);
        status = step_replay_run(replay);
        if (status == VW_OK) status = step_replay_tell(replay, first, count);
        for (uint32_t i = 0; i < count && status == VW_OK; i++) {
            double before = gradient_sweep_read(sweep, 2 * i), after = gradient_sweep_read(sweep, 2 * i + 1);
            credits[sweep->step + i] = (struct vw_in_run_credit){before, (before + after) / 2};
        }
        sweep->step += count;
    }
    return status;
}

enum vw_status vw_in_run_credits(const struct vw_gradient_params *params, struct vw_in_run_credit *credits) {
    struct gradient_sweep sweep = {0};
    enum vw_status status = gradient_sweep_create(params, &sweep);
    if (status == VW_OK) status = take_steps(&sweep, credits);
    gradient_sweep_destroy(&sweep);
    return status;
}
