#include "cli/commands/commands.h"
#include "lab/commands/commands.h"
#include "lab/evaluation/sweep_evaluation.h"

enum vw_status vw_lab_tradeoff(const struct vw_options *options) {
    struct vw_sweep_evaluation evaluation = {.halves = vw_lab_options(options)->halves};
    const struct vw_sweep_follower follower = {vw_sweep_evaluate, &evaluation};
    return vw_tradeoff_make(options, &follower);
}
