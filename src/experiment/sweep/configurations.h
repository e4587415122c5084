// Which settings `sweep` tries: the base, as the options have it, and around it one parameter at a time.
#ifndef VIEWWORTH_TRADEOFF_POINTS_H
#define VIEWWORTH_TRADEOFF_POINTS_H

#include <stdint.h>

#include "cli/options.h"
#include "run/session.h"
#include "viewworth/status.h"

enum { VW_CONFIGURATION_NAME_BYTES = 48, VW_CONFIGURATION_VALUE_BYTES = 200, VW_CONFIGURATIONS_MAX = 96 };

struct vw_sweep_configuration {
    char name[VW_CONFIGURATION_NAME_BYTES];   // "base", "rays-125": also its folder's name
    const char *parameter;                    // "base", "rays", ...; static
    char value[VW_CONFIGURATION_VALUE_BYTES]; // "125"; of the base, all of them: "rays 500, samples 32, ..."
    struct vw_config config;                  // of the first seed; effects are spelled out as the base decided them
    uint32_t downscale;
};

struct vw_sweep_configurations {
    struct vw_sweep_configuration configurations[VW_CONFIGURATIONS_MAX];
    uint32_t count; // the first is the base
    uint32_t full_resolution,
        all_pixels; // the configurations of these names; UINT32_MAX where `all_pixels` is not tried
};

// What can be turned, for messages and --help.
#define VW_SWEEP_PARAMETERS                                                                                            \
    "rays, samples, val-rays, levels, log2-table, width, epochs, table-precision, downscale, effects, accuracy"
// VW_ERROR_USAGE unless `parameters` is NULL (all of them) or names of parameters with commas between.
enum vw_status vw_sweep_check_parameters(const char *parameters);
// Lists the configurations for the options and a session on which effects are decided. Settings that the config does
// not admit, or that come to the same as another, are left out. The full_resolution configuration is always there: all
// validation pixels, and twice the rays where the device admits them.
enum vw_status vw_sweep_configurations_list(const struct vw_options *options, const struct vw_session *session,
                                            struct vw_sweep_configurations *configurations);

#endif
