// The configurations that a sweep tries: the base, and around it configurations with one parameter changed.
#ifndef VIEWWORTH_EXPERIMENT_SWEEP_CONFIGURATIONS_H
#define VIEWWORTH_EXPERIMENT_SWEEP_CONFIGURATIONS_H

#include <stdint.h>

#include "run/session.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

enum { VW_CONFIGURATION_NAME_BYTES = 48, VW_CONFIGURATION_VALUE_BYTES = 256, VW_CONFIGURATIONS_MAX = 96 };

struct vw_sweep_configuration {
    char name[VW_CONFIGURATION_NAME_BYTES];   // "base", "rays-125": also its folder's name
    const char *parameter;                    // "base", "full_resolution", "rays", ...; static
    char value[VW_CONFIGURATION_VALUE_BYTES]; // "125"; of the base, all parameters: "rays 500, samples 32, ..."
    struct vw_config config;                  // first seed; effects are spelled out as decided at the base
};

struct vw_sweep_configurations {
    struct vw_sweep_configuration configurations[VW_CONFIGURATIONS_MAX];
    uint32_t count;           // the first is the base
    uint32_t full_resolution; // all validation pixels, and twice the rays where the device admits them
};

// The parameters, for messages and --help.
#define VW_SWEEP_PARAMETERS                                                                                            \
    "rays, samples, importance-samples, val-rays, levels, log2-table, mlp-depth, width, epochs, "                      \
    "learning-rate-decay, effects, accuracy"
// Reads names of parameters with commas between as a set of bits. VW_ERROR_USAGE names a word that is none.
enum vw_status vw_sweep_parameters_parse(const char *list, uint32_t *parameters);
// Lists the configurations around a base, for a session whose effects are decided. `parameters`: a set of bits; 0: all.
// Values that the config does not admit, or that equal another configuration, are left out. `downscale` is for the
// description of the base.
enum vw_status vw_sweep_configurations_list(const struct vw_config *base, uint32_t downscale, uint32_t parameters,
                                            const struct vw_session *session,
                                            struct vw_sweep_configurations *configurations);
// Returns the folder of a configuration's runs in OUT, owned by the caller; NULL when memory is short.
char *vw_sweep_folder(const char *out, const struct vw_sweep_configuration *configuration);

#endif
