// The prices of the commands that train: how often, and how long on a scene, at every accuracy level.
#ifndef VIEWWORTH_EXPERIMENT_PRICES_H
#define VIEWWORTH_EXPERIMENT_PRICES_H

#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

enum { VW_PRICED_COMMANDS = 5, VW_PRICED_LEVELS = 4 };

// A command that is priced.
struct vw_priced_command {
    const char *name, *words; // "worth"; "worth --retrainings 64", which the price is of
    uint32_t trainings;       // at most
};
extern const struct vw_priced_command vw_priced_commands[VW_PRICED_COMMANDS];

struct vw_level_prices {
    const char *level;
    uint64_t steps;                     // steps of one training
    double seconds[VW_PRICED_COMMANDS]; // NaN: too few steps to measure, or the level does not fit
};

// Measures steps of the scene at every level, with the other options of the config, for a second or two each.
enum vw_status vw_prices_estimate(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_verdict *effects, uint32_t effect_count,
                                  struct vw_level_prices prices[VW_PRICED_LEVELS]);

#endif
