// In-Run Data Shapley.
#include <math.h>

#include "lab/gradients/gradient_replay.h"

// Records steps, and the gradient of U after each: it is that of the state before the next one.
static void record_steps(const struct vw_gradient_replay *gradient_replay, uint64_t first_step, uint32_t count) {
    const struct vw_step_replay *replay = &gradient_replay->replay;
    vw_submission_begin(replay->submission);
    if (first_step == 1) vw_gradient_replay_record_validation(gradient_replay, 0);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t pixel = vw_step_replay_draw(replay, first_step + i, i), row = vw_step_replay_row(replay, i);
        vw_gradient_replay_record_step(gradient_replay, first_step + i, pixel, row);
        vw_gradient_replay_record_multiply(gradient_replay, false, 2 * i);
        vw_gradient_replay_record_validation(gradient_replay, row);
        vw_gradient_replay_record_multiply(gradient_replay, false, 2 * i + 1);
    }
}

static enum vw_status take_steps(struct vw_gradient_replay *gradient_replay, struct vw_in_run_credit *credits) {
    const struct vw_step_replay *replay = &gradient_replay->replay;
    enum vw_status status = VW_OK;
    while (!status && gradient_replay->step < replay->total_steps) {
        uint64_t first = gradient_replay->step + 1, left = replay->total_steps - gradient_replay->step;
        uint32_t count = left < replay->submission_steps ? (uint32_t)left : replay->submission_steps;
        status = vw_gradient_replay_check_interrupt(gradient_replay);
        if (status) return status;
        record_steps(gradient_replay, first, count);
        status = vw_step_replay_run(replay);
        if (!status) status = vw_step_replay_tell(replay, first, count);
        for (uint32_t i = 0; i < count && !status; i++) {
            double before = vw_gradient_replay_read(gradient_replay, 2 * i),
                   after = vw_gradient_replay_read(gradient_replay, 2 * i + 1);
            credits[gradient_replay->step + i] = (struct vw_in_run_credit){before, (before + after) / 2};
        }
        gradient_replay->step += count;
    }
    return status;
}

enum vw_status vw_in_run_credits(const struct vw_gradient_params *params, struct vw_in_run_credit *credits) {
    struct vw_gradient_replay gradient_replay = {0};
    enum vw_status status = vw_gradient_replay_create(params, &gradient_replay);
    if (!status) status = take_steps(&gradient_replay, credits);
    vw_gradient_replay_destroy(&gradient_replay);
    return status;
}
